"""The figures of the paper."""

import io
import pathlib

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.shape import compile_shape
from ..studies.outcome import MonteCarlo
from ..studies.paper_samples import POINTS
from .clouds import plot_clouds
from .map_figure import figure_3
from .robot import plot_robot
from .style import BLACK, BLUE, COLUMN, GREY, ORANGE, PAGE, VERMILION, journal_style, save_figure

MAP_POINTS = np.array([*POINTS.values(), (0.0, 0.1), (0.15, 0.15), (0.18, 0.0)])
"""Where Figure 3 shows ellipses: the points of Figure 2 and some between them, m."""


def prepare(robot: Robot) -> None:
    """Gets fonts, file formats and the program of shapes ready while there is nothing to draw."""
    compile_shape(robot)
    with journal_style():
        figure, ax = plt.subplots()
        ax.set_xlabel("$x_1$")
        for ending in ("pdf", "png"):
            figure.savefig(io.BytesIO(), format=ending)
        plt.close(figure)


def save_figure_1(folder: pathlib.Path, robot: Robot, equilibrium: Equilibrium) -> None:
    """Writes `figure_1`."""
    with journal_style():
        save_figure(figure_1(robot, equilibrium), folder / "figure-1")


def save_figure_2(
    folder: pathlib.Path, robot: Robot, equilibrium: Equilibrium, studies: dict[str, MonteCarlo]
) -> None:
    """Writes `figure_2`."""
    with journal_style():
        save_figure(figure_2(robot, equilibrium, studies), folder / "figure-2")


def save_figure_3(folder: pathlib.Path, robot: Robot, dataset: xr.Dataset) -> None:
    """Writes `figure_3`."""
    with journal_style():
        save_figure(figure_3(dataset, robot, MAP_POINTS), folder / "figure-3")


