"""More motors than coordinates to impose: a criterion chooses among the solutions."""

import enum
from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float

from ..errors import InputError, shown
from ..geometry import Numbers
from ..outline import are_traced
from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from .equilibrium import Equilibrium, check_fits, check_solved
from .linear import inverse
from .measures import motor_torques
from .problem import coordinate_places
from .reach import out_of_reach
from .residual import residual
from .solve import solve_forward
from .status import SolveError, Status
from .unknowns import scales, unknown_labels, unknown_scales, unravel

_ROUNDS = 100
_CLOSE = 1e-9
_LONGEST = 0.1
"""Longest step of the motors, in rad or rod lengths."""


class Criterion(enum.Enum):
    """What is least among all ways to reach a target."""

    TORQUE = "torque"
    """The sum of the squared motor torques, in units of `scales(robot)`."""
    MOTION = "motion"
    """The squared distance of the motors from where they start, rad and rod lengths."""


class _Linear(NamedTuple):
    """`∂(q_p, τ)/∂q_a` in scaled units, and the scaled torques."""

    platform: Float[Array, "n_p n_a"]
    torques_by_motors: Float[Array, "n_a n_a"]
    torques: Float[Array, " n_a"]


def resolve_redundancy(
    robot: Robot,
    point: Numbers,
    *,
    imposed: Sequence[str] | None = None,
    criterion: Criterion | str = Criterion.TORQUE,
    guess: Equilibrium | None = None,
    steps: int = DEFAULT_STEPS,
) -> Equilibrium:
    """The motor positions that impose some coordinates, where there are more motors than those.

    From a known equilibrium the motors move in short steps along the branch: each closes what is
    left to the target and lowers the criterion among the motions that do (Gauss and Newton).

    **Arguments:**

    - `point`: values of the imposed coordinates, m and rad.
    - `imposed`: their names, such as `("x", "y", "z")`, fewer than motors; by default all of
        the platform's.
    - `criterion`: `"torque"` or `"motion"`, see `Criterion`.
    - `guess`: where to start; by default the equilibrium at the robot's home.

    **Returns:** an `Equilibrium` with the motors held; a robot's derivatives do not pass through
    the choice.

    **Raises:** `ValueError` for a bad argument; `SolveError` where the steps do not end.
    """
    try:
        criterion = Criterion(criterion)
    except ValueError:
        raise InputError(
            f"Argument `criterion` must be 'torque' or 'motion', but it is {shown(criterion)}."
        ) from None
    n_a, n_p = robot.n_a, robot.n_p
    every = unknown_labels(robot)[n_a : n_a + n_p]
    if isinstance(imposed, str):
        raise InputError(
            f"Argument `imposed` must be a sequence of names, but it is {shown(imposed)}."
        )
    places = coordinate_places(robot, every if imposed is None else imposed)
    if not 0 < len(set(places)) == len(places) < n_a or min(places) < n_a:
        raise InputError(
            f"Argument `imposed` must name different platform coordinates, fewer than the {n_a} "
            f"motors of {robot.name}; `solve_inverse` is for as many."
        )
    if are_traced(jax.tree.leaves((robot, point, guess))):
        raise InputError(
            "Argument `point` must be numbers: the choice is made in Python, and cannot be part of "
            "a JAX transformation. Give `solve_forward` the motors that it has chosen."
        )
    target = np.asarray(point, float)
    if target.shape != (len(places),) or not np.all(np.isfinite(target)):
        raise InputError(
            f"Argument `point` must be {len(places)} finite numbers, but it is {shown(point)}."
        )
    if guess is None:
        if robot.home is None:
            raise InputError(
                f"Argument `guess` must be given, since {robot.name} has no home configuration."
            )
        guess = solve_forward(robot, robot.home.q_a, steps=steps)

    check_fits("guess", guess, robot)
    check_solved("guess", guess)
    whole = np.append(np.asarray(guess.q_a), np.asarray(guess.q_p))
    whole[list(places)] = target
    if out_of_reach(robot, whole[None], places)[0]:
        status = Status.OUT_OF_REACH
        raise SolveError(status, f"No equilibrium of {robot.name}: {status.message}.")

    rows = [place - n_a for place in places]
    units = np.asarray(unknown_scales(robot))
    motors, begin, now = units[:n_a], np.asarray(guess.q_a), guess
    for _ in range(_ROUNDS):
        linear = jax.tree.map(np.asarray, _linearise(robot, now.y, steps))
        J = linear.platform[rows]
        left = (target - np.asarray(now.q_p)[rows]) / units[list(places)]
        if criterion is Criterion.TORQUE:
            slope, value = linear.torques_by_motors, linear.torques
        else:
            slope, value = np.eye(n_a), (np.asarray(now.q_a) - begin) / motors
        step = _constrained(slope, value, J, left)
        if np.max(np.abs(step)) < _CLOSE and np.max(np.abs(left)) < _CLOSE:
            return now
        step *= min(1.0, _LONGEST / np.max(np.abs(step)))
        now = solve_forward(robot, np.asarray(now.q_a) + step * motors, guess=now, steps=steps)
    raise SolveError(
        Status.NOT_CONVERGED,
        f"No equilibrium of {robot.name}: its motors do not settle at the least {criterion.value}, "
        "which may lie at the edge of what the branch reaches.",
    )


def _constrained(slope, value, J, left) -> np.ndarray:
    """The step with the least `|value + slope · step|²` among those with `J · step = left`."""
    k = len(J)
    # Motions that the criterion does not feel stay small.
    hessian = slope.T @ slope + 1e-12 * np.trace(slope.T @ slope) * np.eye(slope.shape[1])
    system = np.block([[hessian, J.T], [J, np.zeros((k, k))]])
    return np.linalg.lstsq(system, np.append(-slope.T @ value, left), rcond=None)[0][: J.shape[1]]


@program
def _linearise(robot: Robot, y: Float[Array, " n_y"], steps: int) -> _Linear:
    units = unknown_scales(robot)
    n_a, n_p = robot.n_a, robot.n_p
    force = scales(robot).force * scales(robot).length / units[:n_a]

    def rows(scaled):
        return residual(robot, unravel(robot, scaled * units), steps)

    def torques(scaled):
        return motor_torques(robot, scaled * units) / force

    matrix = jax.jacfwd(rows)(y / units)
    follows = -inverse(matrix[:, n_a:]) @ matrix[:, :n_a]
    slopes = jax.jacfwd(torques)(y / units)
    return _Linear(
        platform=follows[:n_p],
        torques_by_motors=slopes[:, :n_a] + slopes[:, n_a:] @ follows,
        torques=torques(y / units),
    )
