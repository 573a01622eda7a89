"""The commands that compute."""

import contextlib
import pathlib
import sys
from collections.abc import Iterator

import numpy as np

from ..analysis.ellipsoid import Ellipsoid, ellipsoid, linear_coverage
from ..analysis.sensitivity import Sensitivity
from ..analysis.sensitivity import sensitivity as analyse
from ..analysis.slopes import Hold
from ..analysis.stability import stability
from ..errors import InputError
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium
from ..statics.unknowns import unknown_labels, unknown_units
from .inputs import Request
from .session import describe, print_json, solve_request


def solve(request: Request, as_json: bool) -> int:
    """Prints one equilibrium."""
    robot, equilibrium = solve_request(request, as_json, brief=True)
    answer = describe(robot, equilibrium)
    if as_json:
        print_json(answer)
        return 0
    labels, units = unknown_labels(robot), unknown_units(robot)
    print(f"{robot.name}: {answer['status']}, residual {answer['residual']:.1e}")
    print(f"branch: {equilibrium.branch}{_bows(robot, equilibrium)}")
    for label, unit, value in zip(labels, units, np.asarray(equilibrium.y), strict=True):
        print(f"  {label:<10} {value: .9g} {unit}")
    for line in _base_wrenches(robot, equilibrium):
        print(line)
    for i, torque in enumerate(np.asarray(equilibrium.motor_torques)):
        print(f"  tau{i + 1:<7} {torque: .9g} {'N m' if units[i] == 'rad' else 'N'}")
    print(f"  {'energy':<10} {answer['energy']: .9g} J")
    for name in ("sigma_t1", "sigma_t2"):
        if answer[name] is not None:
            print(f"  {name:<10} {answer[name]:.3e}")
    return 0


def sensitivity(request: Request, hold: str, as_json: bool) -> int:
    """Prints Π_p, the kernel and the ellipsoids of the end-effector."""
    robot, equilibrium = solve_request(request, as_json, brief=True)
    steps = request.steps or DEFAULT_STEPS
    result = analyse(robot, equilibrium, request.parameters, request.delta, hold, steps)
    index = _index(robot, equilibrium, steps)
    if as_json:
        print_json(
            {
                **describe(robot, equilibrium),
                "stability_index": index,
                "hold": hold,
                "parameters": result.columns,
                "parameter_units": result.column_units,
                "delta": result.delta,
                "states": result.rows,
                "state_units": unknown_units(robot),
                "Pi_y": result.Pi_y,
                "Pi_p": result.Pi_p,
                "Pi_turn": result.Pi_turn,
                **_ellipsoids(robot, result),
                "tube_radius": result.tube_radius,
                "platform_stiffness": result.platform_stiffness,
            }
        )
        return 0
    # Zero rather than what rounding leaves of it; neither nanometres nor nanoradians matter here.
    place = np.round(np.asarray(equilibrium.q_p), 9) + 0.0
    print(f"{robot.name} at {place}, {hold} held")
    if hold == Hold.PLATFORM.value:
        motors, units = result.rows[: robot.n_a], unknown_units(robot)[: robot.n_a]
        unit = " or ".join(dict.fromkeys(units))
        _print_columns("Pi_q", motors, result, np.asarray(result.Pi_y)[: robot.n_a], unit)
        for motor, radius, unit in zip(motors, np.asarray(result.tube_radius), units, strict=False):
            print(f"{motor:<9} {radius:.6e} {unit}")
        return 0
    _print_columns("Pi_p", ellipsoid(result).labels, result, result.Pi_p, "m")
    if robot.oriented:
        turn = ellipsoid(result, "turn_P")
        _print_columns("Pi_turn", turn.labels, result, result.Pi_turn, "rad")
    _print_ellipsoids(robot, result)
    return 0