def figure_1(robot: Robot, equilibrium: Equilibrium) -> Figure:
    """Figure 1: the robot with its parametrisation."""
    figure, ax = plt.subplots(figsize=(COLUMN, 3.0))
    drawn = plot_robot(robot, equilibrium, ax)
    rods = np.asarray(drawn.rods.position) * 1e3
    motors = np.asarray(drawn.motors) * 1e3
    end = np.asarray(equilibrium.q_p) * 1e3
    for motor in motors:
        _ground(ax, motor)
    for i, side in ((0, -1.0), (1, 1.0)):
        _motor_angle(ax, motors[i], rods[i, 0], i, side)
        # On the left of both, where no angle is drawn; above the segments b.
        _beside(ax, motors[i], rods[i, 0], rf"$a_{i + 1}$", (-1.0, 0.0))
        _beside(ax, rods[i, -1], end, rf"$b_{i + 1}$", (0.0, 1.0))
        middle = rods[i, len(rods[i]) // 2]
        ax.annotate(
            rf"$l_{i + 1},\ k_{{b{i + 1}}},\ r_{{c{i + 1}}}$",
            tuple(middle),
            xytext=(9 * side, 2),
            textcoords="offset points",
            ha="left" if side > 0 else "right",
            va="center",
        )
        wrench = rods[i, 0]
        ax.plot(*wrench, "s", ms=3, color=BLUE, zorder=6)
        ax.annotate(
            rf"$\boldsymbol{{\mu}}_{i + 1}$",
            wrench,
            xytext=(11 * side, 4),
            textcoords="offset points",
            ha="center",
            color=BLUE,
        )
    _arrow(ax, end, end + np.array([0.0, 45.0]), r"$\mathbf{f}_P$", (6, 0), VERMILION)
    ax.annotate(
        r"$\mathbf{p}_P$",
        tuple(end),
        xytext=(0, -17),
        textcoords="offset points",
        ha="center",
        color=VERMILION,
    )
    _arrow(ax, (0, 0), (40, 0), "$y$", (3, 0), BLACK)
    _arrow(ax, (0, 0), (0, 40), "$z$", (-2, 4), BLACK)
    y = -42.0
    ax.annotate(
        "",
        (motors[0, 0], y),
        (motors[1, 0], y),
        arrowprops={"arrowstyle": "<->", "lw": 0.7, "shrinkA": 0, "shrinkB": 0},
    )
    ax.text(0.0, y - 5, "$d$", ha="center", va="top")
    ax.set_ylim(-65, end[1] + 62)
    low, high = rods[..., 0].min(), rods[..., 0].max()
    ax.set_xlim(low - 103, high + 103)
    return figure


def figure_2(robot: Robot, equilibrium: Equilibrium, studies: dict[str, MonteCarlo]) -> Figure:
    """Figure 2: the points A to D in the workspace, their clouds and their ellipses."""
    figure = plt.figure(figsize=(PAGE, 4.4))
    grid = figure.add_gridspec(2, 3, width_ratios=[1.25, 1.0, 1.0])
    overview = figure.add_subplot(grid[:, 0])
    plot_robot(robot, equilibrium, overview, color=GREY, alpha=0.35)
    for name, result in studies.items():
        rim = np.asarray(result.ellipsoid.boundary()) * 1e3
        point = np.array(POINTS[name]) * 1e3
        overview.fill(*rim.T, fc=ORANGE, ec=VERMILION, lw=0.9, zorder=7)
        overview.plot(*point, ".", ms=2.5, color=BLACK, zorder=8)
        overview.annotate(
            name, tuple(point), xytext=(7, 7), textcoords="offset points", weight="bold", zorder=9
        )
    overview.margins(0.08)
    overview.set_title("The ellipses to scale,\nthe robot at A")
    for k, (name, result) in enumerate(studies.items()):
        ax = figure.add_subplot(grid[k // 2, 1 + k % 2])
        plot_clouds(result, ax)
        y, z = (1e3 * c for c in POINTS[name])
        lost = (result.lost + result.failed) / result.samples
        words = f"{result.coverage:.1%} inside" + (f", {lost:.1%} lost" if lost else "")
        ax.set_title(f"$\\bf{{{name}}}$ ({y:.0f}, {z:.0f}) mm\n{words}")
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower right", ncols=4, frameon=False, markerscale=2.0
    )
    return figure


def _ground(ax: Axes, motor: np.ndarray) -> None:
    y, z = motor
    ax.plot([y - 9, y, y + 9], [z - 14, z, z - 14], color=BLACK, lw=0.9, zorder=1)
    ax.plot([y - 14, y + 14], [z - 14, z - 14], color=BLACK, lw=0.9)
    for k in np.linspace(-14, 10, 6):
        ax.plot([y + k, y + k + 4], [z - 20, z - 14], color=BLACK, lw=0.5)


def _motor_angle(ax: Axes, motor, start, i: int, side: float) -> None:
    angle = np.arctan2(start[1] - motor[1], start[0] - motor[0]) % (2 * np.pi)
    sweep = np.linspace(0.0, angle, 60)
    radius = 24.0
    arc = motor + radius * np.stack([np.cos(sweep), np.sin(sweep)], axis=1)
    ax.plot([motor[0], motor[0] + 34], [motor[1]] * 2, color=GREY, lw=0.6, ls="--", zorder=0)
    ax.plot(*arc.T, color=GREY, lw=0.8)
    ax.annotate("", arc[-1], arc[-4], arrowprops={"arrowstyle": "-|>", "lw": 0.8, "color": GREY})
    middle = motor + 1.75 * radius * np.array([np.cos(0.45 * angle), np.sin(0.45 * angle)])
    ax.text(middle[0], middle[1], rf"$q_{{a{i + 1}}}$", ha="center", va="center")


def _beside(ax: Axes, start, end, label: str, side) -> None:
    """A label beside a segment, on the side that a direction points to."""
    across = np.array([-(end - start)[1], (end - start)[0]]) / np.linalg.norm(end - start)
    across = across * np.sign(across @ np.array(side))
    y, z = 0.5 * (start + end) + 14 * across
    ax.text(y, z, label, ha="center", va="center")


def _arrow(ax: Axes, start, end, label: str, shift, color: str) -> None:
    ax.annotate(
        "",
        end,
        start,
        arrowprops={"arrowstyle": "-|>", "lw": 1.2, "color": color, "shrinkA": 0, "shrinkB": 0},
        zorder=7,
    )
    ax.annotate(label, end, xytext=shift, textcoords="offset points", color=color, va="center")
