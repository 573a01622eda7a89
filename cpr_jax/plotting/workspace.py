"""Workspace maps: Figure 3 of the paper, and maps of any variable."""

import re
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Patch

from ..robots.robot import Robot
from ..statics.status import Status
from .style import BLACK, GREY, ORANGE, PAGE, VERMILION

_LOGARITHMIC = ("semi_axis_max", "semi_axis_min", "ellipse_area", "sigma_t1", "sigma_t2")
_LENGTHS = ("semi_axis_max", "semi_axis_min")


def plot_map(
    dataset: xr.Dataset,
    variable: str = "semi_axis_max",
    ax: Axes | None = None,
    *,
    robot: Robot | None = None,
    lines: bool = True,
    unstable: bool = True,
    colorbar: bool = True,
    **mesh: Any,
) -> Axes:
    """A variable of a workspace map in colours, with the singular lines and unstable zones.

    Lengths are shown in mm. Every cell has one colour: nothing is interpolated. Cells within
    reach but without an equilibrium are hatched.

    **Arguments:**

    - `dataset`: of `workspace_map`.
    - `variable`: one with the two coordinates as dimensions.
    - `robot`: draws its base.
    - `lines`, `unstable`: draw `t1_line` and `t2_line`; hatch cells that are not stable.
    - `mesh`: for `matplotlib`'s `pcolormesh`, such as `norm` or `cmap`.
    """
    if ax is None:
        ax = plt.subplots()[1]
    first, second = (str(name) for name in dataset["status"].dims)
    factor = [1e3 if dataset[name].attrs["units"] == "m" else 1.0 for name in (first, second)]
    x, z = (f * dataset[name].values for f, name in zip(factor, (first, second), strict=True))
    data = dataset[variable]
    values = data.values.astype(float) * (1e3 if variable in _LENGTHS else 1.0)
    solved = dataset["index"].values >= 0
    shown = np.where(solved, values, np.nan)
    if "norm" not in mesh and variable in _LOGARITHMIC:
        low, high = np.nanpercentile(shown, [0.5, 99.5])
        mesh["norm"] = LogNorm(low, high)
    elif "norm" not in mesh:
        mesh["norm"] = Normalize(*np.nanpercentile(shown, [0.5, 99.5]))
    mesh = {"cmap": "viridis", "rasterized": True, "shading": "nearest", **mesh}
    drawn = ax.pcolormesh(x, z, shown.T, **mesh)

    within = ~solved & (dataset["status"].values != Status.OUT_OF_REACH)
    _hatch(ax, x, z, within, "xxxxx", GREY)
    if unstable:
        _hatch(ax, x, z, solved & (dataset["stable"].values == 0), "////", "white")
    if lines:
        for name, colour in (("t1_line", BLACK), ("t2_line", VERMILION)):
            for curve in dataset[name].values:
                ax.plot(*(curve * factor).T, color=colour, lw=1.1, zorder=4)
    if robot is not None and robot.geometry.d == 2:
        motors = np.asarray(robot.legs.base_position) * factor
        ax.plot(*motors.T, "o", ms=5, mfc="white", mec=BLACK, mew=1.2, zorder=6)
    ax.set_aspect("equal")
    ax.set_xlabel(_axis_label(dataset, first))
    ax.set_ylabel(_axis_label(dataset, second))
    if colorbar:
        unit = "mm" if variable in _LENGTHS else data.attrs.get("units", "1")
        text = re.sub(r"\bA_([pq])\b", r"$\\mathbf{A}_\1$", data.attrs.get("long_name", variable))
        label = text if unit == "1" else f"{text} ({unit})"
        ax.figure.colorbar(drawn, ax=ax, label=label, extend="both", location="bottom", pad=0.02)
    return ax


