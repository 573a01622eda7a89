"""Cold starts in many ways at once, of which the equilibrium of least energy is taken."""

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
from .assembly import at_rest, from_home, reaching
from .continuation import Track
from .energy import potential_energy
from .periods import motor_spans
from .reach import used_up
from .status import Status
from .unknowns import base_freedoms, unknown_scales

SEARCH_STARTS = 64
"""Starts of a systematic search, a power of two."""

_LIGHT, _LOOSE = 0.5, 0.05
"""Largest base wrenches, and largest motions of passive joints, of legs bent at random, in units of
`unknown_scales`."""


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
    if robot.legs.feed is not None:
        # Of what lies behind a rod that is drawn in to nothing the energy is no measure.
        motors = np.stack([np.asarray(track.y)[: robot.n_a] for track in tracks])
        some = arrived & ~np.asarray(used_up(robot, motors))
        arrived = some if np.any(some) else arrived
    if not np.any(arrived):
        return tracks[0]._replace(status=jnp.asarray(int(otherwise)))
    energies = np.asarray(_energies(robot, np.stack([track.y for track in tracks]), steps))
    return tracks[int(np.argmin(np.where(arrived, energies, np.inf)))]


@program
def _energies(robot, ys, steps):
    return jax.vmap(lambda y: potential_energy(robot, y, steps))(ys)
