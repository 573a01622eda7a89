"""A workspace map as one labelled dataset."""

import json
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..analysis.parameters import Selection
from ..robots.robot import Robot
from ..statics.status import Status
from ..statics.unknowns import unknown_labels, unknown_units
from .cells import Cell
from .grid import Grid
from .versions import versions

_SENSITIVITIES = {
    *("semi_axis_max", "semi_axis_min", "ellipse_area", "direction", "Pi_p", "delta"),
}
"""Variables that a map of a robot without uncertain parameters does not have."""


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
    n_a = robot.n_a
    labels, units = unknown_labels(robot), unknown_units(robot)
    over = grid.names
    axis_units = [units[axis] for axis in grid.axes]
    cells, solved = found.cells, found.solved
    motor_unit = units[0] if len(set(units[:n_a])) == 1 else "rad or m"
    torque_unit = {"rad": "N m", "m": "N"}.get(motor_unit, "N m or N")

    def spread(values: np.ndarray) -> np.ndarray:
        values = np.asarray(values)
        full = np.full((*grid.shape, *values.shape[1:]), np.nan)
        full[solved] = values
        return full[found.stands_for]

    def entry(values, unit: str, text: str, *more: str):
        return ((*over, *more), spread(values), {"units": unit, "long_name": text})

    index = np.full(grid.shape, -1, np.int16)
    index[solved] = cells.unstable
    index = index[found.stands_for]
    branch = np.where(index >= 0, 0, -1).astype(np.int8)
    flags = {
        "flag_values": np.array([int(s) for s in Status], np.int8),
        "flag_meanings": " ".join(s.name.lower() for s in Status),
        "long_name": "why a cell has no equilibrium",
    }
    major, minor = cells.semi_axes[:, 0], cells.semi_axes[:, -1]
    area = np.pi * cells.semi_axes[:, 0] * cells.semi_axes[:, 1]
    variables = {
        "status": (over, found.status[found.stands_for], flags),
        "semi_axis_max": entry(major, "m", "largest semi-axis of the uncertainty ellipsoid"),
        "semi_axis_min": entry(minor, "m", "smallest semi-axis of the uncertainty ellipsoid"),
        "ellipse_area": entry(area, "m2", "area of the ellipse of its two largest semi-axes"),
        "direction": entry(
            cells.directions[:, 0], "1", "direction of the largest semi-axis", "space"
        ),
        "Pi_p": entry(
            cells.Pi_p,
            "SI",
            "sensitivity of the platform, motors held",
            "coordinate",
            "parameter",
        ),
        "sigma_t1": entry(cells.sigma_t1, "1", "smallest singular value of A_q, platform held"),
        "sigma_t2": entry(cells.sigma_t2, "1", "smallest singular value of A_p, motors held"),
        "stable": (
            over,
            (index == 0).astype(np.int8),
            {"units": "1", "long_name": "1 where no motion lowers the potential energy"},
        ),
        "index": (
            over,
            index,
            {"units": "1", "long_name": "unstable directions, motors held; -1 where unsolved"},
        ),
        "branch": (
            over,
            branch,
            {"units": "1", "long_name": "0 on the branch of the seed, -1 where unsolved"},
        ),
        "seam": (
            over,
            found.seam[found.stands_for].astype(np.int8),
            {
                "units": "1",
                "long_name": "1 beside a cell on another sheet of the branch",
            },
        ),
        "level": (
            over,
            found.level,
            {"units": "1", "long_name": "how often the spacing was halved there"},
        ),
        "q_a": entry(cells.q_a, motor_unit, "motor positions", "motor"),
        "q_p": entry(cells.q_p, "m, rad", "platform coordinates", "coordinate"),
        "mu": entry(cells.mu, "SI", "unknowns of the legs, see mu_label", "leg", "wrench"),
        "motor_torque": entry(cells.motor_torques, torque_unit, "motor torques", "motor"),
        "energy": entry(cells.energy, "J", "total potential energy"),
        "bow": entry(cells.bows, "1", "which way and how far each rod bows", "leg"),
        "manipulability": entry(cells.manipulability, "SI", "sqrt(det(J J^T)), J = dp_P/dq_a"),
        "manipulability_condition": entry(
            cells.manipulability_condition, "1", "smallest over largest singular value of J"
        ),
        "curvature": entry(cells.curvature, "1/m", "largest curvature along the rods"),
        "moment": entry(cells.moment, "N m", "largest internal moment along the rods"),
        "residual": entry(cells.residual, "1", "largest entry of the dimensionless residual"),
        "delta": (("parameter",), np.asarray(delta), {"long_name": "half ranges (6)"}),
    }
    for name, curves in lines.items():
        kind = "Type 1" if name == "t1_line" else "Type 2"
        text = f"{kind} singularities of the branch"
        curve_units = {"units": axis_units[0] if len(set(axis_units)) == 1 else "m or rad"}
        variables[name] = (("curve", "point", "axis"), curves, curve_units | {"long_name": text})
    longest = max([len(c) for curves in lines.values() for c in curves] or [0])
    most = max(len(curves) for curves in lines.values())
    for name, curves in lines.items():
        padded = np.full((most, longest, 2), np.nan)
        for k, curve in enumerate(curves):
            padded[k, : len(curve)] = curve
        dims, _, attributes = variables[name]
        variables[name] = (dims, padded, attributes)
    if not selection.labels:
        variables = {name: kept for name, kept in variables.items() if name not in _SENSITIVITIES}
    held = {labels[k]: float(grid.held[k]) for k in imposed if k not in grid.axes}
    coordinates = {
        name: (name, values, {"units": unit, "long_name": f"platform coordinate {name}"})
        for name, values, unit in zip(grid.names, grid.coordinates, axis_units, strict=True)
    }
    return xr.Dataset(
        variables,
        coords={
            **coordinates,
            "motor": list(labels[:n_a]),
            **unknowns_of_legs(robot),
            "coordinate": list(labels[n_a : n_a + robot.n_p]),
            "parameter": list(selection.labels),
            "parameter_unit": ("parameter", list(selection.units)),
            "axis": list(grid.names),
            "space": list(robot.geometry.axes),
        },
        attrs={
            "title": f"Workspace map of {robot.name}",
            "robot": robot.name,
            "held": json.dumps(held),
            "versions": json.dumps(versions()),
            "convention": "SI units, world axes",
        },
    )


def unknowns_of_legs(robot: Robot) -> dict[str, Any]:
    """Coordinates that say what `mu` is: label and unit of each unknown of each leg.

    Along `wrench` they are base wrenches in world axes; of robots with passive joints at the base,
    whose legs have unknowns of their own along the axes of the joints, just counted.
    """
    geometry = robot.geometry
    names = [f"n_{axis}" for axis in geometry.axes]
    names += [f"m_{axis}" for axis in geometry.rotation_axes]
    if robot.legs.base_joint is not None:
        names = [str(k + 1) for k in range(geometry.freedoms)]

    def of_legs(values):
        return np.array(values[robot.n_a + robot.n_p :]).reshape(robot.n, geometry.freedoms)

    return {
        "wrench": names,
        "mu_label": (("leg", "wrench"), of_legs(unknown_labels(robot))),
        "mu_unit": (("leg", "wrench"), of_legs(unknown_units(robot))),
    }
