"""A trajectory as one labelled dataset, and what happens along it."""

import json
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float

from ..analysis.parameters import Selection
from ..errors import InputError
from ..robots.robot import Robot
from ..statics.status import Status
from ..statics.unknowns import unknown_labels, unknown_units
from .cells import Cell
from .variables import cell_coordinates, cell_variables, index_variables, status_attributes
from .versions import versions


class Along(NamedTuple):
    """What was found along a path.

    **Attributes:**

    - `s`: distance of each stop from the first, in `unit`.
    - `points`: imposed coordinates at the stops, `(stops, n_a)`, their `places` in `(q_a, q_p)`.
    - `at_corner`: which stops are waypoints.
    - `status`: of each stop.
    - `reached`: distance to where the branch ends.
    - `events`: see `events`.
    - `cells`: numbers of the stops that are solved.
    """

    s: np.ndarray
    points: np.ndarray
    at_corner: np.ndarray
    status: np.ndarray
    unit: str
    places: tuple[int, ...]
    reached: float
    events: list[dict[str, Any]]
    cells: Cell


def trajectory_dataset(
    robot: Robot, selection: Selection, delta: np.ndarray, along: Along
) -> xr.Dataset:
    """The dataset of a trajectory: NaN behind the end of the branch, and `status` says why."""
    labels, units = unknown_labels(robot), unknown_units(robot)
    cells, count = along.cells, len(along.s)
    solved = np.isin(along.status, (Status.SOLVED, Status.BEYOND_LIMITS))

    def entry(values, unit: str, text: str, *more: str):
        values = np.asarray(values)
        full = np.full((count, *values.shape[1:]), np.nan)
        full[solved] = values
        return (("s", *more), full, {"units": unit, "long_name": text})

    index = np.full(count, -1, np.int16)
    index[solved] = cells.unstable
    names = [labels[place] for place in along.places]
    imposed = {"units": "SI", "long_name": "imposed coordinates, see imposed_unit"}
    corner = {"units": "1", "long_name": "1 at the waypoints"}
    variables = {
        **cell_variables(robot, cells, along.places, selection, delta, entry),
        **index_variables(("s",), index),
    }
    return xr.Dataset(
        {
            "status": (("s",), along.status, status_attributes("a stop")),
            "target": (("s", "imposed"), along.points, imposed),
            "waypoint": (("s",), along.at_corner.astype(np.int8), corner),
            **variables,
        },
        coords={
            "s": ("s", along.s, {"units": along.unit, "long_name": "distance along the path"}),
            "imposed": names,
            "imposed_unit": ("imposed", [units[place] for place in along.places]),
            **cell_coordinates(robot, selection),
        },
        attrs={
            "title": f"Trajectory of {robot.name}",
            "robot": robot.name,
            "reached": along.reached,
            "events": json.dumps(along.events),
            "versions": json.dumps(versions()),
            "convention": "SI units, world axes",
        },
    )


def events(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """What happens along a trajectory, in the order of `s`.

    Each is a table with `s`, in the unit of the dataset's `s`, and `event`: `unstable` and `stable`
    where the robot becomes so, `type 2` where `det A_p` changes its sign without that, `beyond
    limits` and `within limits`, and `end` with the status of the stops behind it. Their places are
    found to a sixtieth of the usual distance of two stops, or better. Parts of a dataset have the
    events of the whole.
    """
    check_trajectory(dataset)
    return json.loads(dataset.attrs["events"])


def check_trajectory(dataset: Any) -> None:
    """Refuses what is no trajectory."""
    if not isinstance(dataset, xr.Dataset) or "events" not in dataset.attrs:
        raise InputError("Argument `dataset` must be one of `trajectory`, but it is another.")


def changes(
    s: Float[np.ndarray, " stops"], cells: Cell, beyond: Bool[np.ndarray, " stops"]
) -> list[dict[str, Any]]:
    """Events between stops, their places interpolated where σ of A_p vanishes, or in the middle.

    **Arguments:**

    - `beyond`: which stops are beyond a limit.
    """
    signed, index = cells.sign_t2 * cells.sigma_t2, np.asarray(cells.unstable)
    found: list[dict[str, Any]] = []
    for k in range(1, len(s)):
        middle = float(0.5 * (s[k - 1] + s[k]))
        crosses = signed[k - 1] * signed[k] < 0.0
        share = signed[k - 1] / (signed[k - 1] - signed[k]) if crosses else 0.5
        place = float(s[k - 1] + share * (s[k] - s[k - 1]))
        if (index[k] > 0) != (index[k - 1] > 0):
            name = "unstable" if index[k] > 0 else "stable"
            found.append({"s": place, "event": name, "index": int(index[k])})
        elif crosses:
            found.append({"s": place, "event": "type 2", "index": int(index[k])})
        if beyond[k] != beyond[k - 1]:
            name = "beyond limits" if beyond[k] else "within limits"
            found.append({"s": middle, "event": name})
    return found
