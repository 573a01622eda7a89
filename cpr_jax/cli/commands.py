"""The commands that compute."""

import json
import os
import pathlib
import sys

import jax
import numpy as np

from ..analysis.ellipsoid import ellipsoid
from ..analysis.sensitivity import sensitivity as analyse
from ..plain import plain
from ..programs import use_cache
from ..robots import catalogue
from ..robots.files import robot_from_specification
from ..robots.names import CatalogueEntry
from ..robots.robot import Robot
from ..robots.specification import RobotSpecification
from ..statics.equilibrium import Equilibrium, solve_forward, solve_inverse
from ..statics.status import Status
from ..statics.unknowns import unknown_labels, unknown_units
from .inputs import Request


class NoSolution(Exception):
    """A solve without a solution; the message says why."""


def start_jax() -> None:
    """float64, and compiled programs kept between runs (`CPR_JAX_CACHE`, empty for none)."""
    jax.config.update("jax_enable_x64", True)
    folder = os.environ.get("CPR_JAX_CACHE")
    if folder != "":
        use_cache(folder)


def solve(request: Request, as_json: bool) -> int:
    """Prints one equilibrium."""
    robot, equilibrium = _equilibrium(request, as_json)
    answer = _describe(equilibrium)
    if as_json:
        print_json(answer)
        return 0
    labels, units = unknown_labels(robot), unknown_units(robot)
    print(f"{robot.name}: {answer['status']}, residual {answer['residual']:.1e}")
    print(f"branch: {equilibrium.branch}{_bows(robot, equilibrium)}")
    for label, unit, value in zip(labels, units, np.asarray(equilibrium.y), strict=True):
        print(f"  {label:<10} {value: .9g} {unit}")
    for i, torque in enumerate(np.asarray(equilibrium.motor_torques)):
        print(f"  tau{i + 1:<7} {torque: .9g} {'N m' if units[i] == 'rad' else 'N'}")
    print(f"  {'sigma_t1':<10} {answer['sigma_t1']:.3e}" if answer["sigma_t1"] else "")
    print(f"  {'sigma_t2':<10} {answer['sigma_t2']:.3e}")
    return 0


def sensitivity(request: Request, hold: str, as_json: bool) -> int:
    """Prints Π_p, the kernel and the ellipsoid of the end-effector."""
    robot, equilibrium = _equilibrium(request, as_json)
    result = analyse(robot, equilibrium, request.parameters, request.delta, hold)
    ellipse = ellipsoid(result)
    if as_json:
        print_json(
            {
                **_describe(equilibrium),
                "hold": hold,
                "parameters": result.columns,
                "parameter_units": result.column_units,
                "delta": result.delta,
                "states": result.rows,
                "Pi_y": result.Pi_y,
                "Pi_p": result.Pi_p,
                "kernel": ellipse.kernel,
                "semi_axes": ellipse.semi_axes,
                "directions": ellipse.directions,
                "tube_radius": result.tube_radius,
                "platform_stiffness": result.platform_stiffness,
            }
        )
        return 0
    print(f"{robot.name} at {np.asarray(equilibrium.q_p)}, {hold} held")
    print("Pi_p (rows: " + ", ".join(ellipse.labels) + ")")
    for j, (label, unit) in enumerate(zip(result.columns, result.column_units, strict=True)):
        column = "  ".join(f"{value: .6e}" for value in np.asarray(result.Pi_p[:, j]))
        print(f"  {label:<8} {column}  m per {unit}")
    for axis, direction in zip(ellipse.semi_axes, np.asarray(ellipse.directions), strict=True):
        print(f"semi-axis {1e3 * float(axis):9.4f} mm along {np.round(direction, 4)}")
    return 0


