"""Cold starts: from a robot's home configuration, or from a systematic search."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import floats
from ..parallel import in_parallel
from ..programs import program
from ..robots.robot import Home, Robot
from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Steps
from .continuation import Corrected, Track, follow
from .correction import settle
from .energy import potential_energy
from .linear import solve_with_sign
from .periods import motor_spans
from .problem import Problem, forward_rows
from .residual import residual
from .status import Status
from .unknowns import State, base_freedoms, ravel, unknown_scales, unravel

SEARCH_STARTS = 64
"""Starts of a systematic search, a power of two."""

_DAMPING = 1e-4
"""Beside the squares of a leg's flexibilities, in units of `scales(robot)`."""

_ASIDE = 1e-4
"""Length of the differences that tell how a leg gives, dimensionless."""

_FURTHEST = 3.0
"""Largest base wrench of a bent leg, in the same units: bends of about a radian."""


_LIGHT, _LOOSE = 0.5, 0.05
"""Largest base wrenches, and largest motions of passive joints, of legs bent at random, in units of
`unknown_scales`."""


_FACTORS = 2.0 ** np.linspace(-3.0, 3.0, 33)
"""By which wrenches of a neighbour are scaled, and ..."""

_NEAR = 2.0 ** (np.array([[0.1875], [0.0375], [0.0]]) * np.linspace(-1.0, 1.0, 11))
"""... how far on to both sides around those of which the joints gape less than at the next ones."""


def follow_path(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    start: Float[Array, " n_y"],
    corners: Float[Array, "points n_q"],
    steps: Steps = DEFAULT_STEPS,
) -> Track:
    """Follows an equilibrium while imposed coordinates move along a polygon to its last corner.

    What `start` lacks to an equilibrium, since it belongs to a robot with other numbers or to one
    whose joints are cut, is closed first, along a line and on the branch.

    **Arguments:**

    - `imposed`: see `Problem`.
    - `start`: unknowns in SI units at `corners[0]`.
    """
    units = unknown_scales(robot)
    n_q = robot.n_a + robot.n_p
    gap = _gap(robot, start, steps)
    corners = jnp.concatenate([corners[:1], corners])
    open_ = jnp.zeros((corners.shape[0], 1)).at[0].set(1.0)

    def correct(predicted, _, h, dh):
        problem = Problem(robot, imposed, h[1:], h[0] * gap)
        # Minus the derivative of R along the path.
        shift = jnp.concatenate([dh[0] * gap, imposed @ (dh[1:] / units[:n_q])])
        found = settle(problem, predicted, shift[:, None], steps)
        return Corrected(found.y, found.converged, found.sign, found.slope[:, 0])

    track = follow(correct, start / units, jnp.concatenate([open_, corners], axis=1))
    return track._replace(y=track.y * units)


def assemble_and_move(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    rough: Float[Array, " n_q"],
    mu: Float[Array, "n freedoms"],
    goal: Float[Array, " n_q"],
    steps: Steps = DEFAULT_STEPS,
) -> tuple[Track, Track]:
    """Assembles a robot at a rough configuration `(q_a, q_p)`, then moves it to a goal.

    With its joints cut, the rods under any base wrenches, or at rest, are an exact solution of
    the rod equations. While the motors are held, the gaps at the joints, and what the platform
    lacks to equilibrium, close along a line and the platform is free to give: the way one would
    put the robot together by hand.

    **Arguments:**

    - `mu`: the unknowns of the legs, see `State`, before the joints are closed.

    **Returns:** both tracks. A robot that does not assemble does not move either: the second
    has the status of the first.
    """
    n_q = robot.n_a + robot.n_p
    apart = ravel(State(rough[: robot.n_a], rough[robot.n_a :], mu))

    def stage(y, task):
        rows, goal = task
        corners = _straight(y[:n_q], goal)
        track = follow_path(robot, rows, y, corners, steps)
        return jnp.where(track.status == Status.SOLVED, track.y, jnp.nan), track

    # A loop over both ways keeps one copy of them in the compiled program.
    tasks = jnp.stack([forward_rows(robot), imposed]), jnp.stack([rough, goal])
    _, tracks = jax.lax.scan(stage, apart, tasks)
    home, moved = (jax.tree.map(lambda leaf, k=k: leaf[k], tracks) for k in range(2))
    status = jnp.where(home.status == Status.SOLVED, moved.status, home.status)
    return home, moved._replace(status=status)


def _straight(begin, goal):
    """A line with a corner in its middle, in the form that detours bend."""
    return jnp.stack([begin, 0.5 * (begin + goal), goal])


@program
def from_home(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    mu: Float[Array, "n freedoms"],
    goal: Float[Array, " n_q"],
    steps: Steps,
) -> tuple[Track, Track]:
    """`assemble_and_move` from the robot's home configuration."""
    assert robot.home is not None
    rough = jnp.concatenate([robot.home.q_a, robot.home.q_p])
    return assemble_and_move(robot, imposed, rough, mu, goal, steps)


