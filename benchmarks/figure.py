"""One figure of a run: peers, precision, samples, legs."""

import pathlib
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from cpr_jax.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PAGE,
    VERMILION,
    journal_style,
    save_figure,
)

_LIGHT = "#BDBDBD"
_COLOURS = {
    "cpr_jax": BLUE,
    "scipy": ORANGE,
    "C++": BLACK,
    "numba": GREY,
    "CasADi": GREEN,
    "diffrax and optimistix": VERMILION,
}
_MARKERS = "osD^vP*X"
_HEIGHT, _DPI = 4.8, 160


def draw(run: dict[str, Any], stem: pathlib.Path) -> None:
    """Draws what a run has measured, as a PNG; nothing where all that was measured are tables."""
    series: dict[str, dict[str, list]] = {}
    for entry in run["tasks"].values():
        series |= entry["series"]
    rows = [[name for name in row if name in series] for row in _ROWS]
    rows = [row for row in rows if row]
    if not rows:
        return
    with journal_style():
        plt.rcParams["savefig.dpi"] = _DPI
        figure = plt.figure(figsize=(PAGE, _HEIGHT * len(rows) / len(_ROWS)))
        parts = figure.subfigures(len(rows), 1, squeeze=False)[:, 0]
        for part, row in zip(parts, rows, strict=True):
            for axes, name in zip(part.subplots(1, len(row), squeeze=False)[0], row, strict=True):
                plot, label = _PANELS[name]
                plot(axes, series[name], label)
        save_figure(figure, stem, endings=("png",))


def _dots(axes: Axes, values: dict[str, list], label: str) -> None:
    """A dot for each program, the fastest on top."""
    ordered = sorted(values.items(), key=lambda item: -item[1][0][1])
    seconds = [points[0][1] for _, points in ordered]
    places = range(len(ordered))
    colours = [BLUE if name.startswith("cpr_jax") else BLACK for name, _ in ordered]
    # Dots: a logarithmic axis has no zero from which a bar could start.
    # Whole decades, so that several are labelled and nothing between them.
    ends = 10.0 ** np.floor(np.log10(min(seconds))), 10.0 ** np.ceil(np.log10(max(seconds)))
    axes.hlines(places, ends[0], seconds, color=_LIGHT, linewidth=0.8)
    axes.scatter(seconds, places, color=colours, s=18, zorder=3)
    axes.set_xscale("log")
    axes.set_xlim(*ends)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_yticks(places, [_short(name) for name, _ in ordered], fontsize=7)
    axes.set_xlabel(label)


def _short(name: str) -> str:
    """A name without its setting, the published algorithm as which it is."""
    head, _, setting = name.partition(": ")
    if "published" in head:
        return f"published, {', '.join(setting.split(', ')[:2])}"
    return head.split(", ")[0] if "abreast" in name else head


def _precision(axes: Axes, curves: dict[str, list], label: str) -> None:
    for (name, points), marker in zip(curves.items(), _MARKERS, strict=False):
        errors, seconds = zip(*sorted(points), strict=True)
        colour = _COLOURS[name.split(", ")[0]]
        axes.loglog(errors, seconds, color=colour, marker=marker, markersize=3.5, label=name)
    axes.invert_xaxis()
    axes.set_xlabel("Error of the platform, m")
    axes.set_ylabel(label)
    axes.legend(fontsize=6, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))


def _samples(axes: Axes, curves: dict[str, list], label: str) -> None:
    for points in curves.values():
        counts, seconds = zip(*points, strict=True)
        axes.loglog(counts, seconds, color=BLUE, marker="o", markersize=3.5)
    axes.set_xlabel("Monte Carlo samples")
    axes.set_ylabel(label)


def _legs(axes: Axes, curves: dict[str, list], label: str) -> None:
    for (name, points), colour, marker in zip(curves.items(), (VERMILION, BLUE), "so", strict=True):
        counts, seconds = zip(*points, strict=True)
        axes.semilogy(counts, seconds, color=colour, marker=marker, markersize=3.5, label=name)
    axes.set_xticks([int(count) for count, _ in next(iter(curves.values()))])
    axes.set_xlabel("Legs")
    axes.set_ylabel(label)
    axes.legend(fontsize=7, frameon=False)


_ROWS = (("peers", "precision"), ("six legs", "samples", "legs"))
_PANELS = {
    "peers": (_dots, "Time per sample, s"),
    "precision": (_precision, "Time per sample, s"),
    "six legs": (_dots, "Six legs: time per solve, s"),
    "samples": (_samples, "Time of a study, s"),
    "legs": (_legs, "Time, s"),
}
"""Panels row by row; those of tasks that a run lacks leave their place to the others."""
