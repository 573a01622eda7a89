"""From equilibria to ones nearby, many at once: the step of a map."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..programs import hot_program, program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Steps
from .correction import settle
from .problem import Problem
from .status import Status
from .unknowns import unknown_scales

_CHORDS = 2

_SLOTS = 16
"""Lanes worked on at a time: many calls have no more to do."""


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


def _advance(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    axes: tuple[int, ...],
    guess: Float[Array | np.ndarray, "lanes n_y"],
    goal: Float[Array | np.ndarray, "lanes n_q"],
    steps: Steps = DEFAULT_STEPS,
) -> Nearby:
    """Newton's method from predictions, undamped: it converges at once or the caller goes slower.

    A lane that leaves its prediction by more than `DEVIATION` is given up.

    **Arguments:**

    - `axes`: the entries of `(q_a, q_p)` that vary.
    - `guess`: dimensionless unknowns predicted at `goal`.
    """
    # Minus the derivative of the dimensionless residual in the imposed axes.
    chosen = jnp.array(axes, int)
    units = unknown_scales(robot)
    free = jnp.zeros((units.size - imposed.shape[0], len(axes)))
    rows = jnp.concatenate([free, imposed[:, chosen] / units[chosen]])

    def one(guess, goal):
        found = settle(Problem(robot, imposed, goal), guess, rows, steps, _CHORDS, _SLOTS)
        status = jnp.where(found.converged, Status.SOLVED, Status.NOT_CONVERGED)
        return Nearby(found.y, found.slope, found.sign, found.deviation, status)

    return jax.vmap(one)(guess, goal)


advance = program(_advance)

advance_many = hot_program(_advance)
"""The same, compiled for longer: worth it for millions of lanes."""
