"""Ways between waypoints that are planned on a map of `cpr-jax workspace`."""

import itertools
import json
import pathlib

import numpy as np
import xarray as xr

from ..errors import InputError, shown
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.status import SolveError
from ..studies.equilibria import equilibrium_at
from ..studies.parts import digest
from ..studies.planning import plan_path
from .path_inputs import PathRequest
from .session import NoSolution

_ALIKE = 1e-9


def planned(robot: Robot, options: PathRequest) -> tuple[np.ndarray, Equilibrium]:
    """Waypoints between those of the options, on the map in the folder `options.plan`, and where
    their path begins: the map may be of another branch than that of the home.

    **Raises:** `InputError` for what is no map of the robot and of the coordinates of the
    waypoints; `NoSolution` where no path leads from one waypoint to the next.
    """
    assert options.plan is not None
    dataset = _map_in(options.plan, robot)
    labels = [label.removeprefix("p_P_") for label in json.loads(dataset.attrs["imposed"])]
    if set(labels) != set(options.names):
        raise InputError(
            f"Argument `--plan` must be a map over {', '.join(options.names)}, but that in "
            f"{options.plan} imposes {', '.join(labels)}."
        )
    order = [labels.index(name) for name in options.names]
    waypoints = np.asarray(options.waypoints)
    axes = [options.names.index(str(name)) for name in dataset["status"].dims]
    corners = [waypoints[:1]]
    for start, goal in itertools.pairwise(waypoints):
        try:
            way = plan_path(dataset, start[axes], goal[axes])
        except InputError as error:
            text = str(error).replace("`start`", options.field).replace("`goal`", options.field)
            raise InputError(text) from None
        except SolveError as error:
            raise NoSolution(f"{robot.name}: {error}") from None
        points = way.points[:, order]
        for end, point in ((start, points[0]), (goal, points[-1])):
            if not np.allclose(end, point, rtol=0.0, atol=_ALIKE):
                raise InputError(
                    f"Argument {options.field} must keep what the map holds, "
                    f"{dataset.attrs['held']} in SI units, but a waypoint is {end.tolist()}."
                )
        corners.append(points[1:])
    first = dict(
        zip((str(name) for name in dataset["status"].dims), waypoints[0][axes], strict=True)
    )
    cell = dataset.sel(first, method="nearest")
    y = np.concatenate([np.ravel(cell[name].values) for name in ("q_a", "q_p", "mu")])
    return np.concatenate(corners), equilibrium_at(robot, y, "map")


def _map_in(folder: str, robot: Robot) -> xr.Dataset:
    path = pathlib.Path(folder)
    path = path / "map.nc" if path.is_dir() else path
    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            dataset.load()
        configuration = json.loads(dataset.attrs["configuration"])
    except (OSError, ValueError, KeyError):
        raise InputError(
            "Argument `--plan` must be a folder that `cpr-jax workspace` has written, but "
            f"{shown(folder)} has no map."
        ) from None
    if configuration["robot_digest"] != digest(robot):
        raise InputError(
            f"Argument `--plan` must be a map of {robot.name} as it is now, but that in "
            f"{folder} is of {configuration['robot']} with other numbers."
        )
    return dataset
