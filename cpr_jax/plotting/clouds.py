"""Clouds of perturbed end-effectors and their uncertainty ellipses."""

import numpy as np
from matplotlib.axes import Axes

from ..errors import InputError
from ..statics.status import Status
from ..studies.outcome import MonteCarlo
from .style import BLACK, BLUE, ORANGE, VERMILION, unit_name


def plot_clouds(study: MonteCarlo, ax: Axes, *, unit: float = 1e3) -> None:
    """Draws a planar cloud relative to its nominal point, and its ellipse.

    Samples inside the ellipse are dots, samples outside are crosses. Samples without an
    equilibrium have no place here; `study.lost` counts them.

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
    ax.margins(0.08)
    names = [label.rpartition("_")[2] for label in ellipse.labels]
    ax.set_xlabel(rf"$\Delta {names[0]}$ ({unit_name(unit)})")
    ax.set_ylabel(rf"$\Delta {names[1]}$ ({unit_name(unit)})")
