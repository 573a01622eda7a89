"""How figures look: journal sizes, colours that colour-blind readers tell apart."""

import functools
import pathlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from ..atomic import write_atomically

COLUMN = 3.5
"""Width of a journal's column, inches."""

PAGE = 7.16
"""Width of a journal's text, inches."""

# Okabe and Ito's palette; as grey levels they stay apart too.
BLUE, ORANGE, GREEN, VERMILION = "#0072B2", "#E69F00", "#009E73", "#D55E00"
BLACK, GREY = "#000000", "#7F7F7F"

_SETTINGS: Any = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 9,
    "axes.labelsize": 9,
    "axes.titlesize": 9,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.2,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
    "figure.constrained_layout.use": True,
}

_NO_LAYOUT: Any = {"figure.constrained_layout.use": False, "figure.autolayout": False}
"""What it takes for a figure to be without a layout engine while it is saved."""


@contextmanager
def journal_style() -> Iterator[None]:
    """Settings of a journal's figure, for the block only."""
    with matplotlib.rc_context(_SETTINGS):
        yield


def save_figure(
    figure: Figure, stem: str | pathlib.Path, endings: Sequence[str] = ("pdf", "png")
) -> list[pathlib.Path]:
    """Writes a figure, by default as PDF and as PNG, and closes it."""
    paths = [pathlib.Path(f"{stem}.{ending}") for ending in endings]
    _lay_out(figure)
    with matplotlib.rc_context(_NO_LAYOUT):
        # With an engine, if it is an idle one, each file is drawn twice.
        figure.set_layout_engine(None)
        for path in paths:
            # The temporary file's name does not tell the format.
            save = functools.partial(figure.savefig, format=path.suffix.removeprefix("."))
            write_atomically(path, save)
    plt.close(figure)
    return paths


def _lay_out(figure: Figure) -> None:
    """Once for all files, which takes as long as one of them."""
    layout, dpi = figure.get_layout_engine(), figure.dpi
    if layout is None:
        return
    fine = matplotlib.rcParams["savefig.dpi"]
    figure.dpi = dpi if fine == "figure" else fine
    layout.execute(figure)
    figure.dpi = dpi


def unit_name(factor: float) -> str:
    """What lengths are in once they are multiplied by a factor from m."""
    return {1e3: "mm", 1e2: "cm", 1.0: "m"}.get(factor, f"{1.0 / factor:g} m")
