"""From equilibria to ones nearby, many at once: the step of a map."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from .linear import solve_many_with_sign
from .problem import Problem, full_residual
from .status import Status
from .unknowns import unknown_scales

_CLOSE = 1e-9
_ITERATIONS = 5

DEVIATION = 0.03
"""Largest distance of a solution from its prediction, in dimensionless unknowns."""


class Nearby(NamedTuple):
    """Equilibria at new imposed coordinates, in the dimensionless unknowns `y / unknown_scales`.

    **Attributes:**

    - `y`: the unknowns.
    - `slope`: `∂y/∂q` along the axes that vary, per metre or radian.
    - `sign`: of `det ∂R/∂y`.
    - `deviation`: largest distance of an unknown from its prediction.
    - `status`: a `Status` code; where it is solved, the branch is for the caller to judge.
    """

    y: Float[Array | np.ndarray, "*lanes n_y"]
    slope: Float[Array | np.ndarray, "*lanes n_y axes"]
    sign: Float[Array | np.ndarray, "*lanes"]
    deviation: Float[Array | np.ndarray, "*lanes"]
    status: Int[Array | np.ndarray, "*lanes"]


@program
def advance(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    axes: tuple[int, ...],
    guess: Float[Array | np.ndarray, "lanes n_y"],
    goal: Float[Array | np.ndarray, "lanes n_q"],
    steps: int = DEFAULT_STEPS,
) -> Nearby:
    """Newton's method from predictions, undamped: it converges at once or the caller goes slower.

    A lane that leaves its prediction by more than `DEVIATION` is given up.

    **Arguments:**

    - `axes`: the entries of `(q_a, q_p)` that vary.
    - `guess`: dimensionless unknowns predicted at `goal`.
    """
    rows = _rows(robot, imposed, axes)

    def one(guess, goal):
        def unfinished(state):
            y, norm, _, _, count = state
            near = jnp.max(jnp.abs(y - guess)) < DEVIATION
            return (count < _ITERATIONS) & (norm > _CLOSE) & near

        def newton(state):
            y, *_, count = state
            jacobian, f = _expand(robot, imposed, goal, y, steps)
            solved, sign = solve_many_with_sign(jacobian, jnp.column_stack([-f, rows]))
            # Below the tolerance the step at hand squares the error once more.
            return y + solved[:, 0], jnp.max(jnp.abs(f)), sign, solved[:, 1:], count + 1

        one = jnp.ones((), guess.dtype)
        first = (guess, jnp.inf * one, one, jnp.zeros((guess.size, len(axes))), jnp.array(0))
        y, norm, sign, slope, _ = jax.lax.while_loop(unfinished, newton, first)
        converged = (norm <= _CLOSE) & jnp.all(jnp.isfinite(y))
        status = jnp.where(converged, Status.SOLVED, Status.NOT_CONVERGED)
        return Nearby(y, slope, sign, jnp.max(jnp.abs(y - guess)), status)

    return jax.vmap(one)(guess, goal)


def _rows(robot: Robot, imposed, axes):
    """Minus the derivative of the dimensionless residual in the imposed axes."""
    units = unknown_scales(robot)
    chosen = jnp.array(axes)
    free = jnp.zeros((units.size - imposed.shape[0], len(axes)))
    return jnp.concatenate([free, imposed[:, chosen] / units[chosen]])


def _expand(robot, imposed, goal, y, steps):
    def evaluate(y):
        f = full_residual(y, Problem(robot, imposed, goal), steps)
        return f, f

    return jax.jacfwd(evaluate, has_aux=True)(y)
