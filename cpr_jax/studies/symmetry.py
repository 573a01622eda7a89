"""Whether a robot is its own mirror image."""

from collections.abc import Sequence

import jax
import numpy as np
from jaxtyping import Array, Float

from ..analysis.entries import Common
from ..analysis.parameters import Selection
from ..geometry import floats
from ..programs import program
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium, base_wrenches
from ..statics.measures import motor_torques
from ..statics.problem import forward_rows
from ..statics.status import Status
from ..statics.unknowns import unknown_scales, unravel
from .follower import Follower
from .grid import Grid
from .limits import Limits

_ALIKE = 1e-7
"""Wrenches and poses that differ by less, relatively, are the same."""

_NUDGE = 1e-3
"""Of a parameter or its half range, by how much it is changed to see what it does."""

_EVEN = 1e-4
"""Kernels of ellipsoids that differ by less, relatively, are the same, as seen by differences."""


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
    wrenches, torques = map(np.asarray, _forces(robot, y))
    right, left = wrenches
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
    # Motors behind unequal gears are none.
    efforts = np.sort(np.abs(torques), axis=1)
    if np.max(np.abs(efforts[1] - efforts[0])) > _ALIKE * max(size, np.max(efforts)):
        return False
    if limits is not None:
        motors = np.sort([part[:n_a] / units[:n_a] for part in y], axis=1)
        if limits.motors is not None and np.max(np.abs(motors[1] - motors[0])) > _ALIKE:
            return False
        if not _are_limited_alike(robot, limits, twins):
            return False
    if selection is None:
        return True
    if not _vary_alike(robot, selection, delta, twins):
        return False
    # In space the frames of round rods may lie anywhere about their tangents: what is the same
    # number of two legs need not be its mirror image.
    return geometry.d == 2 or _spread_alike(follower, found.y[:2], selection, delta, pose)


def _are_limited_alike(robot: Robot, limits: Limits, twins: Sequence[int]) -> bool:
    """Whether the motor of each leg has the limits of that on the other side."""
    bounds = limits.of_motors(robot.n_a)
    if np.all(bounds == bounds[:, :1]):
        return True
    of_legs = robot.n == robot.n_a and np.array_equal(robot.transmission, np.eye(robot.n))
    return of_legs and np.array_equal(bounds[:, list(twins)], bounds)


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


def _spread_alike(follower: Follower, ys, selection: Selection, delta, pose) -> bool:
    """Whether the platform's ellipsoids at two mirrored equilibria are mirror images.

    By differences, with the program that follows the branch.
    """
    robot, n_a = follower.robot, follower.robot.n_a
    held = follower._replace(imposed=forward_rows(robot))
    goals = (ys * np.asarray(unknown_scales(robot)))[:, : n_a + robot.n_p]
    rho, moves = np.asarray(selection.get(robot)), []
    for k in np.flatnonzero(delta):
        step = _NUDGE * max(abs(rho[k]), delta[k]) * (np.arange(len(rho)) == k)
        ends = [
            held._replace(robot=_varied(robot, selection, floats(end))).advance(ys, goals)
            for end in (rho + step, rho - step)
        ]
        if any(np.any(end.status != Status.SOLVED) for end in ends):
            return False
        moves.append((ends[0].y - ends[1].y)[:, n_a : n_a + robot.n_p] * delta[k] / step[k])
    if not moves:
        return True
    right, left = np.einsum("kwi,kwj->wij", moves, moves)
    return bool(np.max(np.abs(left * np.outer(pose, pose) - right)) <= _EVEN * np.max(right))


@program
def _varied(robot: Robot, selection: Selection, rho: Float[Array, " n_rho"]) -> Robot:
    return selection.set(robot, rho)


@program
def _forces(
    robot: Robot, ys: Float[Array, "ways n_y"]
) -> tuple[Float[Array, "ways n freedoms"], Float[Array, "ways n_a"]]:
    """Base wrenches and motor torques."""

    def one(y):
        return base_wrenches(robot, unravel(robot, y)), motor_torques(robot, y)

    return jax.vmap(one)(ys)