def at_rest(robot: Robot) -> Float[Array, "n freedoms"]:
    """Legs as they are before their joints are closed."""
    return floats(np.zeros((robot.n, robot.geometry.freedoms)))


@program
def reaching(robot: Robot, rough: Float[Array, " n_q"], steps: Steps) -> Float[Array, "n freedoms"]:
    """Legs bent by themselves towards where their joints are, by the linear theory of their rods.

    Straight inextensible rods at rest form a robot that resists in its own ways only: it has no
    tangent along which its joints could close. A damped step leaves out what a rod cannot follow.
    """
    n, freedoms = robot.n, robot.geometry.freedoms
    q_a, q_p = jnp.split(rough, [robot.n_a])
    units = unknown_scales(robot)[rough.size :].reshape(n, freedoms)

    def rows(bend):
        """Of all joints, `(n, d + r)`, where all legs have these dimensionless unknowns."""
        R_0 = residual(robot, State(q_a, q_p, bend * units), steps)
        return R_0[robot.n_p :].reshape(n, freedoms)

    # Rows of a joint know the unknowns of its own leg only: all legs move at once. A guess needs no
    # exact derivatives, which take several times as long to compile; a loop takes what single
    # solves have traced already.
    aside = _ASIDE * np.eye(freedoms)
    places = jnp.asarray(np.concatenate([np.zeros((1, freedoms)), aside, -aside]))
    missing, *beside = jax.lax.map(rows, places)
    ahead, behind = jnp.split(jnp.stack(beside, axis=-1), 2, axis=-1)
    own = (ahead - behind) / (2.0 * _ASIDE)

    def bent(J, missing):
        damped = J.T @ J + _DAMPING * jnp.eye(freedoms)
        change, _ = solve_with_sign(damped, -J.T @ missing)
        return change / jnp.maximum(1.0, jnp.max(jnp.abs(change)) / _FURTHEST)

    return units * jax.vmap(bent)(own, missing)


def from_home_at_random(
    robot: Robot, imposed: Float[Array, "n_a n_q"], goal: Float[Array, " n_q"], steps: Steps
) -> Track:
    """As `from_home`, from legs that are bent a little at random: of many the least in energy.

    Straight rods that are pushed into place have no way to go before they are bent, to whichever
    side. Where none arrives the status tells whether any assembles.
    """
    assert robot.home is not None
    rough = np.concatenate([robot.home.q_a, robot.home.q_p])
    units = np.asarray(unknown_scales(robot))[rough.size :].reshape(robot.n, -1)
    most = np.where(np.asarray(base_freedoms(robot)) > 0.5, _LOOSE, _LIGHT)
    random = np.random.default_rng(0).uniform(-1.0, 1.0, (SEARCH_STARTS, *units.shape))
    found = _from_each([robot] * SEARCH_STARTS, imposed, floats(most * units * random), goal, steps)
    any_assembled = any(int(home.status) == Status.SOLVED for home, _ in found)
    otherwise = Status.LOST if any_assembled else Status.NOT_ASSEMBLED
    return _least(robot, [track for _, track in found], otherwise, steps)


@program
def from_neighbour(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    y: Float[Array, " n_y"],
    goal: Float[Array, " n_q"],
    steps: Steps,
) -> tuple[Float[Array, " n_y"], Track]:
    """Follows the branch of an equilibrium, of this robot or of one like it, to a goal.

    **Returns:** where the way begins, see `fitted`, and the way.
    """
    start = fitted(robot, y, steps)
    begin = start[: robot.n_a + robot.n_p]
    return start, follow_path(robot, imposed, start, _straight(begin, goal), steps)


@program
def move(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    start: Float[Array, " n_y"],
    corners: Float[Array, "points n_q"],
    steps: Steps,
) -> Track:
    """`follow_path` from where an equilibrium is."""
    begin = start[None, : robot.n_a + robot.n_p]
    return follow_path(robot, imposed, start, jnp.concatenate([begin, corners]), steps)


def fitted(robot: Robot, y: Float[Array, " n_y"], steps: Steps = DEFAULT_STEPS) -> Array:
    """Unknowns of a robot with other numbers, their wrenches scaled to where its joints gape least.

    A softer rod that carried the old wrenches would bend further than the branch allows. What the
    platform lacks to its equilibrium does not count: another load on it is no reason for the rods
    to have another shape, and to follow it is what the way is for.
    """
    state = unravel(robot, y)
    moves = base_freedoms(robot) > 0.5

    def strained(factor):
        return jnp.where(moves, state.mu, factor * state.mu)

    def missing(factor):
        scaled = ravel(state._replace(mu=strained(factor)))
        left = jnp.max(jnp.abs(_gap(robot, scaled, steps)[robot.n_p :]))
        return jnp.where(jnp.isfinite(left), left, jnp.inf)

    def closer(factors, near):
        gaps = jax.vmap(missing)(factors)
        beside = jnp.pad(gaps, 1, constant_values=jnp.inf)
        lowest = (gaps <= beside[:-2]) & (gaps <= beside[2:])
        _, places = jax.lax.top_k(
            jnp.where(lowest, -gaps, -jnp.inf), len(_FACTORS) // _NEAR.shape[1]
        )
        around = factors[places, None] * near
        return around.reshape(-1), factors[jnp.argmin(gaps)]

    # The right valley is so narrow that between two factors a wrong one may look deeper. A loop
    # keeps one copy of the integration in the compiled program.
    _, best = jax.lax.scan(closer, jnp.asarray(_FACTORS), jnp.asarray(_NEAR))
    return ravel(state._replace(mu=strained(best[-1])))


