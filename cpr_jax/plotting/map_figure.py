"""Figures of a workspace map, among them Figure 3 of the paper."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..robots.robot import Robot
from .style import BLACK, PAGE
from .workspace import drawn_axes, plot_ellipses, plot_map
from .zones import LINES, edges_of, legend_of, zones_of


def figure_3(dataset: xr.Dataset, robot: Robot, points: np.ndarray) -> Figure:
    """Figure 3: sensitivity and distance to a Type 2 singularity over half the workspace."""
    figure = figure_of_map(dataset, robot)
    plot_ellipses(dataset, points, figure.axes[0])
    figure.axes[0].set_title("(a) sensitivity, with ellipses to scale")
    return figure


def figure_of_map(dataset: xr.Dataset, robot: Robot) -> Figure:
    """Two panels: the larger semi-axis, and σ_min of A_p with the unstable zones.

    Where nothing is uncertain the first one shows how alike the motors move the platform in all
    directions.
    """
    solved = dataset["index"].values >= 0
    rows, columns = np.nonzero(solved)
    names, factors = drawn_axes(dataset)
    curves = np.concatenate([dataset[name].sel(axis=names).values for name in LINES])
    first, second = (f * dataset[name].values for f, name in zip(factors, names, strict=True))
    views = [
        _view(centers, places, np.ravel(curves[..., k]) * factor)
        for k, (centers, places, factor) in enumerate(
            zip((first, second), (rows, columns), factors, strict=True)
        )
    ]
    spans = [high - low for low, high in views]
    ratio = spans[1] / spans[0] if factors[0] == factors[1] else 1.0
    height = np.clip(0.36 * PAGE * ratio, 2.2, 4.6) + 1.6
    width = np.clip(2.0 * (height - 1.6) / ratio + 2.4, 0.75 * PAGE, PAGE)
    figure, axes = plt.subplots(1, 2, figsize=(width, height), sharey=True)
    certain = "semi_axis_max" not in dataset
    first = "manipulability_condition" if certain else "semi_axis_max"
    plot_map(dataset, first, axes[0], robot=robot, unstable=False)
    plot_map(dataset, "sigma_t2", axes[1], robot=robot, cmap="cividis")
    axes[0].set_title("(a) dexterity" if certain else "(a) sensitivity")
    axes[1].set_title("(b) distance to the loss of stiffness")
    axes[1].set_ylabel("")
    for ax in axes:
        equal = factors[0] == factors[1]
        margins = [0.03 * (max(spans) if equal else span) for span in spans]
        ax.set_xlim(views[0][0] - margins[0], views[0][1] + margins[0])
        ax.set_ylim(views[1][0] - margins[1], views[1][1] + margins[1])
    handles = legend_of(dataset, zones_of(dataset))
    left, right = axes[0].get_xlim()
    low, high = axes[0].get_ylim()
    motors = [line for line in axes[0].lines if line.get_marker() == "o"]
    places = np.concatenate([np.empty((0, 2)), *(line.get_xydata() for line in motors)])
    if np.any(np.all((places >= [left, low]) & (places <= [right, high]), axis=1)):
        motor: Any = {"ls": "", "marker": "o", "mfc": "white", "mec": BLACK, "label": "motor"}
        handles.append(plt.Line2D([], [], **motor))
    figure.legend(handles=handles, loc="outside lower center", ncols=5, frameon=False)
    return figure


def _view(centers, solved, curves) -> tuple[float, float]:
    """From where to where solved cells, and the curves beside them, reach along an axis."""
    edges = edges_of(centers)
    ends = np.concatenate([[edges[solved.min()], edges[solved.max() + 1]], curves])
    # A curve ends with a point outside of the grid.
    ends = np.clip(ends, edges[0], edges[-1])
    return float(np.nanmin(ends)), float(np.nanmax(ends))
