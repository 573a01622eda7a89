"""What the commands that compute share: JAX, robots, equilibria, JSON."""

import gc
import importlib
import json
import os

import jax

from ..plain import plain
from ..programs import use_cache
from ..robots.files import robot_from_specification
from ..robots.names import CatalogueEntry
from ..robots.robot import Robot
from ..robots.specification import RobotSpecification
from ..statics.equilibrium import Equilibrium
from ..statics.solve import solve_forward, solve_inverse
from ..statics.status import SolveError, Status
from ..statics.unknowns import unknown_units
from .inputs import Request


class NoSolution(Exception):
    """A solve without a solution; the message says why."""


def start_jax(brief: bool = False) -> None:
    """float64, and compiled programs kept between runs (`CPR_JAX_CACHE`, empty for none).

    **Arguments:**

    - `brief`: whether a command solves but once. It then waits for compilation above all.
    """
    # All is imported by now.
    gc.enable()
    jax.config.update("jax_enable_x64", True)
    if brief:
        jax.config.update("jax_disable_most_optimizations", True)
    folder = os.environ.get("CPR_JAX_CACHE")
    if folder != "":
        use_cache(folder)


def load(entry: CatalogueEntry | RobotSpecification) -> Robot:
    """The robot that a request names."""
    if isinstance(entry, CatalogueEntry):
        module = importlib.import_module(f"..robots.{entry.module}", __package__)
        return getattr(module, entry.function)()
    return robot_from_specification(entry)


def solved(robot: Robot, request: Request) -> Equilibrium:
    """The equilibrium at the point or the motors of a request, which has one of them."""
    if request.point is not None:
        imposed, steps = request.imposed, request.steps
        return solve_inverse(robot, request.point, imposed=imposed, steps=steps)
    assert request.motors is not None
    return solve_forward(robot, request.motors, steps=request.steps)


def solve_request(
    request: Request, as_json: bool, brief: bool = False
) -> tuple[Robot, Equilibrium]:
    """The equilibrium that a request asks for.

    **Arguments:**

    - `brief`: see `start_jax`.

    **Raises:** `NoSolution`, with the status printed as JSON if that is asked for.
    """
    start_jax(brief)
    robot = load(request.robot)
    try:
        return robot, solved(robot, request)
    except SolveError as error:
        assert isinstance(error.equilibrium, Equilibrium)
        if as_json:
            message = error.status.message
            print_json({**describe(robot, error.equilibrium), "message": message})
        hint = f" {error.hint}" if error.hint else ""
        raise NoSolution(f"{robot.name}: {error.status.message}.{hint}") from None


def describe(robot: Robot, equilibrium: Equilibrium) -> dict:
    """An equilibrium as JSON: SI units, world axes."""
    measures = equilibrium.measures
    return {
        "status": Status(int(equilibrium.status)).name.lower(),
        "residual": plain(equilibrium.residual),
        "q_a": equilibrium.q_a,
        "motor_units": unknown_units(robot)[: robot.n_a],
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


def print_json(value: object) -> None:
    """One JSON object on standard output."""
    print(json.dumps(plain(value)))
