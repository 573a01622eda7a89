"""The command that follows a path."""

import csv
import io
import pathlib
from typing import Any

import matplotlib
import numpy as np
import xarray as xr

from ..atomic import write_atomically
from ..plotting.style import journal_style, save_figure
from ..plotting.trajectory import plot_trajectory
from ..rods.integration import DEFAULT_STEPS
from ..statics.status import SolveError, Status
from ..studies.limits import Limits
from ..studies.results import save_dataset
from ..studies.trajectory import trajectory as follow
from ..studies.trajectory_dataset import events
from .inputs import Request
from .path_inputs import PathRequest
from .planned import planned
from .session import NoSolution, load, print_json, start_jax

_ROUNDING = 1e-13
"""Of the largest number of a column."""


def trajectory(request: Request, options: PathRequest, as_json: bool) -> int:
    """Writes `trajectory.nc`, the motors as CSV and a figure; prints what happens on the way."""
    start_jax()
    matplotlib.use("Agg")
    robot = load(request.robot)
    out = pathlib.Path(options.out)
    waypoints, seed = np.asarray(options.waypoints), None
    if options.plan is not None:
        waypoints, seed = planned(robot, options)
    try:
        dataset = follow(
            robot,
            waypoints,
            seed,
            imposed=request.imposed,
            spacing=options.spacing,
            parameters=request.parameters,
            delta=request.delta,
            limits=Limits(torque=options.max_torque, moment=options.max_moment),
            steps=request.steps or DEFAULT_STEPS,
        )
    except SolveError as error:
        raise NoSolution(f"The first waypoint: {error}") from None
    save_dataset(dataset, out / "trajectory.nc")
    table = _table(dataset)
    write_atomically(out / "trajectory.csv", lambda file: file.write_text(table))
    with journal_style():
        save_figure(plot_trajectory(dataset), out / "trajectory")
    answer = describe(dataset)
    if as_json:
        files = [str(out / f"trajectory.{end}") for end in ("nc", "csv", "pdf", "png")]
        print_json({**answer, "files": files})
    else:
        _print(robot.name, answer)
        print(f"trajectory.nc, its motors as CSV and figures are in {out}")
    for event in answer["events"]:
        if event["event"] == "end":
            status = Status[event["status"].upper()]
            # Which type of singularity a fold is depends on what the path imposes.
            why = "the branch folds back there" if status == Status.BEYOND_FOLD else status.message
            raise NoSolution(
                f"{robot.name}: the path ends at {answer['reached']:.6g} {answer['unit']} of "
                f"{answer['length']:.6g}: {why}."
            )
    return 0


def describe(dataset: xr.Dataset) -> dict[str, Any]:
    """Length, events and extremes of a trajectory."""
    solved = dataset["index"].values >= 0
    spread = None
    if "semi_axis_max" in dataset:
        axes = dataset["semi_axis_max"].values[solved]
        spread = [float(axes.min()), float(axes.max())]
    torque = dataset["motor_torque"]
    return {
        "stops": int(dataset.sizes["s"]),
        "solved": int(np.sum(solved)),
        "length": float(dataset["s"][-1]),
        "reached": dataset.attrs["reached"],
        "unit": dataset["s"].attrs["units"],
        "events": events(dataset),
        "semi_axis_max": spread,
        "semi_axis_unit": "m",
        "torque_max": float(np.nanmax(np.abs(torque.values))),
        "torque_unit": torque.attrs["units"],
    }


def _print(name: str, answer: dict[str, Any]) -> None:
    unit = answer["unit"]
    print(f"{name}: {answer['solved']} of {answer['stops']} stops solved")
    for event in answer["events"]:
        about = f" ({event['status']})" if "status" in event else ""
        print(f"  at {event['s']:.6g} {unit}: {event['event']}{about}")
    spread = ""
    if answer["semi_axis_max"] is not None:
        low, high = answer["semi_axis_max"]
        spread = f"largest semi-axis {1e3 * low:.3g} to {1e3 * high:.3g} mm, "
    print(f"{spread}largest motor torque {answer['torque_max']:.4g} {answer['torque_unit']}")


def _table(dataset: xr.Dataset) -> str:
    """What a controller needs of each stop: the path and the motors, SI units."""
    motors = [str(name) for name in dataset["motor"].values]
    platform = [str(name) for name in dataset["coordinate"].values]
    columns = np.column_stack(
        [dataset["s"], dataset["q_p"], dataset["q_a"], dataset["motor_torque"], dataset["stable"]]
    )
    largest = np.nanmax(np.abs(columns[:, :-1]), axis=0)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    torques = [name.replace("q", "tau") for name in motors]
    writer.writerow(["s", *platform, *motors, *torques, "stable"])
    for row, status in zip(columns, dataset["status"].values, strict=True):
        if status in (Status.SOLVED, Status.BEYOND_LIMITS):
            # Zero rather than what rounding leaves of it.
            kept = np.where(np.abs(row[:-1]) > _ROUNDING * largest, row[:-1], 0.0)
            writer.writerow([*(f"{value:.12g}" for value in kept), int(row[-1])])
    return text.getvalue()
