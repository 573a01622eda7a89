"""How many integration steps an accuracy takes."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS, tip_error
from .residual import leg_base
from .unknowns import unravel

TOLERANCE = 1e-8
"""Error of a rod's tip, in lengths of the rod, that is asked for where nothing else is said."""

STEPS = (DEFAULT_STEPS, 20, 40)
"""Numbers of steps that a single solve tries in turn."""

MENU = (4, 5, 6, 7, 8, 10, 14, 20, 40)
"""Numbers of steps to choose from: each is compiled by itself."""

_PROBE = 5
_ORDER = 10
_ROUNDOFF = 1e-13


def relative_tip_error(
    robot: Robot, y: Float[Array, " n_y"], steps: int = _PROBE
) -> Float[Array, ""]:
    """Estimated error of the tips by step doubling, in lengths of the rods; the largest.

    **Arguments:**

    - `y`: unknowns in SI units.
    """
    geometry = robot.geometry
    state = unravel(robot, y)

    def one(leg, q, mu):
        base = leg_base(geometry, leg, q, mu)
        error = tip_error(geometry, base.rod, base.force, base.moment, steps)
        return error / base.rod.length

    return jnp.max(jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu))


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