def monte_carlo(
    request: Request,
    samples: int,
    seed: int,
    distribution: str,
    prediction: str,
    keep: int,
    out: str | None,
    resume: bool,
    as_json: bool,
) -> int:
    """Samples the parameters and prints the coverage of the ellipsoid of the position."""
    from ..studies.monte_carlo import monte_carlo as sample
    from ..studies.results import samples_dataset, save_dataset

    if out is not None and pathlib.Path(out).is_dir():
        raise InputError(f"Argument `--out` must be a file to write, but {out} is a folder.")
    robot, equilibrium = solve_request(request, as_json)
    index = _index(robot, equilibrium, request.steps or DEFAULT_STEPS)
    about = {
        "robot": robot.name,
        "seed": seed,
        "distribution": distribution,
        "prediction": prediction,
    }

    def save(study) -> None:
        if out is not None:
            save_dataset(samples_dataset(study, about), out)

    result = sample(
        robot,
        equilibrium,
        samples,
        seed,
        parameters=request.parameters,
        delta=request.delta,
        distribution=distribution,
        prediction=prediction,
        keep=keep,
        folder=None if out is None else f"{out}.parts",
        resume=resume,
        save=save,
        steps=request.steps,
        progress=sys.stderr.isatty(),
    )
    if out is not None:
        # What somebody has put there stays.
        with contextlib.suppress(OSError):
            pathlib.Path(f"{out}.parts").rmdir()
        if keep < samples:
            print(
                f"the first {keep} of {samples} samples are in {out}, see --keep", file=sys.stderr
            )
    expected = _linear_coverage(result.ellipsoid) if distribution == "gaussian" else None
    if as_json:
        print_json(
            {
                "stability_index": index,
                "coverage": result.coverage,
                "coverage_interval": result.coverage_interval,
                "linear_coverage": expected,
                "solved": result.solved,
                "lost": result.lost,
                "failed": result.failed,
                "samples": result.samples,
                "followed": result.followed,
                "seed": seed,
                "distribution": distribution,
                "parameters": result.sensitivity.columns,
                **_ellipsoids(robot, result.sensitivity),
                "mean": result.mean,
                "covariance": result.covariance,
            }
        )
        return 0
    low, high = result.coverage_interval
    linear = "" if expected is None else f", linear theory {expected:.2%}"
    print(f"coverage {result.coverage:.2%} (95 % interval {low:.2%} to {high:.2%}{linear})")
    print(
        f"{result.samples} samples: {result.solved} solved, {result.lost} lost beyond a "
        f"singularity, {result.failed} without an answer; {result.followed} followed closely"
    )
    _print_ellipsoids(robot, result.sensitivity)
    return 0


def _index(robot: Robot, equilibrium: Equilibrium, steps: int) -> int:
    """Number of unstable directions with the motors held; says so where there are any."""
    index = int(stability(robot, equilibrium, steps).index)
    if index > 0:
        ways = "one direction" if index == 1 else f"{index} directions"
        print(
            f"{robot.name}: this equilibrium is unstable in {ways} with the motors held: the robot "
            "does not stay here, and no ellipsoid is about where it goes",
            file=sys.stderr,
        )
    return index


def _bows(robot: Robot, equilibrium: Equilibrium) -> str:
    if robot.geometry.d != 2:
        return ""
    sides = ["left" if bow > 0.0 else "right" for bow in np.asarray(equilibrium.measures.bows)]
    return f", seen from their bases the rods bow {', '.join(sides)}"


def _base_wrenches(robot: Robot, equilibrium: Equilibrium) -> Iterator[str]:
    """Lines for a robot with passive joints at the base, whose unknowns are not its wrenches."""
    if robot.legs.base_joint is None:
        return
    geometry = robot.geometry
    names = [f"n_{axis}" for axis in geometry.axes]
    names += [f"m_{axis}" for axis in geometry.rotation_axes]
    units = ["N"] * geometry.d + ["N m"] * geometry.r
    for i, wrench in enumerate(np.asarray(equilibrium.base_wrenches), start=1):
        for name, value, unit in zip(names, wrench, units, strict=True):
            label = f"{name[0]}{i}{name[1:]}"
            yield f"  {label:<10} {value: .9g} {unit} at the base of rod {i}"


def _ellipsoids(robot: Robot, result: Sensitivity) -> dict:
    """The ellipsoid of the position, and of the orientation of a body, as JSON."""

    def described(ellipse: Ellipsoid, unit: str) -> dict:
        return {
            "rows": ellipse.labels,
            "kernel": ellipse.kernel,
            "semi_axes": ellipse.semi_axes,
            "semi_axes_unit": unit,
            "directions": ellipse.directions,
        }

    orientation = described(ellipsoid(result, "turn_P"), "rad") if robot.oriented else None
    return {**described(ellipsoid(result), "m"), "orientation": orientation}


def _print_columns(name: str, rows, result: Sensitivity, matrix, unit: str) -> None:
    print(f"{name} (rows: {', '.join(rows)})")
    columns = zip(result.columns, result.column_units, np.asarray(matrix).T, strict=True)
    for label, per, values in columns:
        column = "  ".join(f"{value: .6e}" for value in values)
        print(f"  {label:<8} {column}  {unit} per {per}")


def _print_ellipsoids(robot: Robot, result: Sensitivity) -> None:
    shown = [(ellipsoid(result), "semi-axis", "mm along")]
    if robot.oriented:
        shown.append((ellipsoid(result, "turn_P"), "turn", "mrad about"))
    for ellipse, name, unit in shown:
        for axis, direction in zip(ellipse.semi_axes, np.asarray(ellipse.directions), strict=True):
            print(f"{name:<9} {1e3 * float(axis):9.4f} {unit} {np.round(direction, 4)}")


def _linear_coverage(ellipse: Ellipsoid) -> float:
    """What linear theory has inside; in a direction without uncertainty everything is."""
    axes = np.asarray(ellipse.semi_axes)
    return linear_coverage(int(np.sum(axes > 1e-12 * axes[0])))
