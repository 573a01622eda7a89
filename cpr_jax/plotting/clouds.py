"""Clouds of perturbed end-effectors and their uncertainty ellipses."""

import numpy as np
from matplotlib.axes import Axes

from ..errors import InputError
from ..statics.status import Status
from ..studies.monte_carlo import MonteCarlo
from .style import BLACK, BLUE, ORANGE, VERMILION


def plot_clouds(study: MonteCarlo, ax: Axes, *, unit: float = 1e3) -> None:
    """Draws a planar cloud relative to its nominal point, its ellipse and its percentages.

    Samples inside the ellipse are dots, samples outside are crosses; samples without an
    equilibrium have no place: they are counted in the corner.

    **Arguments:**

    - `unit`: factor from m to the unit of the axes; 1000 draws millimetres.
    """
    ellipse = study.ellipsoid
    if ellipse.center.size != 2:
        raise InputError("Argument `study` must be of a planar position to be drawn here.")
    center = np.asarray(ellipse.center)
    solved = study.status == Status.SOLVED
    offset = (study.q_p[:, :2] - center) * unit
    inside, outside = offset[solved & study.inside], offset[solved & ~study.inside]
    rim = (np.asarray(ellipse.boundary()) - center) * unit
    ax.plot(*inside.T, ".", ms=1.6, mew=0, color=BLUE, alpha=0.6, rasterized=True, label="inside")
    ax.plot(*outside.T, "x", ms=2.6, mew=0.6, color=VERMILION, rasterized=True, label="outside")
    ax.plot(*rim.T, color=BLACK, lw=1.0, label="ellipse")
    ax.plot(0.0, 0.0, "+", ms=6, mew=1.0, color=ORANGE, label="nominal")
    _frame(ax, rim, offset[solved])
    text = f"{study.coverage:.1%} inside"
    if study.lost or study.failed:
        text += f"\n{study.lost / study.samples:.1%} lost"
    ax.text(
        0.03, 0.97, text, transform=ax.transAxes, va="top",
        bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.5},
    )


def _frame(ax: Axes, rim: np.ndarray, cloud: np.ndarray) -> None:
    """Limits that show the ellipse and all of the cloud, with room for the text above."""
    points = np.concatenate([rim, cloud])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.08 * (high - low)
    ax.set_xlim(low[0] - margin[0], high[0] + margin[0])
    ax.set_ylim(low[1] - margin[1], high[1] + 0.35 * (high[1] - low[1]))
