"""A workspace map as one labelled dataset."""

import json
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..analysis.parameters import Selection
from ..robots.robot import Robot
from ..statics.unknowns import unknown_labels, unknown_units
from .cells import Cell
from .grid import Grid
from .variables import cell_coordinates, cell_variables, index_variables, status_attributes
from .versions import versions


class Found(NamedTuple):
    """What was found on a grid.

    **Attributes:**

    - `status`, `solved`, `seam`: over the grid.
    - `cells`: of the solved ones, in order.
    - `stands_for`: indices of the cell that stands for each; itself but where a map is coarse.
    - `level`: how often the spacing was halved there.
    """

    status: np.ndarray
    solved: np.ndarray
    seam: np.ndarray
    cells: Cell
    stands_for: tuple[np.ndarray, np.ndarray]
    level: np.ndarray


def map_dataset(
    robot: Robot,
    grid: Grid,
    imposed: tuple[int, ...],
    selection: Selection,
    delta: np.ndarray,
    found: Found,
    lines: dict[str, list[np.ndarray]],
) -> xr.Dataset:
    """The dataset of a map: NaN where there is no equilibrium, and `status` says why.

    Dimensions: the two coordinates; `motor`, `leg`, `wrench`, `coordinate` (of the platform),
    `parameter`, `rank` (semi-axes, largest first), `axis` (of the plane of the map); `curve` and
    `point` of the singular curves `t1_line` and `t2_line`, padded with NaN. Each variable has
    its unit and says what it is.
    """
    labels, units = unknown_labels(robot), unknown_units(robot)
    over = grid.names
    axis_units = [units[axis] for axis in grid.axes]
    cells, solved = found.cells, found.solved

    def entry(values, unit: str, text: str, *more: str):
        values = np.asarray(values)
        full = np.full((*grid.shape, *values.shape[1:]), np.nan)
        full[solved] = values
        return ((*over, *more), full[found.stands_for], {"units": unit, "long_name": text})

    def flag(values, text: str):
        return (over, values, {"units": "1", "long_name": text})

    index = np.full(grid.shape, -1, np.int16)
    index[solved] = cells.unstable
    index = index[found.stands_for]
    branch = np.where(index >= 0, 0, -1).astype(np.int8)
    seam = found.seam[found.stands_for].astype(np.int8)
    variables = {
        "status": (over, found.status[found.stands_for], status_attributes("a cell")),
        **cell_variables(robot, cells, imposed, selection, delta, entry),
        **index_variables(over, index),
        "branch": flag(branch, "0 on the branch of the seed, -1 where unsolved"),
        "seam": flag(seam, "1 beside a cell on another sheet of the branch"),
        "level": flag(found.level, "how often the spacing was halved there"),
        **_curves(lines, axis_units),
    }
    held = {labels[k]: float(grid.held[k]) for k in imposed if k not in grid.axes}
    coordinates = {
        name: (name, values, {"units": unit, "long_name": f"platform coordinate {name}"})
        for name, values, unit in zip(grid.names, grid.coordinates, axis_units, strict=True)
    }
    return xr.Dataset(
        variables,
        coords={
            **coordinates,
            **cell_coordinates(robot, selection),
            "axis": list(grid.names),
        },
        attrs={
            "title": f"Workspace map of {robot.name}",
            "robot": robot.name,
            "imposed": json.dumps([labels[k] for k in imposed]),
            "held": json.dumps(held),
            "versions": json.dumps(versions()),
            "convention": "SI units, world axes",
        },
    )


def _curves(lines: dict[str, list[np.ndarray]], axis_units: list[str]) -> dict[str, Any]:
    """Singular curves, all of one length."""
    longest = max([len(c) for curves in lines.values() for c in curves] or [0])
    most = max(len(curves) for curves in lines.values())
    unit = axis_units[0] if len(set(axis_units)) == 1 else "m or rad"
    variables = {}
    for name, curves in lines.items():
        kind = "Type 1" if name == "t1_line" else "Type 2"
        padded = np.full((most, longest, 2), np.nan)
        for k, curve in enumerate(curves):
            padded[k, : len(curve)] = curve
        text = {"units": unit, "long_name": f"{kind} singularities of the branch"}
        variables[name] = (("curve", "point", "axis"), padded, text)
    return variables
