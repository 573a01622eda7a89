"""The forward and the inverse geometrico-static problem."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..errors import InputError, check_integer
from ..geometry import Numbers, floats, namespace
from ..outline import are_traced
from ..robots.robot import Robot, check_turns
from .accuracy import BALANCED, ROUGH, STEPS
from .assembly import at_rest, from_home, reaching
from .continuation import Track
from .equilibrium import Equilibrium, check_fits, polish
from .nearest import nearest_turn
from .neighbour import from_neighbour
from .problem import forward_rows, imposed_coordinates, imposed_rows
from .reach import hardly_metres, out_of_reach
from .search import from_home_at_random, search
from .solve_ahead import compile_polish
from .status import SolveError, Status
from .unknowns import slides
from .ways import detours

_MANY_TURNS = 4.0 * np.pi
"""Angles beyond which a motor position looks like one in degrees."""


def solve_inverse(
    robot: Robot,
    point: Numbers,
    *,
    imposed: Sequence[str] | None = None,
    guess: Equilibrium | None = None,
    steps: int | None = None,
    throw: bool = True,
) -> Equilibrium:
    """The motor positions and the shape that put the platform at a point (15).

    **Arguments:**

    - `robot`: with as many motors as coordinates are imposed.
    - `point`: desired `q_p`: the position, m, and for a body its rotation vector, rad; or the
        values of `imposed`, in their order. Of a whole orientation in space any rotation vector
        will do: the branch is followed to the one that is nearest.
    - `imposed`: names of the coordinates to impose, where they are not those of the platform:
        as many as there are motors, such as `("x", "y", "z")` for three motors that move a body,
        see `imposed_coordinates`. `resolve_redundancy` is for robots with more motors.
    - `guess`: an equilibrium from which the branch is followed along a line. Without it, the
        branch is the one of the robot's home configuration; a robot without one is searched
        systematically and its equilibrium of least energy is taken.
    - `steps`: integration steps along each rod; `measures.unbalanced` tells what error they leave,
        and any is accepted. By default as many as keep it below `accuracy.BALANCED`.
    - `throw`: raise where there is no solution; otherwise the status tells. Under `jax.jit`,
        `jax.vmap` and the like nothing raises, and the number of steps is the usual one: what it
        leaves unbalanced by more than `accuracy.ROUGH` is `INACCURATE`.

    **Returns:**

    An `Equilibrium`, differentiable in every number of `robot` and in `point`.

    **Raises:** `ValueError` for a bad argument; `SolveError` where there is no solution.
    """
    _check_call(robot, guess, steps)
    places = imposed_coordinates(robot, imposed)
    point = _checked("point", point, robot.n_a, robot)
    xp = namespace(point)
    target = xp.asarray(point) @ np.eye(robot.n_a + robot.n_p)[list(places)]
    turns = range(robot.n_a + robot.geometry.d, robot.n_a + robot.n_p)
    turned = len(turns) == 3 and set(turns) <= set(places)
    return _solve(robot, imposed_rows(robot, places), floats(target), guess, steps, throw, turned)


def solve_forward(
    robot: Robot,
    q_a: Numbers,
    *,
    guess: Equilibrium | None = None,
    steps: int | None = None,
    throw: bool = True,
) -> Equilibrium:
    """The platform pose and the shape that belong to motor positions.

    Arguments as in `solve_inverse`, with `q_a` the motor positions, rad or m.
    """
    _check_call(robot, guess, steps)
    q_a = _checked("q_a", q_a, robot.n_a, robot)
    target = floats(namespace(q_a).pad(q_a, (0, robot.n_p)))
    return _solve(robot, forward_rows(robot), target, guess, steps, throw, False)


def _solve(robot, imposed, target, guess, steps, throw, turned):
    traced = are_traced(jax.tree.leaves((robot, target, guess)))
    alone = "search" if robot.home is None else "home"
    # An equilibrium followed from another one is on its branch: a loop may carry it on.
    branch = alone if guess is None else guess.branch
    # Arrays are no part of a program, which then serves any number of steps.
    first, *finer = (np.asarray(count) for count in (STEPS if steps is None else (steps,)))
    chosen = ROUGH if traced else BALANCED
    tolerance = np.asarray(chosen if steps is None else np.inf)
    task = robot.unnamed, imposed, target
    if traced:
        reached = _reached(*task, guess, first, True, turned)
        return polish(*task, reached.y, reached.status, tolerance, branch, first)
    ending = compile_polish(*task, branch, first)
    try:
        if _is_far(*task):
            y, outcome = np.full(robot.n_y, np.nan), int(Status.OUT_OF_REACH)
        else:
            reached = _reached(*task, guess, first, False, turned)
            y, outcome = np.asarray(reached.y), int(reached.status)
    finally:
        if ending is not None:
            ending.join()
    for count in (first, *finer):
        # From numpy, as ahead: a weak type would make another program.
        equilibrium = polish(*task, y, np.asarray(outcome), tolerance, branch, count)
        status = Status(int(equilibrium.status))
        if status == Status.LOST and count is not first:
            # So far from what fewer steps have found that it takes a way of its own.
            reached = _reached(*task, guess, count, False, turned)
            end = np.asarray(reached.y), np.asarray(int(reached.status))
            equilibrium = polish(*task, *end, tolerance, branch, count)
            status = Status(int(equilibrium.status))
        if status != Status.INACCURATE:
            break
    if throw and status != Status.SOLVED:
        reason = f"No equilibrium of {robot.name}: {status.message}."
        raise SolveError(status, reason, _hint(*task, guess, status), equilibrium)
    return equilibrium


def _is_far(robot, imposed, target) -> bool:
    """Whether no branch needs to be followed to know that a leg is too short for the target."""
    places = np.flatnonzero(np.any(np.asarray(imposed) != 0.0, axis=0))
    return bool(out_of_reach(robot, np.asarray(target)[None], places.tolist())[0])


def _hint(robot, imposed, target, guess, status) -> str:
    """What may be wrong with the numbers of a solve that has failed, a sentence or nothing."""
    if guess is not None and int(guess.status) != Status.SOLVED:
        return f"Its `guess` is not solved itself: {Status(int(guess.status)).name}."
    given = np.abs(np.where(np.any(np.asarray(imposed) != 0.0, axis=0), np.asarray(target), 0.0))
    angles, positions = np.split(given, [robot.n_a])
    if np.any(angles[~slides(robot)] > _MANY_TURNS):
        return "Angles of motors are in radians, which these hardly are."
    if status == Status.OUT_OF_REACH:
        return hardly_metres(robot, positions[: robot.geometry.d])
    return ""


def _reached(robot, imposed, target, guess, steps, traced, turned) -> Track:
    """The way to a target: from a neighbour, from home, or found by a search.

    **Arguments:**

    - `turned`: whether it is a whole orientation in space that is imposed.
    """
    robot = jax.lax.stop_gradient(robot)
    goal = jax.lax.stop_gradient(target)
    begin = robot.home if guess is None else jax.lax.stop_gradient(guess)
    if not turned or begin is None:
        return _followed(robot, imposed, goal, guess, steps, traced)
    near = nearest_turn(robot, goal, begin.q_p)
    reached = _followed(robot, imposed, floats(near), guess, steps, traced)
    # The same orientation by the rotation vector that was asked for.
    xp = namespace(reached.y, near, goal)
    ahead = xp.pad(xp.asarray(near) - xp.asarray(goal), (0, robot.n_y - goal.size))
    return reached._replace(y=xp.asarray(reached.y) - ahead)


def _followed(robot, imposed, goal, guess, steps, traced) -> Track:
    """As `_reached`, to a target as it is written."""
    if guess is not None:
        y = jax.lax.stop_gradient(guess.y)
        start, reached = from_neighbour(robot, imposed, y, goal, steps)
    elif robot.home is not None:
        home, reached = from_home(robot, imposed, at_rest(robot), goal, steps)
        if not traced and int(home.status) != Status.SOLVED:
            # By numpy: an operation alone would wait for what is being compiled.
            rough = floats(np.concatenate([robot.home.q_a, robot.home.q_p]))
            bent = reaching(robot, rough, steps)
            home, reached = from_home(robot, imposed, bent, goal, steps)
            if int(home.status) != Status.SOLVED and int(reached.status) != Status.NOT_FINITE:
                return from_home_at_random(robot, imposed, goal, steps)
        start = home.y
    elif traced:
        raise InputError(
            "Argument `robot` must have a home configuration to be solved without a `guess` "
            "inside a JAX transformation, but its `home` is None."
        )
    else:
        return search(robot, imposed, goal, steps)
    if not traced and int(reached.status) == Status.LOST:
        reached = detours(robot, imposed, start, goal, reached, steps)
    return reached


def _check_call(robot: Any, guess: Any, steps: Any) -> None:
    if not isinstance(robot, Robot):
        raise InputError(f"Argument `robot` must be a Robot, but it is a {type(robot).__name__}.")
    check_turns(robot)
    if steps is not None:
        check_integer("steps", steps)
    if guess is not None:
        check_fits("guess", guess, robot)


def _checked(name: str, value: Any, size: int, robot: Robot) -> Array | np.ndarray:
    if not jax.config.read("jax_enable_x64"):
        raise InputError(
            "Argument `robot` must hold float64 numbers, but JAX runs in float32: add "
            '`jax.config.update("jax_enable_x64", True)` before building the robot.'
        )
    for leaf in jax.tree.leaves(robot):
        if jnp.result_type(leaf) == jnp.float32:
            raise InputError(
                "Argument `robot` must hold float64 numbers, but some are float32: enable "
                '`jax.config.update("jax_enable_x64", True)` before building the robot.'
            )
    try:
        array = namespace(value).asarray(value)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"Argument `{name}` must be {size} numbers, but it is {value!r}."
        ) from error
    if array.dtype == jnp.float32:
        raise InputError(f"Argument `{name}` must be float64, but it is float32.")
    if array.shape != (size,) or not (
        jnp.issubdtype(array.dtype, jnp.floating) or jnp.issubdtype(array.dtype, jnp.integer)
    ):
        raise InputError(
            f"Argument `{name}` must be {size} numbers, but it has shape {array.shape} and type "
            f"{array.dtype}."
        )
    if not isinstance(array, jax.core.Tracer) and not np.all(np.isfinite(array)):
        raise InputError(f"Argument `{name}` must be finite, but it is {np.asarray(array)}.")
    return array.astype(float)
