"""A cost over a grid, and paths of least cost through it."""

import itertools
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

_STENCIL = {
    (0, 1): (),
    (1, 0): (),
    (1, 1): ((0, 1), (1, 0)),
    (1, -1): ((0, -1), (1, 0)),
    (1, 2): ((0, 1), (1, 1)),
    (2, 1): ((1, 0), (1, 1)),
    (1, -2): ((0, -1), (1, -1)),
    (2, -1): ((1, 0), (1, -1)),
}
"""Moves between cells, each with the cells that it passes."""

_FINE = 0.25
"""Distance of the points at which the cost along a line is taken, in cells."""

_SWEEPS, _GAIN = 8, 1e-4
"""How often corners are moved at most, and what that must spare for it to go on."""

_MANY = 160
"""Corners of a path between which all straight lines are tried."""


class CostField(NamedTuple):
    """A cost per length over a grid, NaN where no path may go.

    **Attributes:**

    - `lines`: coordinates of the cells along both axes, equidistant.
    - `weights`: what a unit of each axis counts as a length.
    - `price`: the cost of each cell.
    """

    lines: list[Float[np.ndarray, " n"]]
    weights: Float[np.ndarray, "2"]
    price: Float[np.ndarray, "n_0 n_1"]

    @property
    def spacing(self) -> Float[np.ndarray, "2"]:
        return np.array([line[1] - line[0] for line in self.lines])

    def nearest(self, point: Float[np.ndarray, "2"]) -> tuple[int, int]:
        """The cell nearest to a point."""
        i, j = (int(np.argmin(np.abs(c - x))) for c, x in zip(self.lines, point, strict=True))
        return i, j

    def distance(
        self, ones: Float[np.ndarray, "*k 2"], others: Float[np.ndarray, "*k 2"]
    ) -> Float[np.ndarray, "*k"]:
        """Lengths of straight lines."""
        return np.linalg.norm((others - ones) * self.weights, axis=-1)

    def at(self, points: Float[np.ndarray, "k 2"]) -> Float[np.ndarray, " k"]:
        """The cost between cells, bilinear; NaN beside a cell where no path may go."""
        last = np.array(self.price.shape) - 1
        spots = np.clip((points - [line[0] for line in self.lines]) / self.spacing, 0, last)
        low = np.minimum(spots.astype(int), last - 1)
        part = np.round(spots - low, 9)
        total = np.zeros(len(points))
        for corner in itertools.product((0, 1), repeat=2):
            share = np.prod(np.where(corner, part, 1.0 - part), axis=1)
            price = self.price[tuple((low + corner).T)]
            total += np.where(share > 0.0, share * price, 0.0)
        return total

    def along(self, one: Float[np.ndarray, "2"], other: Float[np.ndarray, "2"]) -> float:
        """The integral along a straight line, infinite where it may not go."""
        cells = np.max(np.abs(other - one) / self.spacing)
        count = max(2, int(np.ceil(cells / _FINE)) + 1)
        values = self.at(np.linspace(one, other, count))
        mean = (np.sum(values) - 0.5 * (values[0] + values[-1])) / (count - 1)
        return float(self.distance(one, other) * mean) if np.isfinite(mean) else np.inf

    def path(
        self, start: Float[np.ndarray, "2"], goal: Float[np.ndarray, "2"]
    ) -> tuple[Float[np.ndarray, "k 2"], float] | None:
        """Corners of the path of least cost, and what it costs; nothing where there is none."""
        cells = self._cheapest(self.nearest(start), self.nearest(goal))
        if cells is None:
            return None
        centers = np.stack([line[i] for line, i in zip(self.lines, cells.T, strict=True)], axis=1)
        corners, cost = self._straightened(np.concatenate([start[None], centers, goal[None]]))
        for _ in range(_SWEEPS):
            before = cost
            corners, cost = self._straightened(self._relaxed(corners))
            if cost > (1.0 - _GAIN) * before:
                break
        return corners, cost

    def _cheapest(self, start: tuple[int, int], goal: tuple[int, int]) -> np.ndarray | None:
        """Cells from start to goal, `(k, 2)`, or nothing."""
        price, shape = self.price, self.price.shape
        number = np.arange(price.size).reshape(shape)
        edges = []
        for move, passed in _STENCIL.items():
            own, others = (_shifted(shape, move, by) for by in ((0, 0), move))
            through = [price[own], price[others]]
            through += [price[_shifted(shape, move, by)] for by in passed]
            # NaN where it would pass a cell that is not open.
            cost = np.mean(through, axis=0) * np.linalg.norm(self.spacing * self.weights * move)
            fits = np.isfinite(cost)
            # What costs nothing would be no edge in a sparse matrix.
            edges.append((number[own][fits], number[others][fits], np.maximum(cost[fits], 1e-300)))
        rows, columns, costs = (np.concatenate(part) for part in zip(*edges, strict=True))
        graph = coo_array((costs, (rows, columns)), shape=(price.size, price.size)).tocsr()
        begin, end = number[start], number[goal]
        far, before = dijkstra(graph, directed=False, indices=begin, return_predecessors=True)
        if not np.isfinite(far[end]):
            return None
        chain = [end]
        while chain[-1] != begin:
            chain.append(before[chain[-1]])
        return np.stack(np.unravel_index(chain[::-1], shape), axis=1)

    def _straightened(
        self, chain: Float[np.ndarray, "k 2"]
    ) -> tuple[Float[np.ndarray, "c 2"], float]:
        """The path of least cost that goes straight between points of a chain, and its cost."""
        count = len(chain)
        some = np.unique(np.linspace(0, count - 1, min(count, _MANY)).astype(int))
        best, before = np.full(count, np.inf), np.zeros(count, int)
        best[0] = 0.0
        for j in range(1, count):
            origins = some[some < j] if j in some else np.empty(0, int)
            for i in np.union1d(origins, [j - 1]):
                cost = self.along(chain[i], chain[j])
                if i == j - 1 and not np.isfinite(cost):
                    cost = self._beside(chain[i], chain[j])
                # Of paths that cost the same, the one of fewer corners.
                if best[i] + cost < best[j] * (1.0 - 1e-12):
                    best[j], before[j] = best[i] + cost, i
        corners = [count - 1]
        while corners[-1] > 0:
            corners.append(before[corners[-1]])
        return chain[corners[::-1]], float(best[-1])

    def _relaxed(self, corners: Float[np.ndarray, "c 2"]) -> Float[np.ndarray, "c 2"]:
        """Corners that are each moved, once in turn, to where the lines to both sides cost least.

        Those of a chain are in cells, and its lines have a few directions only.
        """
        corners, stride = corners.copy(), self.spacing
        for k in range(1, len(corners) - 1):
            before, here, after = corners[k - 1 : k + 2]

            now = self.along(before, here) + self.along(here, after)
            if not np.isfinite(now):
                continue

            def total(point, before=before, after=after, most=10.0 * now):
                # The search takes differences, which infinite ones have not.
                return min(self.along(before, point) + self.along(point, after), most)

            simplex = here + stride * [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
            close = {"xatol": 0.02 * np.min(stride), "fatol": 1e-6 * now, "maxiter": 60}
            options = {"initial_simplex": simplex, **close}
            found = minimize(total, here, method="Nelder-Mead", options=options)
            if found.fun < now and np.all(np.abs(found.x - here) < 10.0 * stride):
                corners[k] = found.x
        return corners

    def _beside(self, one: Float[np.ndarray, "2"], other: Float[np.ndarray, "2"]) -> float:
        """What it costs between neighbours that are beside a cell where no path may go."""
        return float(
            self.distance(one, other)
            * np.mean([self.price[self.nearest(one)], self.price[self.nearest(other)]])
        )


def _shifted(shape: tuple[int, int], move: tuple[int, int], by: tuple[int, int]):
    """The part of a grid that is `by` further than where a move may begin."""
    return tuple(
        slice(max(0, -step) + shift, size - max(0, step) + shift)
        for size, step, shift in zip(shape, move, by, strict=True)
    )
