"""How many integration steps an accuracy takes."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS, Steps, rod_tip
from .energy import Rods
from .residual import by_leg, leg_base, residual_at
from .unknowns import unravel

TOLERANCE = 1e-8
"""Error of a rod's tip, in lengths of the rod, that is asked for where nothing else is said."""

BALANCED = 5e-9
"""`Measures.unbalanced` from which a single solve takes more steps."""

ROUGH = 1e-6
"""`Measures.unbalanced` from which a solve that cannot take more steps is `INACCURATE`."""

STEPS = (DEFAULT_STEPS, 20, 40)
"""Numbers of steps that a single solve tries in turn."""

MENU = (4, 5, 6, 7, 8, 10, 14, 20, 40)
"""Numbers of steps to choose from: each is compiled by itself."""

_PROBE = 5
_ORDER = 10
_ROUNDOFF = 1e-13


class Errors(NamedTuple):
    """What an integration leaves, by step doubling.

    **Attributes:**

    - `tip`: largest error of a rod's tip, in lengths of the rod.
    - `unbalanced`: largest entry of `R₀` with twice the steps, in units of `scales(robot)`.
    """

    tip: Float[Array, ""]
    unbalanced: Float[Array, ""]


def errors_between(robot: Robot, y: Float[Array, " n_y"], coarse: Rods, fine: Rods) -> Errors:
    """Estimated errors of an equilibrium with unknowns `y` in SI units.

    **Arguments:**

    - `coarse`, `fine`: the rods with some steps, and with twice as many.
    """
    apart = jnp.max(jnp.abs(coarse.tips.position - fine.tips.position).T / fine.lengths)
    left = residual_at(robot, unravel(robot, y), fine.tips)
    return Errors(apart, jnp.max(jnp.abs(left)))


def relative_tip_error(
    robot: Robot, y: Float[Array, " n_y"], steps: Steps = _PROBE
) -> Float[Array, ""]:
    """`Errors.tip` of unknowns `y`, by default of as few steps as tell what others leave."""
    legs, q, mu = by_leg(robot, unravel(robot, y))
    base = leg_base(robot.geometry, legs, q, mu)

    def tips(count):
        return rod_tip(robot.geometry, base.rod, base.force, base.moment, count).position

    # A loop keeps one copy of the integration in the compiled program.
    coarse, fine = jax.lax.map(tips, jnp.array([1, 2]) * steps)
    return jnp.max(jnp.abs(coarse - fine) / base.rod.length)


def error_with(error: float, steps: int) -> float:
    """`relative_tip_error` with other steps, extrapolated from that with the default number."""
    return max(error * (_PROBE / steps) ** _ORDER, _ROUNDOFF)


def steps_for(error: float, tolerance: float = TOLERANCE) -> int:
    """Least number of steps of `MENU` that is accurate enough; the largest if none is.

    **Arguments:**

    - `error`: `relative_tip_error` with the default number of steps.
    - `tolerance`: in lengths of the rods.
    """
    return next((n for n in MENU if error_with(error, n) <= tolerance), MENU[-1])
