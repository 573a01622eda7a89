"""Whether a robot is its own mirror image."""

import jax.numpy as jnp
import numpy as np

from ..robots.robot import Robot
from ..rods.solver import Steps
from ..statics.equilibrium import Equilibrium
from ..statics.problem import inverse_rows
from ..statics.status import Status
from ..statics.unknowns import unknown_scales, unravel
from .creeping import creep
from .grid import Grid


def is_mirror_symmetric(robot: Robot, seed: Equilibrium, grid: Grid, steps: Steps) -> bool:
    """Whether the branch of an equilibrium is the mirror image of itself about the axis y = 0.

    Judged by what the robot does rather than by how it is described: the branch is followed to
    two mirrored points, where the base wrenches of the legs must be mirror images, pair by pair.
    Only maps over (y, z) of planar robots with a point as platform are looked at; others count as
    not symmetric.
    """
    # A platform whose coordinates are the axes of the map is a point of the plane.
    if grid.names != ("y", "z") or robot.n_p != 2 or robot.n_a != 2:
        return False
    units = np.asarray(unknown_scales(robot))
    aside = 0.05 * float(jnp.mean(robot.legs.rod.length))
    begin = np.concatenate([np.zeros(robot.n_a), np.asarray(seed.q_p)])
    goals = np.tile(begin, (2, 1))
    goals[:, robot.n_a] = (aside, -aside)
    starts = np.tile(np.asarray(seed.y) / units, (2, 1))
    axes = (robot.n_a, robot.n_a + 1)
    found = creep(robot, inverse_rows(robot), axes, starts, np.tile(begin, (2, 1)), goals, steps)
    if np.any(np.asarray(found.status) != Status.SOLVED):
        return False
    right, left = (unravel(robot, jnp.asarray(y * units)).mu for y in np.asarray(found.y)[:2])
    # A mirror turns the sign of forces along y and of moments; forces along z stay.
    mirrored = np.asarray(left) * np.array([-1.0, 1.0, -1.0])
    size = np.max(np.abs(np.asarray(right)))
    free = list(range(robot.n))
    for wrench in mirrored:
        gaps = [np.max(np.abs(wrench - np.asarray(right)[k])) for k in free]
        if not gaps or min(gaps) > 1e-7 * size:
            return False
        free.pop(int(np.argmin(gaps)))
    return True
