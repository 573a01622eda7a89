"""Paths through a workspace map that keep away from where uncertainty matters most."""

import json
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from jaxtyping import Float

from ..checks import check_on_map, check_positive
from ..errors import InputError, shown
from ..statics.status import SolveError, Status
from .cost_field import CostField


class Way(NamedTuple):
    """A path, as `trajectory` takes it: `trajectory(robot, way.points, imposed=way.imposed)`.

    **Attributes:**

    - `points`: corners, values of the imposed coordinates, SI units, `(k, n_a)`.
    - `imposed`: their names.
    - `cost`: the integral of the cost along the path.
    - `length`: of the path.
    """

    points: Float[np.ndarray, "k n_a"]
    imposed: tuple[str, ...]
    cost: float
    length: float


def plan_path(
    dataset: xr.Dataset,
    start: Any,
    goal: Any,
    *,
    cost: str | xr.DataArray | None = "semi_axis_max",
    allowed: xr.DataArray | None = None,
    unstable: bool = False,
    radian: float | None = None,
) -> Way:
    """The path of least cost between two points of a workspace map.

    It runs through solved cells within the limits of the map, away from its seams, where the robot
    is stable: past them it does not go where its motors lead it. Of all moves between cells those
    of least cost are found (Dijkstra's algorithm), then corners are cut where a straight line costs
    less. Follow the result with `trajectory`, which is exact: from the `seed` of the map, if it had
    one of its own. A path keeps a cell away from cells where it may not go.

    **Arguments:**

    - `dataset`: of `workspace_map`. One of a symmetric robot holds one half, unless it was made
        with `symmetry=False`.
    - `start`, `goal`: values of the map's two coordinates, SI units.
    - `cost`: a variable of the map, or one made of them, per unit of length: the path is one of the
        least integral. With `None` it is the shortest path, as it is by default in a map without
        sensitivities.
    - `allowed`: true where it may go, such as `dataset["sigma_t2"] > 0.01`: obstacles are not.
    - `unstable`: whether unstable cells are allowed, for a platform that something else holds.
    - `radian`: what a radian counts for in metres, where one axis is an angle and the other is not.

    **Returns:** a `Way`.

    **Raises:** `ValueError` for a bad argument; `SolveError` where no path leads to the
    goal.
    """
    known = isinstance(dataset, xr.Dataset) and "imposed" in dataset.attrs and "seam" in dataset
    if not (known and dataset["seam"].ndim == 2):
        raise InputError("Argument `dataset` must be a workspace map over two coordinates.")
    names = [str(name) for name in dataset["status"].dims]
    open_, price = _open(dataset, names, allowed, unstable), _price(dataset, names, cost)
    if not np.any(open_ & np.isfinite(price)):
        raise InputError(
            "Arguments `allowed` and `cost` must leave some cells, but they leave none."
        )
    open_ &= np.isfinite(price)
    if np.any(price[open_] < 0.0):
        raise InputError("Argument `cost` must not be negative, but some of it is.")
    field = CostField(
        [dataset[name].values for name in names],
        _weights(dataset, names, radian),
        np.where(open_, price, np.nan),
    )
    ends = [_end(dataset, names, field, k, v) for k, v in (("start", start), ("goal", goal))]
    if np.array_equal(ends[0], ends[1]):
        raise InputError("Argument `goal` must not be the point `start`.")
    found = field.path(*ends)
    if found is None:
        raise SolveError(
            Status.NOT_FOUND,
            f"No path leads from {ends[0].tolist()} to {ends[1].tolist()} through cells of the map "
            "that are solved, allowed" + (" and stable." if not unstable else "."),
        )
    corners, total = found
    length = float(np.sum(field.distance(corners[:-1], corners[1:])))
    points, imposed = _imposed(dataset, names, corners)
    return Way(points, imposed, total, length)


