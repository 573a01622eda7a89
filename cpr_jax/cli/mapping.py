"""The command that maps a workspace."""

import pathlib
import sys
from typing import Any

import matplotlib
import numpy as np
import xarray as xr

from ..errors import InputError
from ..plotting.map_figure import figure_of_map
from ..plotting.style import journal_style, save_figure
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium
from ..statics.status import SolveError, Status
from ..studies.limits import Limits
from ..studies.workspace import workspace_map
from .inputs import Request
from .map_inputs import MapRequest
from .session import NoSolution, load, print_json, solved, start_jax


def workspace(request: Request, options: MapRequest, as_json: bool) -> int:
    """Writes `map.nc` and figures of it; prints what is in it."""
    start_jax()
    matplotlib.use("Agg")
    robot = load(request.robot)
    out = pathlib.Path(options.out)
    try:
        dataset = workspace_map(
            robot,
            _seed(robot, request),
            spacing=_spacing(options.spacing),
            refine=options.refine,
            box=options.box,
            axes=options.axes,
            imposed=request.imposed,
            parameters=request.parameters,
            delta=request.delta,
            limits=Limits(torque=options.max_torque, moment=options.max_moment),
            steps=request.steps or DEFAULT_STEPS,
            out=out,
            resume=options.resume,
            progress=sys.stderr.isatty(),
        )
    except SolveError as error:
        raise NoSolution(str(error)) from None
    with journal_style():
        save_figure(figure_of_map(dataset, robot), out / "map")
    answer = describe(dataset)
    if as_json:
        print_json({**answer, "files": [str(out / f"map.{end}") for end in ("nc", "pdf", "png")]})
        return 0
    print(f"{robot.name}: {answer['solved']} of {answer['cells']} cells solved")
    for name, count in answer["status"].items():
        print(f"  {name:<14} {count}")
    spread = "no uncertainties are given"
    if answer["semi_axis_max"] is not None:
        low, high = answer["semi_axis_max"]
        spread = f"largest semi-axis {1e3 * low:.3g} to {1e3 * high:.3g} mm"
    print(f"{spread}, {answer['stable']} stable")
    print(f"map.nc and figures are in {out}")
    return 0


def describe(dataset: xr.Dataset) -> dict[str, Any]:
    """How many cells of a map ended how, and the range of its sensitivity."""
    status, index = dataset["status"].values, dataset["index"].values
    spread = None
    if "semi_axis_max" in dataset:
        axes = dataset["semi_axis_max"].values
        spread = [float(np.nanmin(axes)), float(np.nanmax(axes))]
    names = [str(name) for name in dataset["status"].dims]
    counts = {s.name.lower(): int(np.sum(status == s)) for s in Status}
    return {
        "cells": status.size,
        "solved": int(np.sum(index >= 0)),
        "status": {name: count for name, count in counts.items() if count},
        "stable": int(np.sum(index == 0)),
        "seam": int(dataset["seam"].sum()),
        "semi_axis_max": spread,
        "semi_axis_unit": "m",
        "axes": names,
        "axis_units": [dataset[name].attrs["units"] for name in names],
        "spacing": [float(np.diff(dataset[name])[0]) for name in names],
    }


def _spacing(given: tuple[float, ...] | None) -> float | tuple[float, ...] | None:
    return given[0] if given is not None and len(given) == 1 else given


def _seed(robot: Robot, request: Request) -> Equilibrium | None:
    if request.point is not None or request.motors is not None:
        return solved(robot, request)
    if robot.home is None:
        raise InputError(
            "Argument `--point` or `--motors` must say where the map begins, since the robot has "
            "no [home]."
        )
    return None
