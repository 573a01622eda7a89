"""Where a map of one value a cell must jump."""

import numpy as np
from jaxtyping import Bool

from ..statics.status import Status
from .front import OFFSETS, Front

_SEAM = 0.05
"""Neighbours that differ by this much from what their slopes say are followed into each other."""


def seam_of(front: Front, stride: int = 1) -> Bool[np.ndarray, "n_0 n_1"]:
    """Cells beside a neighbour that the branch does not lead to directly.

    Where a branch overlaps itself, as it does behind a cusp of its folds, a map of one value
    a cell must jump somewhere. Neighbours whose difference their slopes do not explain are
    followed into each other; those who do not meet are on the seam.
    """
    seam = np.zeros_like(front.solved)
    pairs = []
    for offset in OFFSETS[[0, 2]]:
        here = np.argwhere(front.solved)
        there = here + stride * offset
        both = front.solved[tuple(there.T)]
        here, there = here[both], there[both]
        p = tuple(here.T)
        far = front.mismatch(here, front.y[p], front.slope[p], there) > _SEAM
        pairs.append(np.stack([here[far], there[far]], axis=1))
    doubtful = np.concatenate(pairs)
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
