"""Whether a robot is its own mirror image."""

from collections.abc import Sequence

import jax
import numpy as np
from jaxtyping import Array, Float

from ..analysis.entries import Common
from ..analysis.parameters import Selection
from ..programs import program
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium, base_wrenches
from ..statics.status import Status
from ..statics.unknowns import unknown_scales, unravel
from .follower import Follower
from .grid import Grid
from .limits import Limits

_ALIKE = 1e-7
"""Wrenches and poses that differ by less, relatively, are the same."""


def is_mirror_symmetric(
    follower: Follower,
    seed: Equilibrium,
    grid: Grid,
    imposed: Sequence[int],
    selection: Selection | None = None,
    delta: Float[np.ndarray, " n_rho"] | None = None,
    limits: Limits | None = None,
) -> bool:
    """Whether a branch is mirrored where the first coordinate of a map turns its sign.

    Judged by what the robot does rather than by how it is described: the branch is followed to
    two mirrored points, where the base wrenches of the legs must be mirror images, pair by pair.
    Maps whose first coordinate is a rotation, or that reach further to one side, count as not
    symmetric; nor do those of a robot whose parameters vary otherwise on one side, or whose motors
    are limited and not at the same positions on both.

    **Arguments:**

    - `selection`, `delta`: the parameters that vary and their half ranges, if any do.
    - `limits`: of the motors and rods, if there are any.
    """
    robot = follower.robot
    geometry, n_a = robot.geometry, robot.n_a
    name = grid.names[0]
    if name not in geometry.axes:
        return False
    line = grid.coordinates[0]
    if abs(line[0] + line[-1]) > 0.5 * grid.spacing[0]:
        return False
    vectors, turns = geometry.mirror(name)
    units = np.asarray(unknown_scales(robot))
    begin = np.concatenate([seed.q_a, seed.q_p])
    goals = np.tile(begin, (2, 1))
    length = np.mean(np.asarray(robot.legs.rod.length))
    goals[:, grid.axes[0]] = np.array([1.0, -1.0]) * 0.05 * length
    # Coordinates that the map holds must be their own mirror images.
    held = [place for place in imposed if place not in grid.axes]
    signs = np.concatenate([np.ones(n_a), vectors, turns])[held]
    if np.any(np.abs((signs - 1.0) * begin[held]) > _ALIKE * units[held]):
        return False
    starts = np.tile(np.asarray(seed.y) / units, (2, 1))
    found = follower.creep(starts, np.tile(begin, (2, 1)), goals)
    if np.any(np.asarray(found.status) != Status.SOLVED):
        return False
    y = np.asarray(found.y)[:2] * units
    right, left = np.asarray(_wrenches(robot, y))
    moved = [part[n_a : n_a + robot.n_p] / units[n_a : n_a + robot.n_p] for part in y]
    pose = np.concatenate([vectors, turns])[: robot.n_p]
    if np.max(np.abs(moved[1] * pose - moved[0])) > _ALIKE:
        return False
    mirrored = left * np.concatenate([vectors, turns])
    size = np.max(np.abs(right))
    free, twins = list(range(robot.n)), []
    for wrench in mirrored:
        gaps = [np.max(np.abs(wrench - right[k])) for k in free]
        if min(gaps) > _ALIKE * size:
            return False
        twins.append(free.pop(int(np.argmin(gaps))))
    if limits is not None and limits.motors is not None:
        motors = np.sort([part[:n_a] / units[:n_a] for part in y], axis=1)
        if np.max(np.abs(motors[1] - motors[0])) > _ALIKE:
            return False
    return selection is None or _vary_alike(robot, selection, delta, twins)


def _vary_alike(robot: Robot, selection: Selection, delta, twins: Sequence[int]) -> bool:
    """Whether each number of a leg varies as much as that of the leg on the other side."""
    known = {}
    for entry, half_range in zip(selection.entries, delta, strict=True):
        # All legs at once are their own mirror image.
        if isinstance(entry, Common):
            continue
        known[type(entry), entry.path, entry.place(robot), entry.reciprocal] = half_range
    for (kind, path, index, reciprocal), half_range in known.items():
        if path in ("f_P", "m_P") or half_range == 0.0:
            continue
        if not path.startswith("legs."):
            return False
        twin = known.get((kind, path, (twins[index[0]], *index[1:]), reciprocal), np.nan)
        if not abs(twin - half_range) <= _ALIKE * half_range:
            return False
    return True


@program
def _wrenches(robot: Robot, ys: Float[Array, "ways n_y"]) -> Float[Array, "ways n freedoms"]:
    return jax.vmap(lambda y: base_wrenches(robot, unravel(robot, y)))(ys)
