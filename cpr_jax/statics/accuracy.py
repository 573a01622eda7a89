"""How many integration steps an accuracy takes."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..geometry import namespace
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS, rod_tip
from ..rods.solver import Scheme, Steps, as_scheme
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

MENU = (
    Scheme(2, 8, 4),
    Scheme(2, 8, 6),
    Scheme(2, 8, 8),
    Scheme(2, 10, 8),
    Scheme(2, 10, 10),
    Scheme(3, 8, 10),
    Scheme(3, 10, 8),
    Scheme(3, 10, 10),
    Scheme(3, 12, 8),
    Scheme(3, 12, 10),
    Scheme(5, 12, 8),
    Scheme(10, 12, 8),
    Scheme(20, 12, 8),
)
"""Schemes to choose from, the least work first: few large steps take less of it than many small
ones, and the order that takes least depends on the accuracy."""

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


def tip_errors(
    robot: Robot, y: Float[Array, " n_y"], further: Steps = DEFAULT_STEPS
) -> Float[Array, " schemes"]:
    """`Errors.tip` of the unknowns `y` with each scheme of `MENU` and a further one.

    What the last of the menu leaves is extrapolated from the one before it, which has half its
    steps; the others are compared with it.
    """
    legs, q, mu = by_leg(robot, unravel(robot, y))
    base = leg_base(robot.geometry, legs, q, mu)

    def tips(scheme):
        return rod_tip(robot.geometry, base.rod, base.force, base.moment, scheme).position

    # A loop keeps one copy of the integration in the compiled program.
    schemes = jnp.concatenate([jnp.array(MENU), as_scheme(further)[None]])
    found = jax.lax.map(tips, schemes)
    last = len(MENU) - 1
    apart = jnp.abs(found - found[last]) / base.rod.length
    errors = jnp.max(apart, axis=tuple(range(1, apart.ndim)))
    errors = errors.at[last].set(errors[last - 1] / 2.0 ** MENU[last].order)
    return jnp.maximum(errors, _ROUNDOFF)


def least_scheme(
    errors: Float[Array | np.ndarray, " schemes"], tolerance: float = TOLERANCE
) -> Int[Array | np.ndarray, ""]:
    """Number of the first scheme of `MENU` that is accurate enough; of the last one if none is.

    **Arguments:**

    - `errors`: see `tip_errors`.
    - `tolerance`: in lengths of the rods.
    """
    xp = namespace(errors)
    enough = xp.asarray(errors)[: len(MENU)] <= tolerance
    return xp.where(xp.any(enough), xp.argmax(enough), len(MENU) - 1)