def _open(dataset: xr.Dataset, names, allowed, unstable: bool) -> np.ndarray:
    open_ = (dataset["status"].values == Status.SOLVED) & (dataset["seam"].values == 0)
    if not unstable:
        open_ &= dataset["stable"].values == 1
    if allowed is not None:
        mask = _over(allowed, dataset, names, "allowed")
        if mask.dtype != bool:
            raise InputError(
                "Argument `allowed` must be true or false in each cell, such as "
                f"`dataset['sigma_t1'] > 0.02`, but its type is {mask.dtype}."
            )
        open_ &= mask
    return open_


def _price(dataset: xr.Dataset, names, cost) -> np.ndarray:
    if cost is None or (isinstance(cost, str) and cost == "semi_axis_max" and cost not in dataset):
        return np.ones(dataset["status"].shape)
    if isinstance(cost, str):
        if cost not in dataset:
            raise InputError(
                f"Argument `cost` must be a variable of the map, but it is {shown(cost)}."
            )
        cost = dataset[cost]
    return _over(cost, dataset, names, "cost").astype(float)


def _over(values: Any, dataset: xr.Dataset, names, field: str) -> np.ndarray:
    """An array over the cells of a map; what has coordinates must have those of the map."""
    shape = dataset["status"].shape
    if isinstance(values, xr.DataArray):
        for name in names:
            if name in values.coords and not np.array_equal(values[name], dataset[name]):
                raise InputError(
                    f"Argument `{field}` must have the coordinates of the map, but its {name} "
                    "differs."
                )
        if set(values.dims) <= set(names):
            values = values.broadcast_like(dataset["status"]).transpose(*names)
    if np.shape(values) != shape:
        raise InputError(
            f"Argument `{field}` must be over {' and '.join(names)}, of shape {shape}, but its "
            f"shape is {np.shape(values)}."
        )
    return np.asarray(values)


def _weights(dataset: xr.Dataset, names, radian: float | None) -> Float[np.ndarray, "2"]:
    units = [dataset[name].attrs["units"] for name in names]
    if radian is not None:
        check_positive("radian", radian)
    if units[0] == units[1]:
        return np.ones(2)
    if radian is None:
        raise InputError(
            f"Argument `radian` must be given for a map over {' and '.join(names)}: what a radian "
            "counts for in metres."
        )
    return np.array([1.0 if unit == "m" else radian for unit in units])


def _end(dataset: xr.Dataset, names, field: CostField, name: str, value) -> Float[np.ndarray, "2"]:
    try:
        point = np.asarray(value, float)
    except (TypeError, ValueError):
        point = np.empty(0)
    if point.shape != (2,) or not np.all(np.isfinite(point)):
        raise InputError(
            f"Argument `{name}` must be two finite numbers, {' and '.join(names)}, but it is "
            f"{shown(value)}."
        )
    check_on_map(name, point[None], names, field.lines)
    cell = field.nearest(point)
    if not np.isfinite(field.price[cell]):
        status = Status(int(dataset["status"].values[cell]))
        why = "not allowed"
        if status != Status.SOLVED:
            why = status.name.lower()
        elif dataset["seam"].values[cell]:
            why = "on a seam"
        elif dataset["stable"].values[cell] == 0:
            why = "unstable"
        raise InputError(f"Argument `{name}` must be where a path may go, but its cell is {why}.")
    return point


def _imposed(dataset: xr.Dataset, names, corners):
    """The corners with all coordinates that the motors impose, and the names of those."""
    held = json.loads(dataset.attrs["held"])
    columns, imposed = [], tuple(json.loads(dataset.attrs["imposed"]))
    for label in imposed:
        name = label.removeprefix("p_P_")
        if name in names:
            columns.append(corners[:, names.index(name)])
            continue
        # Of a slice of a volume, what the third axis is there.
        value = held[label] if label in held else float(dataset[name])
        columns.append(np.full(len(corners), value))
    return np.stack(columns, axis=1), imposed
