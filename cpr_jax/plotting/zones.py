"""Zones of a workspace map that are hatched, and the legend of what a map shows."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from ..statics.status import Status
from .style import BLACK, GREY, VERMILION

LINES = {"t2_line": ("Type 2", VERMILION), "t1_line": ("Type 1", BLACK)}
"""Name in a legend and colour of the singular curves."""


class Zone(NamedTuple):
    """Cells of a map that are hatched alike."""

    name: str
    cells: Bool[np.ndarray, "n_0 n_1"]
    pattern: str
    colour: str
    ground: str

    def draw(self, ax: Axes, edges: tuple[np.ndarray, np.ndarray]) -> None:
        """Hatches the cells, whose edges are given along both axes."""
        if not np.any(self.cells):
            return
        with plt.rc_context({"hatch.linewidth": 0.6}):
            look: Any = {"fc": "none", "ec": self.colour, "lw": 0.0, "hatch": self.pattern}
            ax.add_patch(PathPatch(_outline(self.cells, edges), zorder=1.5, **look))

    def patch(self) -> Patch:
        """What stands for it in a legend."""
        return Patch(fc=self.ground, ec=self.colour, hatch=self.pattern, label=self.name, lw=0.0)


def zones_of(dataset: xr.Dataset) -> list[Zone]:
    """What a map may have: cells without an equilibrium, unstable ones, ones beyond a limit."""
    solved, status = dataset["index"].values >= 0, dataset["status"].values
    open_ = ~solved & (status == Status.NOT_CONVERGED)
    without = ~solved & ~open_ & (status != Status.OUT_OF_REACH)
    limited = status == Status.BEYOND_LIMITS
    unstable = solved & (dataset["stable"].values == 0)
    return [
        Zone("beyond a fold", without, "xxxxx", GREY, "white"),
        Zone("without an answer", open_, "-----", GREY, "white"),
        Zone("unstable", unstable, "////", "white", "#414d6b"),
        Zone("beyond a limit", limited, "....", "white", "#414d6b"),
    ]


def legend_of(lines: xr.Dataset | None, zones: Sequence[Zone]) -> list[Any]:
    """Handles for a legend of the lines of a map, if they are drawn, and of zones that it has."""
    handles: list[Any] = [
        plt.Line2D([], [], color=colour, lw=1.4, label=name)
        for line, (name, colour) in LINES.items()
        if lines is not None and np.any(np.isfinite(lines[line].values))
    ]
    return handles + [zone.patch() for zone in zones if np.any(zone.cells)]


def edges_of(centers: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n+1"]:
    """Where cells around these places end: halfway to their neighbours."""
    middles = 0.5 * (centers[1:] + centers[:-1])
    first, last = 2.0 * centers[0] - middles[0], 2.0 * centers[-1] - middles[-1]
    return np.concatenate([[first], middles, [last]])


def _outline(cells: np.ndarray, edges: tuple[np.ndarray, np.ndarray]) -> Path:
    """Rectangles around all runs of cells along the second axis."""
    padded = np.pad(cells.astype(np.int8), ((0, 0), (1, 1)))
    steps = np.diff(padded, axis=1)
    row, begin = np.nonzero(steps == 1)
    end = np.nonzero(steps == -1)[1]
    left, right = edges[0][row], edges[0][row + 1]
    low, high = edges[1][begin], edges[1][end]
    corners = [(left, low), (right, low), (right, high), (left, high), (left, low)]
    points = np.stack([np.stack(corner, axis=1) for corner in corners], axis=1)
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    return Path(points.reshape(-1, 2), np.tile(codes, len(row)))
