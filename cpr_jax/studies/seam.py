"""Where a map of one value a cell must jump."""

import numpy as np
from jaxtyping import Bool, Int

from ..statics.status import Status
from .front import OFFSETS, Front

_SEAM = 0.05
"""Neighbours that differ by this much from what their slopes say are followed into each other."""

_ROWS = 16
"""Of a grid, how many are looked at together."""


def seam_of(front: Front, stride: int = 1) -> Bool[np.ndarray, "n_0 n_1"]:
    """Cells beside a neighbour that the branch does not lead to directly.

    Where a branch overlaps itself, as it does behind a cusp of its folds, a map of one value
    a cell must jump somewhere. Neighbours whose difference their slopes do not explain are
    followed into each other; those who do not meet are on the seam.
    """
    seam = np.zeros_like(front.solved)
    doubtful = np.concatenate([_doubtful(front, axis, stride) for axis in (0, 1)])
    if len(doubtful) == 0:
        return seam[front.inner]
    met, elsewhere = np.zeros((2, len(doubtful)), bool)
    for k in range(2):
        source, goal = doubtful[:, k], doubtful[:, 1 - k]
        found = front.follow(source, goal)
        apart = np.max(np.abs(found.y - front.y[tuple(goal.T)]), axis=1) > 1e-6
        arrived = found.status == Status.SOLVED
        met |= arrived & ~apart
        elsewhere |= arrived & apart
    # Beside a fold one direction may end where the other does not.
    for cells in doubtful[elsewhere | ~met].swapaxes(0, 1):
        seam[tuple(cells.T)] = True
    return seam[front.inner]


def _doubtful(front: Front, axis: int, stride: int) -> Int[np.ndarray, "pairs 2 2"]:
    """Solved neighbours along an axis whose difference their slopes do not explain."""
    h = stride * front.grid.spacing[axis]
    found = []
    # Few rows at a time: what is worked on stays in the cache of a core.
    for begin in range(0, len(front.solved), _ROWS):
        rows = slice(begin, begin + _ROWS)
        low: tuple[slice, ...] = (rows, slice(None, -stride))
        high: tuple[slice, ...] = (rows, slice(stride, None))
        if axis == 0:
            high = (slice(begin + stride, begin + stride + _ROWS),)
            low = (slice(begin, begin + len(front.solved[high])),)
        both = front.solved[low] & front.solved[high]
        if not np.any(both):
            continue
        rates = front.slope[low][..., axis] + front.slope[high][..., axis]
        apart = front.y[high] - front.y[low] - 0.5 * h * rates
        far = np.argwhere(both & (np.max(np.abs(apart), axis=-1) > _SEAM)) + np.array([begin, 0])
        found.append(np.stack([far, far + stride * OFFSETS[2 * axis]], axis=1))
    return np.concatenate(found) if found else np.zeros((0, 2, 2), int)
