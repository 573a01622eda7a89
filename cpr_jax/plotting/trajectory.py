"""Figures of trajectories."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ..errors import InputError, check_integer
from ..studies.trajectory_dataset import check_trajectory, events
from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PAGE, VERMILION
from .workspace import ellipse_of

_COLOURS = (BLUE, VERMILION, GREEN, ORANGE, BLACK, GREY)
_STYLES: Any = ("-", (0, (4, 3)))
"""In turn: curves of legs that do the same lie on each other."""


_UNSTABLE: Any = {"color": GREY, "alpha": 0.25, "lw": 0.0}
_BEYOND: Any = {"fc": "none", "ec": GREY, "hatch": "....", "lw": 0.0}
_MISSED: Any = {"fc": "none", "ec": GREY, "hatch": "xxxx", "lw": 0.0}


def plot_trajectory(dataset: xr.Dataset) -> Figure:
    """What a robot goes through on a path: its motors, their torques, sensitivity, singularities.

    Where it is unstable the ground is grey, beyond a limit it is dotted; a line marks where the
    branch ends, and the part that is not reached is hatched.

    **Arguments:**

    - `dataset`: of `trajectory`.

    **Returns:** a figure of its own with up to four panels above each other.
    """
    handles = _grounds(dataset)
    panels = [_motors, _torques, *([_spread] if "semi_axis_max" in dataset else []), _singularities]
    size = 0.75 * PAGE, 1.45 * len(panels) + 0.3
    figure, axes = plt.subplots(len(panels), 1, figsize=size, sharex=True, layout="constrained")
    unit, factor = {"m": ("mm", 1e3), "rad": ("°", 180.0 / np.pi)}[dataset["s"].attrs["units"]]
    s = factor * dataset["s"].values
    for ax, panel in zip(axes, panels, strict=True):
        panel(dataset, s, ax)
        _mark(dataset, s, factor, ax)
    axes[-1].set_xlabel(f"distance along the path ({unit})")
    axes[-1].set_xlim(s[0], s[-1])
    figure.align_ylabels()
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    return figure


def plot_path(
    dataset: xr.Dataset, ax: Axes, *, axes: tuple[str, str] | None = None, ellipses: int = 9
) -> None:
    """The way of the platform over two of its coordinates, with its uncertainty ellipses, to scale.

    The part where the robot is unstable is dashed and without ellipses. Lengths are in mm, angles
    in degrees, as `plot_map` draws them.

    **Arguments:**

    - `dataset`: of `trajectory`.
    - `ax`: such as one of `plot_map`, whose `axes` are then those of the map.
    - `axes`: which two coordinates, such as `("z", "phi_P_x")`; by default the last two positions.
    - `ellipses`: how many; projected on the plane.
    """
    check_trajectory(dataset)
    check_integer("ellipses", ellipses, least=0)
    labels = [str(label).removeprefix("p_P_") for label in dataset["coordinate"].values]
    positions = [label for label in labels if label in dataset["space"].values]
    chosen = tuple(positions[-2:]) if axes is None else tuple(axes)
    if len(chosen) != 2 or not set(chosen) <= set(labels):
        raise InputError(
            f"Argument `axes` must be two of the platform's coordinates ({', '.join(labels)}), but "
            f"it is {', '.join(map(str, chosen))}."
        )
    rows = [labels.index(name) for name in chosen]
    factors = np.array([1e3 if name in positions else 180.0 / np.pi for name in chosen])
    places = factors * dataset["q_p"].values[:, rows]
    stable = dataset["stable"].values == 1
    held = np.where(stable[:, None], places, np.nan)
    empty = not ax.has_data()
    ax.plot(*places.T, color=BLACK, lw=1.0, ls=(0, (2, 2)), zorder=6)
    ax.plot(*held.T, color="white", lw=2.4, zorder=5.9)
    ax.plot(*held.T, color=BLACK, lw=1.2, zorder=6)
    corners = places[dataset["waypoint"].values == 1]
    ax.plot(*corners[[0, -1]].T, "o", ms=3.5, mfc="white", mec=BLACK, mew=0.9, zorder=6.2)
    if empty:
        units = ["mm" if name in positions else "°" for name in chosen]
        names = [rf"$\varphi_{name[-1]}$" if name not in positions else name for name in chosen]
        ax.set_xlabel(f"{names[0]} ({units[0]})")
        ax.set_ylabel(f"{names[1]} ({units[1]})")
        if units[0] == units[1]:
            ax.set_aspect("equal", adjustable="datalim")
    if "Pi_p" not in dataset:
        return
    # Where it is unstable nothing stays where the ellipse says.
    some = np.flatnonzero(stable)
    spread_out = np.linspace(0, max(len(some) - 1, 0), ellipses).astype(int)
    for k in np.unique(some[spread_out[: len(some)]]):
        spread = factors[:, None] * dataset["Pi_p"].values[k][rows] * dataset["delta"].values
        # Large ones, beside a singularity, are not to widen the view.
        ax.add_artist(ellipse_of(spread, places[k], alpha=0.85, zorder=6.1))


def _motors(dataset: xr.Dataset, s: np.ndarray, ax: Axes) -> None:
    unit = dataset["q_a"].attrs["units"]
    factor, name = {"rad": (180.0 / np.pi, "°"), "m": (1e3, "mm")}.get(unit, (1.0, unit))
    _curves(ax, s, factor * dataset["q_a"].values, dataset["motor"].values)
    ax.set_ylabel(f"motors ({name})")


def _torques(dataset: xr.Dataset, s: np.ndarray, ax: Axes) -> None:
    unit = dataset["motor_torque"].attrs["units"].replace("N m", "N·m")
    names = [str(name).replace("q", "τ") for name in dataset["motor"].values]
    _curves(ax, s, dataset["motor_torque"].values, names)
    ax.set_ylabel(f"torques ({unit})" if "m" in unit else f"forces ({unit})")


def _spread(dataset: xr.Dataset, s: np.ndarray, ax: Axes) -> None:
    both = [dataset[name].values for name in ("semi_axis_max", "semi_axis_min")]
    _curves(ax, s, 1e3 * np.stack(both, axis=1), ("largest", "smallest"))
    ax.set_ylabel("semi-axes (mm)")
    _logarithmic(ax, np.stack(both))


def _singularities(dataset: xr.Dataset, s: np.ndarray, ax: Axes) -> None:
    both = [dataset[name].values for name in ("sigma_t1", "sigma_t2")]
    # That of what is imposed is A_q where all of the platform is.
    platform = set(map(str, dataset["imposed"].values)) <= set(dataset["coordinate"].values)
    first = r"of $\mathbf{A}_q$" if platform else "path held"
    _curves(ax, s, np.stack(both, axis=1), (first, r"of $\mathbf{A}_p$"))
    ax.set_ylabel(r"$\sigma_\mathrm{min}$")
    _logarithmic(ax, np.stack(both))


def _curves(ax: Axes, s: np.ndarray, columns: np.ndarray, names) -> None:
    """A curve a column, with a legend beside the panel."""
    for k, (column, name) in enumerate(zip(columns.T, names, strict=True)):
        style = _STYLES[k % 2] if len(names) > 2 else _STYLES[0]
        # Dashes lie on what is solid, to be seen where both do the same.
        order = 2.0 if style == _STYLES[0] else 2.1
        colour = _COLOURS[k % len(_COLOURS)]
        ax.plot(s, column, color=colour, ls=style, zorder=order, label=str(name))
    columns_of_legend = 1 + (len(names) > 6)
    look: Any = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "frameon": False}
    ax.legend(ncols=columns_of_legend, **look)


def _logarithmic(ax: Axes, values: np.ndarray) -> None:
    """Where values differ by more than a decade."""
    positive = values[np.isfinite(values) & (values > 0.0)]
    if positive.size and positive.max() > 10.0 * positive.min():
        ax.set_yscale("log")


def _mark(dataset: xr.Dataset, s: np.ndarray, factor: float, ax: Axes) -> None:
    """Grounds where the robot is unstable or beyond a limit, the end, and waypoints."""
    reached = dataset.attrs["reached"]
    for name, back, look in (
        ("unstable", "stable", _UNSTABLE),
        ("beyond limits", "within limits", _BEYOND),
    ):
        begin = None
        for event in [*events(dataset), {"event": back, "s": reached}]:
            if event["event"] == name:
                begin = event["s"]
            elif event["event"] == back and begin is not None:
                ax.axvspan(factor * begin, factor * event["s"], **look)
                begin = None
    if factor * reached < s[-1]:
        ax.axvline(factor * reached, color=BLACK, lw=0.8)
        with plt.rc_context({"hatch.linewidth": 0.4}):
            ax.axvspan(factor * reached, s[-1], **_MISSED)
    corners = s[dataset["waypoint"].values == 1][1:-1]
    # A curve that was sampled has them everywhere.
    for corner in corners if len(corners) < len(s) // 2 else ():
        ax.axvline(corner, color=GREY, lw=0.5, ls=":")


def _grounds(dataset: xr.Dataset) -> list[Any]:
    """Handles for a legend of the grounds that there are."""
    named = {event["event"] for event in events(dataset)}
    handles: list[Any] = [
        Patch(label=text, **look)
        for name, text, look in (
            ("unstable", "unstable", _UNSTABLE),
            ("beyond limits", "beyond a limit", _BEYOND),
            ("end", "not reached", _MISSED),
        )
        if name in named
    ]
    if 2 < np.sum(dataset["waypoint"].values) < dataset.sizes["s"] // 2:
        handles.append(plt.Line2D([], [], color=GREY, lw=0.5, ls=":", label="waypoint"))
    return handles
