"""The numbers of many equilibria as labelled variables, whatever they are spread over."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..analysis.parameters import Selection
from ..robots.robot import Robot
from ..statics.status import Status
from ..statics.unknowns import unknown_labels, unknown_units
from .cells import Cell

_SENSITIVITIES = {
    *("semi_axis_max", "semi_axis_min", "ellipse_area", "direction", "Pi_p", "delta"),
}
"""Variables that a robot without uncertain parameters does not have."""

Entry = Callable[..., Any]
"""Makes a variable from values of all equilibria along a first axis, a unit, what they are, and
the names of further axes."""


def cell_variables(
    robot: Robot,
    cells: Cell,
    places: tuple[int, ...],
    selection: Selection,
    delta: np.ndarray,
    entry: Entry,
) -> dict[str, Any]:
    """Variables of a dataset; those of sensitivities only where something varies.

    **Arguments:**

    - `places`: of the imposed coordinates in `(q_a, q_p)`.
    """
    platform = set(range(robot.n_a, robot.n_a + robot.n_p))
    held = "A_q, platform held"
    if set(places) != platform:
        held = "the Jacobian with the imposed coordinates held"
    motor_unit, torque_unit = motor_units(robot)
    major, minor = cells.semi_axes[:, 0], cells.semi_axes[:, -1]
    area = np.pi * cells.semi_axes[:, 0] * cells.semi_axes[:, 1]
    variables = {
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
        "sigma_t1": entry(cells.sigma_t1, "1", f"smallest singular value of {held}"),
        "sigma_t2": entry(cells.sigma_t2, "1", "smallest singular value of A_p, motors held"),
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
        "tip_error": entry(
            cells.tip_error, "1", "estimated integration error of the rods' tips, in rod lengths"
        ),
        "delta": (("parameter",), np.asarray(delta), {"long_name": "half ranges (6)"}),
    }
    if not selection.labels:
        return {name: kept for name, kept in variables.items() if name not in _SENSITIVITIES}
    return variables


def index_variables(over: tuple[str, ...], index: np.ndarray) -> dict[str, Any]:
    """Stability from the number of unstable directions, -1 where nothing is solved."""
    stable = {"units": "1", "long_name": "1 where no motion lowers the potential energy"}
    counted = {"units": "1", "long_name": "unstable directions, motors held; -1 where unsolved"}
    return {
        "stable": (over, (index == 0).astype(np.int8), stable),
        "index": (over, index, counted),
    }


def status_attributes(what: str) -> dict[str, Any]:
    """Attributes of a variable of `Status` codes."""
    return {
        "flag_values": np.array([int(s) for s in Status], np.int8),
        "flag_meanings": " ".join(s.name.lower() for s in Status),
        "long_name": f"why {what} has no equilibrium",
    }


def motor_units(robot: Robot) -> tuple[str, str]:
    """SI units of the motor positions and torques."""
    units = unknown_units(robot)[: robot.n_a]
    motor_unit = units[0] if len(set(units)) == 1 else "rad or m"
    return motor_unit, {"rad": "N m", "m": "N"}.get(motor_unit, "N m or N")


def cell_coordinates(robot: Robot, selection: Selection) -> dict[str, Any]:
    """What the further axes of the variables are called."""
    labels = unknown_labels(robot)
    n_a = robot.n_a
    return {
        "motor": list(labels[:n_a]),
        **unknowns_of_legs(robot),
        "coordinate": list(labels[n_a : n_a + robot.n_p]),
        "parameter": list(selection.labels),
        "parameter_unit": ("parameter", list(selection.units)),
        "space": list(robot.geometry.axes),
    }


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
