"""Where a map is refined, and which cell stands for which."""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.ndimage import maximum_filter

from .front import Front

_STEEP = 1.25
"""Ratio of the sensitivities of two neighbours between which the map is refined."""


def refined(
    front: Front, size: Float[np.ndarray, "n_0 n_1"], stride: int
) -> Bool[np.ndarray, "n_0 n_1"]:
    """Cells within a stride of two neighbours that differ much, or of which one has no solution.

    **Arguments:**

    - `size`: the sensitivity, NaN where unsolved; like the result over the grid with its margin.
    - `stride`: distance of neighbours; only cells that are `wanted` on its lattice are compared.
    """
    known = front.lattice(stride) & front.wanted
    at = np.argwhere(known)
    steep = np.zeros_like(known)
    log = np.log(size)
    for offset in ((stride, 0), (0, stride)):
        here = at[known[tuple((at + offset).T)]]
        there = here + offset
        p, q = tuple(here.T), tuple(there.T)
        edge = front.solved[p] != front.solved[q]
        differ = edge | (np.abs(log[p] - log[q]) > np.log(_STEEP))
        for cells in (here[differ], there[differ]):
            steep[tuple(cells.T)] = True
    return maximum_filter(steep, 2 * stride + 1) & front.inside


def representatives(
    front: Front, wanted: dict[int, np.ndarray]
) -> tuple[tuple[Int[np.ndarray, "n_0 n_1"], Int[np.ndarray, "n_0 n_1"]], np.ndarray]:
    """The cell that stands for each cell of the grid, and how often its spacing was halved.

    A cell of a coarse lattice stands for the block around it, less what finer ones stand for; where
    the grid ends before the next one, for what is left.

    **Arguments:**

    - `wanted`: by stride, coarsest first, the cells that were to be solved on its lattice.
    """
    shape = front.inside.shape
    coarsest = front.lattice(next(iter(wanted))) & front.inside
    nearest = [_nearest(np.flatnonzero(np.any(coarsest, axis=1 - k)), shape[k]) for k in (0, 1)]
    places = np.stack(np.meshgrid(*nearest, indexing="ij"), axis=-1)
    level = np.zeros(shape, np.int8)
    for number, (stride, mask) in enumerate(wanted.items()):
        at = np.argwhere(front.lattice(stride) & mask)
        reach = range(-(stride // 2), stride - stride // 2)
        for i in reach:
            for j in reach:
                cells = at[:, 0] + i, at[:, 1] + j
                places[cells], level[cells] = at, number
    inner = places[front.inner] - front.margin
    return (inner[..., 0], inner[..., 1]), level[front.inner]


def _nearest(lines: Int[np.ndarray, " lines"], count: int) -> Int[np.ndarray, " count"]:
    """For each of `count` places the nearest of some ascending ones, between two the upper."""
    middles = -(-(lines[:-1] + lines[1:]) // 2)
    return lines[np.searchsorted(middles, np.arange(count), side="right")]