def monte_carlo(
    request: Request,
    samples: int,
    seed: int,
    distribution: str,
    prediction: str,
    out: str | None,
    resume: bool,
    as_json: bool,
) -> int:
    """Samples the parameters and prints the coverage of the ellipsoid."""
    from ..studies.monte_carlo import monte_carlo as sample
    from ..studies.results import samples_dataset, save_dataset

    robot, equilibrium = _equilibrium(request, as_json)
    result = sample(
        robot,
        equilibrium,
        samples,
        seed,
        parameters=request.parameters,
        delta=request.delta,
        distribution=distribution,
        prediction=prediction,
        folder=None if out is None else f"{out}.parts",
        resume=resume,
        progress=sys.stderr.isatty(),
    )
    if out is not None:
        n_a = robot.n_a
        units = unknown_units(robot)[n_a : n_a + robot.n_p]
        save_dataset(samples_dataset([result], ["point"], units), out)
        pathlib.Path(f"{out}.parts").rmdir()
    if as_json:
        print_json(
            {
                "coverage": result.coverage,
                "coverage_interval": result.coverage_interval,
                "solved": result.solved,
                "lost": result.lost,
                "failed": result.failed,
                "samples": result.samples,
                "followed": result.followed,
                "seed": seed,
                "distribution": distribution,
                "parameters": result.sensitivity.columns,
                "semi_axes": result.ellipsoid.semi_axes,
                "mean": result.mean,
                "covariance": result.covariance,
            }
        )
        return 0
    low, high = result.coverage_interval
    print(f"coverage {result.coverage:.2%} (95 % interval {low:.2%} to {high:.2%})")
    print(f"{result.samples} samples: {result.solved} solved, {result.lost} lost beyond a ")
    print(f"singularity, {result.failed} without an answer; {result.followed} followed closely")
    return 0


def paper(out: str, samples: int, seed: int, as_json: bool) -> int:
    """Makes the figures, the samples and the report of the paper."""
    # At once, so that a folder that cannot be is refused before anything is computed.
    pathlib.Path(out).mkdir(parents=True, exist_ok=True)
    start_jax()
    from ..plotting.paper import make_paper

    report = make_paper(out, samples, seed, progress=sys.stderr.isatty())
    if as_json:
        print_json(report)
        return 0
    for claim in report["claims"]:
        mark = "agrees" if claim["agrees"] else "DIFFERS"
        print(f"{mark:8} {claim['claim']}\n         computed: {claim['computed']}")
    print(f"Figures, samples and report are in {out}")
    return 0


def load(entry: CatalogueEntry | RobotSpecification) -> Robot:
    """The robot that a request names."""
    if isinstance(entry, CatalogueEntry):
        return getattr(catalogue, entry.function)()
    return robot_from_specification(entry)


def _equilibrium(request: Request, as_json: bool) -> tuple[Robot, Equilibrium]:
    start_jax()
    robot = load(request.robot)
    if request.point is not None:
        equilibrium = solve_inverse(robot, request.point, throw=False)
    else:
        assert request.motors is not None
        equilibrium = solve_forward(robot, request.motors, throw=False)
    status = Status(int(equilibrium.status))
    if status is not Status.SOLVED:
        if as_json:
            print_json({**_describe(equilibrium), "message": status.message})
        raise NoSolution(f"{robot.name}: {status.message}.")
    return robot, equilibrium


def _describe(equilibrium: Equilibrium) -> dict:
    measures = equilibrium.measures
    return {
        "status": Status(int(equilibrium.status)).name.lower(),
        "residual": plain(equilibrium.residual),
        "q_a": equilibrium.q_a,
        "q_p": equilibrium.q_p,
        "base_wrenches": equilibrium.base_wrenches,
        "motor_torques": equilibrium.motor_torques,
        "energy": plain(measures.energy),
        "sigma_t1": plain(measures.sigma_t1),
        "sigma_t2": plain(measures.sigma_t2),
        "condition": plain(measures.condition),
        "branch": equilibrium.branch,
        "bows": measures.bows,
    }


def _bows(robot: Robot, equilibrium: Equilibrium) -> str:
    if robot.geometry.d != 2:
        return ""
    sides = ["left" if bow > 0.0 else "right" for bow in np.asarray(equilibrium.measures.bows)]
    return f", seen from their bases the rods bow {', '.join(sides)}"


def print_json(value: object) -> None:
    """One JSON object on standard output."""
    print(json.dumps(plain(value)))
