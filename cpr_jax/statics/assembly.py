"""A robot is put together at its home configuration, and moved from there."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import floats
from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Steps
from .continuation import Track
from .linear import solve_with_sign
from .problem import forward_rows
from .residual import residual
from .status import Status
from .unknowns import State, ravel, unknown_scales
from .ways import follow_path, straight

_DAMPING = 1e-4
"""Beside the squares of a leg's flexibilities, in units of `scales(robot)`."""

_ASIDE = 1e-4
"""Length of the differences that tell how a leg gives, dimensionless."""

_FURTHEST = 3.0
"""Largest base wrench of a bent leg, in the same units: bends of about a radian."""


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
        corners = straight(y[:n_q], goal)
        track = follow_path(robot, rows, y, corners, steps)
        return jnp.where(track.status == Status.SOLVED, track.y, jnp.nan), track

    # A loop over both ways keeps one copy of them in the compiled program.
    tasks = jnp.stack([forward_rows(robot), imposed]), jnp.stack([rough, goal])
    _, tracks = jax.lax.scan(stage, apart, tasks)
    home, moved = (jax.tree.map(lambda leaf, k=k: leaf[k], tracks) for k in range(2))
    status = jnp.where(home.status == Status.SOLVED, moved.status, home.status)
    return home, moved._replace(status=status)


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
