"""The solutions of a map as a surface, and the singular curves on it."""

import numpy as np

from ..analysis.singularity import SingularityType, trace_curves
from ..parallel import in_parallel
from ..robots.robot import Robot
from ..statics.unknowns import unknown_scales
from .grid import Grid

_SAME_SHEET = 0.3
"""Largest difference of the motors, dimensionless, between a curve and the cells around it, where
cells lie close together; elsewhere twice the difference that is rare among neighbours."""

_RARE = 90.0
"""Per cent of the neighbours that differ by less."""


def singular_lines(
    robot, grid: Grid, imposed: tuple[int, ...], y, solved, sign, steps: int
) -> dict[str, list[np.ndarray]]:
    """Singular curves of both kinds on the sheet that the map shows, as points on the axes."""
    sheet = _Sheet(robot, grid, y, solved)

    def traced(kind: SingularityType) -> list[np.ndarray]:
        of_motors = kind is SingularityType.TYPE_1
        starts, along = sheet.rim() if of_motors else sheet.crossings(sign)
        curves = trace_curves(
            robot,
            kind,
            starts * sheet.units,
            along,
            grid.axes,
            box=grid.box,
            spacing=float(np.max(grid.spacing)),
            imposed=imposed,
            belongs=sheet.shows,
            steps=steps,
        )
        return [curve.y[:, list(grid.axes)] for curve in curves]

    kinds = SingularityType.TYPE_1, SingularityType.TYPE_2
    return dict(zip(("t1_line", "t2_line"), in_parallel(traced, kinds), strict=True))


class _Sheet:
    """The solutions of a map as a surface over its grid."""

    def __init__(self, robot: Robot, grid: Grid, y, solved) -> None:
        self.grid, self.solved, self.n_a = grid, solved, robot.n_a
        self.axes = list(grid.axes)
        self.units = np.asarray(unknown_scales(robot))
        self.y = np.where(solved[..., None], y, np.nan) / self.units
        gaps = np.concatenate([np.ravel(self._gaps(axis)) for axis in (0, 1)])
        gaps = gaps[np.isfinite(gaps)]
        rare = float(np.percentile(gaps, _RARE)) if len(gaps) else 0.0
        self.alike = max(_SAME_SHEET, 2.0 * rare)

    def _gaps(self, axis: int) -> np.ndarray:
        """By how much the motors of neighbours along an axis differ."""
        low, high = (_along(axis, part) for part in (slice(None, -1), slice(1, None)))
        return np.max(np.abs(self.y[low] - self.y[high])[..., : self.n_a], axis=-1)

    def crossings(self, sign):
        """Middles of the edges at whose ends a sign differs, on one sheet; and their axis."""
        starts, along = [], []
        for axis in (0, 1):
            low, high = (_along(axis, part) for part in (slice(None, -1), slice(1, None)))
            changes = (sign[low] * sign[high] < 0.0) & (self._gaps(axis) < self.alike)
            starts.append(0.5 * (self.y[low] + self.y[high])[changes])
            along.append(np.full(len(starts[-1]), axis))
        return np.concatenate(starts), np.concatenate(along)

    def rim(self):
        """Solved cells beside an unsolved one within the grid, and the axis across."""
        starts, along = [], []
        for axis in (0, 1):
            for side in (-1, 1):
                beside = np.roll(self.solved, -side, axis=axis)
                beside[_along(axis, slice(-1, None) if side == 1 else slice(0, 1))] = True
                starts.append(self.y[self.solved & ~beside])
                along.append(np.full(len(starts[-1]), axis))
        return np.concatenate(starts), np.concatenate(along)

    def shows(self, z: np.ndarray) -> np.ndarray:
        """Whether points of curves lie on the sheet that the cells around them are on."""
        places = z[:, self.axes] * self.units[self.axes]
        origin, spacing = self.grid.box[0], self.grid.spacing
        nearest = np.rint((places - origin) / spacing).astype(int)
        best = np.full(len(z), np.inf)
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                cell = np.clip(nearest + np.array([i, j]), 0, np.array(self.grid.shape) - 1)
                # Wrenches change like a square root beside a fold, motors less.
                there = self.y[cell[:, 0], cell[:, 1], : self.n_a]
                gap = np.max(np.abs(there - z[:, : self.n_a]), axis=1)
                best = np.fmin(best, np.where(np.isnan(gap), np.inf, gap))
        return best < self.alike


def _along(axis: int, part: slice) -> tuple[slice, slice]:
    """An index that cuts one of two axes."""
    return (part, slice(None)) if axis == 0 else (slice(None), part)
