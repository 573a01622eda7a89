"""Whether an equilibrium is one of a robot as it is now."""

import jax
from jaxtyping import Array, Float

from ..errors import InputError
from ..outline import are_traced
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium

_STRANGE = 1e-3
"""Residual from which an equilibrium is not one of the robot, unless its own steps left more."""


def check_belongs(robot: Robot, equilibrium: Equilibrium, residual: Float[Array, ""]) -> None:
    """Refuses an equilibrium of a robot with other numbers, as far as its residual is known.

    **Arguments:**

    - `residual`: largest entry of the dimensionless `R₀` of the robot at the equilibrium.
    """
    if are_traced(jax.tree.leaves((equilibrium, residual))):
        return
    left = float(residual)
    if left > max(_STRANGE, 10.0 * float(equilibrium.measures.unbalanced)):
        raise InputError(
            f"Argument `equilibrium` must be one of {robot.name} as it is now, but leaves a "
            f"residual of {left:.1g}: solve for this robot, with it as `guess`, or give as many "
            "`steps` as it took."
        )
