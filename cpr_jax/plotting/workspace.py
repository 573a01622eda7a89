"""Workspace maps: any variable in colours, and ellipses."""

import re
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LogNorm, Normalize
from matplotlib.patches import Ellipse

from ..checks import check_kind, check_on_map, finite_rows
from ..errors import InputError, shown
from ..robots.robot import Robot
from ..statics.status import Status
from .style import BLACK, ORANGE
from .zones import LINES, edges_of, legend_of, zones_of

_LOGARITHMIC = ("semi_axis_max", "semi_axis_min", "ellipse_area", "sigma_t1", "sigma_t2")
_LENGTHS = ("semi_axis_max", "semi_axis_min")
_KINDS: dict[str, Any] = {
    "status": lambda kind: Status(kind).name.lower().replace("_", " "),
    "stable": lambda kind: ("no", "yes")[kind],
    "seam": lambda kind: ("no", "yes")[kind],
    "index": str,
    "branch": str,
    "level": str,
}
"""Variables that count or name, and what their values are called."""
_DRAWN = {"m": (1e3, "mm"), "rad": (180.0 / np.pi, "°")}
"""By SI unit: the factor to the unit in which a coordinate is drawn, and the name of that."""


def plot_map(
    dataset: xr.Dataset,
    variable: str = "semi_axis_max",
    ax: Axes | None = None,
    *,
    robot: Robot | None = None,
    lines: bool = True,
    unstable: bool = True,
    colorbar: bool = True,
    legend: bool | None = None,
    **mesh: Any,
) -> Axes:
    """A variable of a workspace map in colours, with the singular lines and unstable zones.

    Lengths are shown in mm, angles in degrees. Every cell has one colour: nothing is
    interpolated. Cells within reach but without an equilibrium, or beyond a limit, are hatched.

    **Arguments:**

    - `dataset`: of `workspace_map`.
    - `variable`: one with the two coordinates as dimensions.
    - `robot`: draws its motors, if the map is of the plane of a planar robot.
    - `lines`, `unstable`: draw `t1_line` and `t2_line`, which a volume has in the planes of its
        slices only; hatch cells that are not stable.
    - `legend`: names what is drawn and hatched, by default in a figure that is made here.
    - `mesh`: for `matplotlib`'s `pcolormesh`, such as `norm` or `cmap`.
    """
    _check_flat(dataset)
    alone = ax is None
    if ax is None:
        ax = plt.subplots(layout="compressed")[1]
    names, factors = drawn_axes(dataset)
    x, z = (f * dataset[name].values for f, name in zip(factors, names, strict=True))
    over = dataset["status"].dims
    if variable not in dataset or dataset[variable].dims != over:
        flat = sorted(str(name) for name in dataset.data_vars if dataset[name].dims == over)
        raise InputError(
            f"Argument `variable` must be one over {' and '.join(names)} alone "
            f"({', '.join(flat)}), but it is {shown(variable)}: select an entry of it first."
        )
    data = dataset[variable]
    values = data.values.astype(float) * (1e3 if variable in _LENGTHS else 1.0)
    solved = dataset["index"].values >= 0
    # Its status is what a cell without an equilibrium has.
    drawn_values = values if variable == "status" else np.where(solved, values, np.nan)
    kinds = np.unique(drawn_values[np.isfinite(drawn_values)]) if variable in _KINDS else None
    if kinds is not None:
        edges = np.concatenate([kinds[:1] - 0.5, 0.5 * (kinds[1:] + kinds[:-1]), kinds[-1:] + 0.5])
        mesh = {"norm": BoundaryNorm(edges, len(kinds)), **mesh}
        mesh = {"cmap": plt.get_cmap("viridis", len(kinds)), **mesh}
    if "norm" not in mesh:
        low, high = np.nanpercentile(drawn_values, [0.5, 99.5])
        # Below a decade the ticks of a logarithmic scale crowd and say little.
        wide = variable in _LOGARITHMIC and high > 10.0 * low > 0.0
        mesh["norm"] = LogNorm(low, high) if wide else Normalize(low, high)
    mesh = {"cmap": "viridis", "rasterized": True, "shading": "nearest", **mesh}
    drawn = ax.pcolormesh(x, z, drawn_values.T, **mesh)

    zones = [
        zone
        for zone in zones_of(dataset)
        if variable != "status" and (unstable or zone.name != "unstable")
    ]
    for zone in zones:
        zone.draw(ax, (edges_of(x), edges_of(z)))
    # A volume has the lines of its slices: cut across them it has none.
    lines = lines and all(dataset[name].ndim == 3 for name in LINES)
    if lines:
        for name, (_, colour) in reversed(LINES.items()):
            for curve in dataset[name].sel(axis=names).values:
                ax.plot(*(curve * factors).T, color=colour, lw=1.1, zorder=4)
    if robot is not None and _of_the_plane(dataset, robot):
        places = [robot.geometry.axes.index(name) for name in names]
        motors = np.asarray(robot.legs.base_position)[:, places] * factors
        ax.plot(*motors.T, "o", ms=5, mfc="white", mec=BLACK, mew=1.2, zorder=6)
    # Lengths and angles have no common scale.
    equal = factors[0] == factors[1]
    ax.set_aspect("equal" if equal else "auto")
    ax.set_xlabel(_axis_label(dataset, names[0]))
    ax.set_ylabel(_axis_label(dataset, names[1]))
    if colorbar:
        unit = "mm" if variable in _LENGTHS else data.attrs.get("units", "1")
        text = re.sub(r"\bA_([pq])\b", r"$\\mathbf{A}_\1$", data.attrs.get("long_name", variable))
        label = text if unit == "1" else f"{text} ({unit})"
        # Only a layout engine keeps it off the labels of the axis by itself.
        free = ax.figure.get_figure(root=True).get_layout_engine() is None
        look: Any = {"location": "bottom", "pad": 0.15 if free else 0.02}
        if alone and equal and np.ptp(z) > np.ptp(x):
            # A narrow map leaves room beside it.
            look = {"location": "right"}
        if kinds is None:
            look["extend"] = "both"
        bar = ax.figure.colorbar(drawn, ax=ax, label=label, **look)
        if kinds is not None:
            names_of = [_KINDS[variable](int(kind)) for kind in kinds]
            bar.set_ticks(0.5 * (edges[1:] + edges[:-1]), labels=names_of)
            bar.ax.tick_params(which="both", length=0, labelsize="small")
    handles = legend_of(dataset if lines else None, zones)
    if handles and (alone if legend is None else legend):
        look = {"loc": "best", "framealpha": 0.9}
        figure = ax.figure.get_figure(root=True)
        if figure.get_layout_engine() is None:
            ax.legend(handles=handles, **look)
        else:
            look = {"loc": "outside lower center", "ncols": 3, "frameon": False}
            figure.legend(handles=handles, **look)
    return ax


