"""Robots side by side."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import PlaceHolderLayoutEngine
from mpl_toolkits.mplot3d import Axes3D

from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from .robot import plot_robot
from .space import plot_robot_3d
from .style import PAGE

_ROW, _TITLE = 2.1, 0.42
"""Heights of a picture and of the words above it, inches."""
_ELEVATION, _AZIMUTH = 16.0, -72.0
"""Where robots of space are seen from, degrees: few of their rods hide one another."""


def figure_of_robots(robots: Sequence[tuple[Robot, Equilibrium]]) -> Figure:
    """Robots at equilibria of theirs: a row of those of the plane, a row of those of space.

    Each has a scale of its own; the words above it say how long its rods are.
    """
    rows = [[pair for pair in robots if pair[0].geometry.d == d] for d in (2, 3)]
    rows = [row for row in rows if row]
    height = (_ROW + _TITLE) * len(rows)
    # No layout; "none" would be forgotten once the figure is saved.
    none = PlaceHolderLayoutEngine(adjust_compatible=True, colorbar_gridspec=True)
    figure = plt.figure(figsize=(PAGE, height), layout=none)
    for k, row in enumerate(rows):
        bottom = height - (_ROW + _TITLE) * (k + 1)
        width = PAGE / len(row)
        for j, (robot, equilibrium) in enumerate(row):
            middle = (j + 0.5) * width
            if robot.geometry.d == 2:
                place = (middle - 0.44 * width, bottom + 0.05 * _ROW, 0.88 * width, 0.9 * _ROW)
                ax = figure.add_axes(_share(place, height))
                plot_robot(robot, equilibrium, ax)
                ax.margins(0.06)
                # The words of a row stand on one line, whatever a robot's shape is.
                ax.set_adjustable("datalim")
            else:
                place = (middle - 0.5 * _ROW, bottom, _ROW, _ROW)
                ax = figure.add_axes(_share(place, height), projection="3d")
                plot_robot_3d(robot, equilibrium, ax)
                _fill(ax, width / _ROW)
            ax.set_axis_off()
            length = 1e3 * float(np.mean(np.asarray(robot.legs.rod.length)))
            words = f"{robot.name}\nrods of {length:.0f} mm"
            top = (bottom + _ROW + 0.04) / height
            figure.text(middle / PAGE, top, words, ha="center", va="bottom", fontsize=8.5)
    return figure


def _share(place: tuple[float, float, float, float], height: float):
    """A place in inches as shares of the figure."""
    left, bottom, width, tall = place
    return left / PAGE, bottom / height, width / PAGE, tall / height


def _fill(ax: Axes3D, share: float) -> None:
    """Lets what is drawn fill square axes of which neighbours leave a share of the width."""
    # Its background would hide neighbours.
    ax.patch.set_visible(False)
    ax.set_proj_type("ortho")
    ax.view_init(elev=_ELEVATION, azim=_AZIMUTH)
    spans = np.ptp([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()], axis=1)
    c, s = np.abs([np.cos(np.deg2rad(_AZIMUTH)), np.sin(np.deg2rad(_AZIMUTH))])
    wide, deep = s * spans[0] + c * spans[1], c * spans[0] + s * spans[1]
    lift = np.deg2rad(_ELEVATION)
    tall = spans[2] * np.cos(lift) + deep * np.sin(lift)
    zoom = np.linalg.norm(spans) * min(1.02 * share / wide, 0.95 / tall)
    ax.set_box_aspect(tuple(spans), zoom=float(zoom))
