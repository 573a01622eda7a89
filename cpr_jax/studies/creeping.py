"""Many ways along a branch at once, at once where that works and step by step where not."""

import numpy as np
from jaxtyping import Array, Float

from ..robots.robot import Robot
from ..rods.solver import Steps
from ..statics.advance import Nearby, advance
from ..statics.continuation import DEVIATION
from ..statics.status import Status
from .parallel import in_parallel, on_devices, padded

LANES = 128
"""Ways in one call of a compiled program."""

_FIRST = 0.3
_SHORTEST = 5e-3
_ROUNDS = 60


def advance_all(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    axes: tuple[int, ...],
    guess: Float[np.ndarray, "ways n_y"],
    goal: Float[np.ndarray, "ways n_q"],
    steps: Steps,
) -> Nearby:
    """`advance` for any number of ways, in batches of one size, in numpy."""

    places = on_devices((robot, imposed))
    # As an array: Python numbers would be compiled in.
    scheme = np.asarray(steps)

    def batch(k: int) -> Nearby:
        lanes = [padded(part[k : k + LANES], LANES) for part in (guess, goal)]
        here, rows = places[k // LANES % len(places)]
        found = advance(here, rows, axes, lanes[0], lanes[1], scheme)
        return Nearby(*(np.asarray(leaf) for leaf in found))

    parts = in_parallel(batch, range(0, len(guess), LANES))
    return Nearby(*(np.concatenate(leaf)[: len(guess)] for leaf in zip(*parts, strict=True)))


def creep(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    axes: tuple[int, ...],
    start: Float[np.ndarray, "ways n_y"],
    begin: Float[np.ndarray, "ways n_q"],
    goal: Float[np.ndarray, "ways n_q"],
    steps: Steps,
) -> Nearby:
    """Follows the branch from `begin` to `goal` in steps as small as they need be.

    A step counts if it converges near its tangent prediction and keeps the sign of the Jacobian's
    determinant. A way ends where steps shorter than 0.5 % of it would be needed: at a fold.

    **Returns:** the last point on the branch of each way; its status is `SOLVED` at the goal,
    `LOST` at a fold, `NOT_CONVERGED` where even the start is no equilibrium or steps ran out.
    """
    now = advance_all(robot, imposed, axes, start, begin, steps)
    now = Nearby(*(leaf.copy() for leaf in map(np.asarray, now)))
    status = np.full(len(start), int(Status.NOT_CONVERGED))
    progress, stride = np.zeros(len(start)), np.full(len(start), _FIRST)
    going = np.flatnonzero(now.status == Status.SOLVED)
    for _ in range(_ROUNDS):
        if len(going) == 0:
            break
        # Land on the goal rather than leave a sliver.
        end = progress[going] + stride[going]
        end = np.where(end > 1.0 - _SHORTEST, 1.0, end)
        taken = (end - progress[going])[:, None]
        way = (goal - begin)[going]
        moved = np.einsum("lnk,lk->ln", now.slope[going], (taken * way)[:, list(axes)])
        target = begin[going] + end[:, None] * way
        new = advance_all(robot, imposed, axes, now.y[going] + moved, target, steps)
        good = (new.status == Status.SOLVED) & (new.sign == now.sign[going])
        good &= new.deviation < DEVIATION
        for leaf, found in zip(now, new, strict=True):
            leaf[going[good]] = np.asarray(found)[good]
        progress[going[good]] = end[good]
        growth = 0.7 * np.sqrt(DEVIATION / np.maximum(new.deviation, 1e-12))
        stride[going] = taken[:, 0] * np.where(good, np.clip(growth, 0.3, 3.0), 0.3)
        status[going[progress[going] >= 1.0]] = Status.SOLVED
        status[going[stride[going] < _SHORTEST]] = Status.LOST
        going = going[(progress[going] < 1.0) & (stride[going] >= _SHORTEST)]
    return now._replace(status=status)