def plot_ellipses(dataset: xr.Dataset, points: np.ndarray, ax: Axes, scale: float = 1.0) -> None:
    """The uncertainty ellipses of a planar map at the cells nearest to points (m)."""
    first, second = (str(name) for name in dataset["status"].dims)
    for point in points:
        cell = dataset.sel({first: point[0], second: point[1]}, method="nearest")
        direction = cell["direction"].values
        if not np.all(np.isfinite(direction)):
            continue
        ax.add_patch(
            Ellipse(
                (1e3 * float(cell[first]), 1e3 * float(cell[second])),
                2e3 * scale * float(cell["semi_axis_max"]),
                2e3 * scale * float(cell["semi_axis_min"]),
                angle=float(np.rad2deg(np.arctan2(direction[1], direction[0]))),
                fc=ORANGE,
                ec=BLACK,
                lw=0.5,
                zorder=5,
            )
        )


def figure_3(dataset: xr.Dataset, robot: Robot, points: np.ndarray) -> Figure:
    """Figure 3: sensitivity and distance to a Type 2 singularity over half the workspace."""
    figure = figure_of_map(dataset, robot)
    plot_ellipses(dataset, points, figure.axes[0])
    figure.axes[0].set_title("(a) sensitivity, with ellipses to scale")
    return figure


def figure_of_map(dataset: xr.Dataset, robot: Robot) -> Figure:
    """Two panels: the larger semi-axis, and σ_min of A_p with the unstable zones."""
    solved = dataset["index"].values >= 0
    rows, columns = np.nonzero(solved)
    names = [str(name) for name in dataset["status"].dims]
    factor = [1e3 if dataset[name].attrs["units"] == "m" else 1.0 for name in names]
    first, second = (f * dataset[name].values for f, name in zip(factor, names, strict=True))
    spans = [first[rows.max()] - first[rows.min()], second[columns.max()] - second[columns.min()]]
    height = np.clip(0.36 * PAGE * spans[1] / spans[0], 2.2, 4.6) + 1.6
    width = np.clip(2.0 * (height - 1.6) * spans[0] / spans[1] + 2.4, 0.75 * PAGE, PAGE)
    figure, axes = plt.subplots(1, 2, figsize=(width, height), sharey=True)
    plot_map(dataset, "semi_axis_max", axes[0], robot=robot, unstable=False)
    plot_map(dataset, "sigma_t2", axes[1], robot=robot, cmap="cividis")
    axes[0].set_title("(a) sensitivity")
    axes[1].set_title("(b) distance to the loss of stiffness")
    axes[1].set_ylabel("")
    for ax in axes:
        margins = [0.03 * max(spans)] * 2
        ax.set_xlim(first[rows.min()] - margins[0], first[rows.max()] + margins[0])
        ax.set_ylim(second[columns.min()] - margins[1], second[columns.max()] + margins[1])
    handles = [
        plt.Line2D([], [], color=VERMILION, lw=1.4, label="Type 2"),
        plt.Line2D([], [], color=BLACK, lw=1.4, label="Type 1"),
        Patch(fc="white", ec=GREY, hatch="xxxxx", label="beyond a fold", lw=0.0),
        Patch(fc="#414d6b", ec="white", hatch="////", label="unstable", lw=0.0),
        plt.Line2D([], [], ls="", marker="o", mfc="white", mec=BLACK, label="motor"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, frameon=False)
    return figure


def _hatch(ax: Axes, x, z, where, pattern: str, colour: str) -> None:
    """Hatches cells; a contour at a half keeps to the edges of the cells well enough."""
    if not np.any(where):
        return
    with plt.rc_context({"hatch.linewidth": 0.6}):
        area = where.T.astype(float)
        drawn = ax.contourf(x, z, area, [0.5, 1.5], colors="none", hatches=[pattern])
        drawn.set_edgecolor(colour)
        drawn.set_linewidth(0.0)


def _axis_label(dataset: xr.Dataset, name: str) -> str:
    unit = "mm" if dataset[name].attrs["units"] == "m" else dataset[name].attrs["units"]
    return f"{name} ({unit})"
