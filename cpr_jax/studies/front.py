"""A branch spread over a grid, many cells at once."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int8
from scipy.ndimage import distance_transform_edt

from ..errors import InputError
from ..statics.advance import Nearby
from ..statics.continuation import DEVIATION
from ..statics.reach import hardly_metres, used_up
from ..statics.status import Status
from ..statics.unknowns import unknown_scales
from .follower import Follower
from .grid import Grid

_MISMATCH = 0.01
"""Largest distance from what the slopes at both ends of a step say it should be."""

OFFSETS = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1)])
"""From a cell to its neighbours."""

_PAIRS = ((0, 1), (2, 3), (4, 5), (6, 7))


class SeedApart(InputError):
    """The branch does not lead from the seed to the grid."""


class Front:
    """The equilibria of one branch on a grid, followed outward from a seed.

    First on a coarse lattice, each cell predicted from the neighbours that are solved, then on
    finer and finer ones, where most cells lie between two solved ones and a cubic through both
    predicts them to many digits. What fails at once is tried again whenever another neighbour
    is solved, and at last followed from a neighbour in small steps, to where the branch folds.

    A step counts if it converges near its prediction, agrees with the slopes at both of its
    ends, and keeps the sign of `det ∂R/∂y`.

    **Attributes** (arrays over the grid with a margin; `inner` cuts it off):

    - `y`: dimensionless unknowns; `slope`: their derivatives along the axes.
    - `solved`: which cells are; `wanted`: which are to be.
    - `gone`: cells for which motors would have to draw in more than there is of a rod.
    - `sign`: of `det ∂R/∂y` on the branch.
    - `fresh`: places that the last pass has solved; `None` where all of a lattice is to be tried.
    """

    def __init__(
        self,
        follower: Follower,
        grid: Grid,
        seed: Float[np.ndarray, " n_y"],
        stride: int = 1,
    ):
        self.follower, self.grid = follower, grid
        self.units = np.asarray(unknown_scales(follower.robot))
        strides = 0.05 / float(np.max(grid.spacing / self.units[list(grid.axes)]))
        # The margin is as wide: on a small grid it must not be most of what is kept.
        strides = min(strides, max(grid.shape) / 4.0)
        self.coarsest = max(stride, 2 ** int(np.log2(max(strides, 1.0))))
        margin = self.margin = self.coarsest
        shape = tuple(n + 2 * margin for n in grid.shape)
        self.inner = tuple(slice(margin, -margin) for _ in shape)
        self.point = np.zeros((*shape, 2))
        self.point[self.inner] = grid.points
        self.inside = np.zeros(shape, bool)
        self.inside[self.inner] = True
        self.wanted = self.inside.copy()
        self.y = np.zeros((*shape, seed.size))
        self.slope = np.zeros((*shape, seed.size, 2))
        self.solved = np.zeros(shape, bool)
        self.tried = np.zeros(shape, np.uint16)
        self.stalled = np.zeros(shape, bool)
        self.gone = np.zeros(shape, bool)
        self.stage = 0
        self.fresh: np.ndarray | None = None
        self.sign = 0.0
        self.seed = self._plant(seed)

    def _plant(self, seed) -> tuple[int, int]:
        """Follows the seed to the cell nearest to it."""
        begin = (seed * self.units)[list(self.grid.axes)]
        cell = self.grid.nearest(begin)
        goal = self.grid.points[cell]
        found = self._creep_along(seed[None], begin[None], goal[None])
        place = (cell[0] + self.margin, cell[1] + self.margin)
        self._put(np.array([place]), found, found.status == Status.SOLVED)
        if not self.solved[place]:
            status = Status.OUT_OF_REACH if self.gone[place] else Status(int(found.status[0]))
            robot = self.follower.robot
            positions = np.array(self.grid.axes) - robot.n_a
            straight = (positions >= 0) & (positions < robot.geometry.d)
            hint = hardly_metres(robot, self.grid.box[:, straight])
            raise SeedApart(
                "Argument `box` must lie beside the seed, by default the home of the robot, but "
                f"the branch does not reach its nearest cell {goal.tolist()}: {status.message}."
                + (f" {hint}" if hint else "")
            )
        self.sign = float(found.sign[0])
        return place

    def state(self) -> dict[str, Any]:
        """What a run needs to go on from here."""
        names = ("y", "slope", "solved", "tried", "stalled", "gone")
        return {name: getattr(self, name) for name in names} | {"stage": np.array(self.stage)}

    def restore(self, state: dict[str, Any]) -> None:
        """Goes back to a `state`."""
        for name in ("y", "slope", "solved", "tried", "stalled", "gone"):
            getattr(self, name)[...] = state[name]
        self.stage = int(state["stage"])

    def spread(
        self, report: Callable[[int], None], keep: Callable[[], None], finest: int = 1
    ) -> None:
        """Solves every cell that the branch reaches on the lattice of this stride.

        **Arguments:**

        - `finest`: a power of two; a later call goes on with a smaller one.
        - `report`: called with the number of cells solved so far.
        - `keep`: called between two batches, when `state` may be saved.
        """
        self.fresh = None
        while True:
            stride = self.coarsest >> self.stage
            if not self._pass(stride):
                if stride > finest:
                    self.tried[...] = 0
                    self.fresh = None
                    self.stage += 1
                elif not self._creep(stride):
                    return
            report(int(np.count_nonzero(self.solved)))
            keep()

    def lattice(self, stride: int) -> Bool[np.ndarray, "n_0 n_1"]:
        """Every cell that is a multiple of the stride away from the seed, with the margin."""
        lattice = np.zeros_like(self.inside)
        lattice[self.seed[0] % stride :: stride, self.seed[1] % stride :: stride] = True
        return lattice

    def _unsolved(self, stride: int) -> np.ndarray:
        return np.argwhere(self.lattice(stride) & self.wanted & ~self.solved)

    def _beside_fresh(self, stride: int) -> np.ndarray:
        """As `_unsolved`, but only beside cells that the last pass has solved: no others have new
        neighbours, and a pass costs as much as it tries, however large the grid is."""
        assert self.fresh is not None
        beside = (self.fresh[:, None] + stride * OFFSETS).reshape(-1, 2)
        places = np.ravel_multi_index(tuple(beside.T), self.solved.shape)
        open_ = self.wanted.ravel()[places] & ~self.solved.ravel()[places]
        # Few are open on a fine lattice: what is sorted to find them once each is short.
        places = np.unique(places[open_])
        return np.stack(np.unravel_index(places, self.solved.shape), axis=1)

    def _pass(self, stride: int) -> bool:
        """Tries all cells that have new solved neighbours; says whether there were any."""
        at = self._unsolved(stride) if self.fresh is None else self._beside_fresh(stride)
        beside = at[:, None] + stride * OFFSETS
        have = self.solved[beside[..., 0], beside[..., 1]]
        bits = np.sum(have << np.arange(8), axis=1).astype(np.uint16)
        new = (bits & ~self.tried[at[:, 0], at[:, 1]]) != 0
        self.fresh = at[:0]
        if not np.any(new):
            return False
        at, beside, have = at[new], beside[new], have[new]
        self.tried[at[:, 0], at[:, 1]] |= bits[new]
        guess, sources, order = self._predict(at, beside, have)
        # Batches of alike lanes: the best predicted need the fewest iterations.
        at, guess, sources = at[order], guess[order], sources[order]
        goals = self.grid.targets(self.point[at[:, 0], at[:, 1]])
        found = self.follower.advance(guess, goals)
        good = (found.status == Status.SOLVED) & (found.sign == self.sign)
        good &= found.deviation < DEVIATION
        for k in range(2):
            good &= self.mismatch(at, found.y, found.slope, sources[:, k]) < _MISMATCH
        self._put(at, found, good)
        return True

    def _predict(self, at, beside, have):
        """Predictions, best first: between two neighbours, else along the slope of one."""
        guess = np.zeros((len(at), self.y.shape[-1]))
        sources = np.zeros((len(at), 2), int)
        open_ = np.ones(len(at), bool)
        rank = np.full(len(at), len(_PAIRS))
        for number, (first, second) in enumerate(_PAIRS):
            use = have[:, first] & have[:, second] & open_
            p, q = (tuple(beside[use, k].T) for k in (first, second))
            way = self.point[q] - self.point[p]
            bend = np.einsum("lnk,lk->ln", self.slope[p] - self.slope[q], way)
            guess[use] = 0.5 * (self.y[p] + self.y[q]) + 0.125 * bend
            sources[use] = (first, second)
            rank[use] = number
            open_ &= ~use
        for k in range(8):
            use = have[:, k] & open_
            p = tuple(beside[use, k].T)
            way = self.point[tuple(at[use].T)] - self.point[p]
            guess[use] = self.y[p] + np.einsum("lnk,lk->ln", self.slope[p], way)
            sources[use] = k
            open_ &= ~use
        lanes = np.arange(len(at))
        places = np.stack([beside[lanes, sources[:, k]] for k in range(2)], axis=1)
        return guess, places, np.argsort(rank, kind="stable")

    def mismatch(self, at, y, slope, source) -> np.ndarray:
        """Distance of a step from the mean of the slopes at its ends (trapezoidal rule)."""
        p = tuple(source.T)
        way = self.point[tuple(at.T)] - self.point[p]
        expected = 0.5 * np.einsum("lnk,lk->ln", slope + self.slope[p], way)
        return np.max(np.abs(y - self.y[p] - expected), axis=1)

    def _creep(self, stride: int) -> bool:
        """Follows the branch into cells that fail at once, from one new neighbour each."""
        at = self._unsolved(stride)
        at = at[~self.gone[tuple(at.T)]]
        beside = at[:, None] + stride * OFFSETS[:4]
        bits = 1 << (8 + np.arange(4))
        untried = (self.tried[at[:, 0], at[:, 1]][:, None] & bits) == 0
        cell, side = np.nonzero(self.solved[beside[..., 0], beside[..., 1]] & untried)
        cell, first = np.unique(cell, return_index=True)
        if len(cell) == 0:
            return False
        side = side[first]
        at, source = at[cell], beside[cell, side]
        self.tried[at[:, 0], at[:, 1]] |= bits[side].astype(np.uint16)
        found = self.follow(source, at)
        self._put(at, found, (found.status == Status.SOLVED) & (found.sign == self.sign))
        self.stalled[tuple(at.T)] |= found.status == Status.NOT_CONVERGED
        return True

    def follow(self, source, at) -> Nearby:
        """Follows the branch from solved cells to others, in steps as small as they need be."""
        cells, goals = tuple(source.T), tuple(at.T)
        return self._creep_along(self.y[cells], self.point[cells], self.point[goals])

    def _creep_along(self, start, begin, goal) -> Nearby:
        ways = self.grid.targets(begin), self.grid.targets(goal)
        return self.follower.creep(start, *ways)

    def _put(self, at, found: Nearby, good) -> None:
        """Adds equilibria; those with a rod that is used up are none, and nothing goes on there."""
        robot = self.follower.robot
        q_a = found.y[:, : robot.n_a] * self.units[: robot.n_a]
        gone = good & np.asarray(used_up(robot, q_a))
        self.gone[tuple(at[gone].T)] = True
        good = good & ~gone
        cells = tuple(at[good].T)
        self.y[cells], self.slope[cells] = found.y[good], found.slope[good]
        self.solved[cells] = True
        self.fresh = at[good]

    def ended(self) -> Int8[np.ndarray, "n_0 n_1"]:
        """Why the branch does not come to cells without an equilibrium.

        What was tried is judged by that, the others like the nearest that was.
        """
        judged = ((self.tried >> 8 != 0) | self.gone) & ~self.solved
        why = np.full(self.solved.shape, int(Status.BEYOND_FOLD), np.int8)
        why[self.stalled] = Status.NOT_CONVERGED
        why[self.gone] = Status.OUT_OF_REACH
        if np.any(judged & (why != Status.BEYOND_FOLD)):
            _, nearest = distance_transform_edt(~judged, return_indices=True)
            why = why[tuple(nearest)]
        return why[self.inner]
