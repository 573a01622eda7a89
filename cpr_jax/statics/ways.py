"""Ways along which an equilibrium is followed while imposed coordinates move."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Steps
from .continuation import Corrected, Track, follow
from .correction import settle
from .problem import Problem
from .residual import residual
from .status import Status
from .unknowns import unknown_scales, unravel


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
    gap = gap_of(robot, start, steps)
    corners = jnp.concatenate([corners[:1], corners])
    open_ = jnp.zeros((corners.shape[0], 1)).at[0].set(1.0)

    def correct(predicted, _, h, dh, reach):
        problem = Problem(robot, imposed, h[1:], h[0] * gap)
        # Minus the derivative of R along the path.
        shift = jnp.concatenate([dh[0] * gap, imposed @ (dh[1:] / units[:n_q])])
        found = settle(problem, predicted, shift[:, None], steps, reach=reach)
        return Corrected(found.y, found.converged, found.sign, found.slope[:, 0])

    track = follow(correct, start / units, jnp.concatenate([open_, corners], axis=1))
    return track._replace(y=track.y * units)


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


def straight(begin, goal):
    """A line with a corner in its middle, in the form that detours bend."""
    return jnp.stack([begin, 0.5 * (begin + goal), goal])


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


def gap_of(robot: Robot, y: Float[Array, " n_y"], steps: Steps) -> Float[Array, " n_r"]:
    """`R₀` at unknowns that need not be an equilibrium."""
    return residual(robot, unravel(robot, y), steps)