def plot_ellipses(dataset: xr.Dataset, points: np.ndarray, ax: Axes, scale: float = 1.0) -> None:
    """Uncertainty ellipses at the cells of a map that are nearest to points.

    They are the ellipsoids of the platform's coordinates, projected on the plane of the map: what
    its two coordinates can be, whatever the others are.

    **Arguments:**

    - `points`: in the coordinates of the map, m or rad, shape `(k, 2)`.
    - `scale`: magnification of the ellipses about their centres.
    """
    _check_flat(dataset)
    names, factors = drawn_axes(dataset)
    if "Pi_p" not in dataset:
        raise InputError("Argument `dataset` must have sensitivities, but nothing in it varies.")
    points = finite_rows("points", points, names)
    check_on_map("points", points, names, [dataset[name].values for name in names])
    labels = [str(label).removeprefix("p_P_") for label in dataset["coordinate"].values]
    rows = [labels.index(name) for name in names]
    for point in points:
        cell = dataset.sel(dict(zip(names, point, strict=True)), method="nearest")
        spread = cell["Pi_p"].values[rows] * cell["delta"].values * factors[:, None]
        if not np.all(np.isfinite(spread)):
            continue
        center = factors * [float(cell[name]) for name in names]
        ax.add_patch(ellipse_of(scale * spread, center, zorder=5))


def ellipse_of(
    spread: Float[np.ndarray, "2 n_rho"], center: Float[np.ndarray, "2"], **look: Any
) -> Ellipse:
    """The ellipse of two coordinates, from their sensitivities times the half ranges."""
    directions, semi_axes, _ = np.linalg.svd(spread, full_matrices=False)
    width, height = 2.0 * np.pad(semi_axes, (0, 2 - len(semi_axes)))
    angle = float(np.rad2deg(np.arctan2(directions[1, 0], directions[0, 0])))
    look = {"fc": ORANGE, "ec": BLACK, "lw": 0.5, **look}
    return Ellipse((center[0], center[1]), width, height, angle=angle, **look)


def drawn_axes(dataset: xr.Dataset) -> tuple[list[str], np.ndarray]:
    """Names of the two coordinates, and factors to the units in which they are drawn."""
    names = [str(name) for name in dataset["status"].dims]
    return names, np.array([_DRAWN[dataset[name].attrs["units"]][0] for name in names])


def _check_flat(dataset: xr.Dataset) -> None:
    check_kind("dataset", dataset, xr.Dataset, "a workspace map")
    over = dataset["status"].dims if "status" in dataset else ()
    if len(over) != 2:
        raise InputError(
            "Argument `dataset` must be a map over two coordinates, or a slice of a volume, but "
            f"it is over {', '.join(map(str, over)) or 'none'}."
        )


def _of_the_plane(dataset: xr.Dataset, robot: Robot) -> bool:
    """Whether a map shows the plane in which the robot lies."""
    return robot.geometry.d == 2 and set(dataset["status"].dims) == set(robot.geometry.axes)


def _axis_label(dataset: xr.Dataset, name: str) -> str:
    unit = _DRAWN[dataset[name].attrs["units"]][1]
    axis = name.removeprefix("phi_P_")
    return f"{name} ({unit})" if axis == name else rf"$\varphi_{axis}$ ({unit})"