def _gap(robot: Robot, y: Float[Array, " n_y"], steps: Steps) -> Float[Array, " n_r"]:
    """`R₀` at unknowns that need not be an equilibrium."""
    return residual(robot, unravel(robot, y), steps)


def search_starts(robot: Robot, count: int = SEARCH_STARTS) -> Float[Array, "starts n_q"]:
    """Rough configurations that cover what a robot may look like (a Sobol sequence).

    Motors that turn take every angle, motors that slide half a rod length either way, see
    `motor_spans`; the platform is in the middle of the motors, at most a rod length away, its
    orientation within half a turn.
    """
    # Importing it takes half a second, and few robots lack a home configuration.
    from scipy.stats import qmc

    units = np.asarray(unknown_scales(robot))[: robot.n_a + robot.n_p]
    unit_cube = qmc.Sobol(units.size, scramble=False).random(count)
    spread = 2.0 * unit_cube - 1.0
    spread[:, : robot.n_a] *= motor_spans(robot) / units[: robot.n_a]
    spread[:, robot.n_a + robot.geometry.d :] *= np.pi / 2.0
    middle = np.zeros(units.size)
    d = robot.geometry.d
    middle[robot.n_a : robot.n_a + d] = np.mean(np.asarray(robot.legs.base_position), axis=0)
    return jnp.asarray(middle + units * spread)


def detours(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    start: Float[Array, " n_y"],
    goal: Float[Array, " n_q"],
    lost: Track,
    steps: Steps = DEFAULT_STEPS,
) -> Track:
    """Other ways to a goal that a straight line does not reach; `lost` if none does.

    The line is bent in its middle to either side, by a half and by a whole of its length, in
    each direction of the platform's position (of the motors, for the forward problem).
    """
    n_q = robot.n_a + robot.n_p
    first = start[:n_q]
    platform = bool(jnp.any(imposed[:, robot.n_a :]))
    low, high = (robot.n_a, robot.n_a + robot.geometry.d) if platform else (0, robot.n_a)
    line = (goal - first)[low:high]
    span = jnp.linalg.norm(line)
    _, _, basis = jnp.linalg.svd(line[None] / jnp.where(span > 0.0, span, 1.0))
    for size in (0.5, -0.5, 1.0, -1.0):
        for sideways in basis[1:]:
            middle = 0.5 * (first + goal)
            middle = middle.at[low:high].add(size * span * sideways)
            track = move(robot, imposed, start, jnp.stack([middle, goal]), steps)
            if int(track.status) == Status.SOLVED:
                return track
    return lost


def search(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    goal: Float[Array, " n_q"],
    steps: Steps = DEFAULT_STEPS,
) -> Track:
    """Assembles a robot in many configurations, follows each, keeps the least energy."""
    starts = np.asarray(search_starts(robot))
    configurations = [map(floats, np.split(start, [robot.n_a])) for start in starts]
    homes = [dataclasses.replace(robot, home=Home(*parts)) for parts in configurations]
    found = _from_each(homes, imposed, [at_rest(robot)] * len(homes), goal, steps)
    if all(int(track.status) != Status.SOLVED for _, track in found):
        bent = [reaching(robot, start, steps) for start in starts]
        found = _from_each(homes, imposed, bent, goal, steps)
    return _least(robot, [track for _, track in found], Status.NOT_FOUND, steps)


def _from_each(homes, imposed, legs, goal, steps) -> list[tuple[Track, Track]]:
    """`from_home` of several robots, each with its unknowns of the legs.

    One by one: ways differ so much in length that a batch would wait for its longest most of the
    time, and the program of a single one is there already.
    """

    def one(task) -> tuple[Track, Track]:
        robot, mu = task
        return jax.tree.map(np.asarray, from_home(robot, imposed, mu, goal, steps))

    return in_parallel(one, zip(homes, legs, strict=True))


def _least(robot: Robot, tracks: list[Track], otherwise: Status, steps: Steps) -> Track:
    """The track of least energy among those that have arrived, or a status."""
    arrived = np.array([int(track.status) == Status.SOLVED for track in tracks])
    if not np.any(arrived):
        return tracks[0]._replace(status=jnp.asarray(int(otherwise)))
    energies = np.asarray(_energies(robot, np.stack([track.y for track in tracks]), steps))
    return tracks[int(np.argmin(np.where(arrived, energies, np.inf)))]


@program
def _energies(robot, ys, steps):
    return jax.vmap(lambda y: potential_energy(robot, y, steps))(ys)
