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

_DOUBTFUL = 1e-10
"""Error of a scheme, in lengths of the rod, that the one with twice its steps may not tell."""


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
    robots: Robot, y: Float[Array, "cases n_y"], further: Steps = DEFAULT_STEPS
) -> Float[Array, " schemes"]:
    """The largest `Errors.tip` of several cases with each scheme of `MENU` and a further one.

    All are compared with the last of the menu; what that leaves is extrapolated from the one before
    it, which has half its steps. Where the one before is accurate without doubt, it takes the place
    of the last, which is spared.

    **Arguments:**

    - `robots`: one whose numbers have the cases as their first axis.
    - `y`: their unknowns.
    """

    def tips(scheme):
        def one(robot, y):
            legs, q, mu = by_leg(robot, unravel(robot, y))
            base = leg_base(robot.geometry, legs, q, mu)
            tip = rod_tip(robot.geometry, base.rod, base.force, base.moment, scheme)
            return tip.position / base.rod.length

        return jax.vmap(one)(robots, y)

    # A loop keeps one copy of the integration in the compiled program.
    schemes = jnp.concatenate([as_scheme(further)[None], jnp.array(MENU)])
    last = len(MENU)
    gain = 2.0 ** MENU[-1].order

    def compared(found, reference):
        apart = jnp.abs(found - found[reference])
        # What no scheme integrates, such as a rod without stiffness, tells nothing of any.
        told = jnp.isfinite(found[reference])
        apart = jnp.where(told, apart, jnp.where(jnp.any(told), 0.0, jnp.inf))
        apart = jnp.where(jnp.isnan(apart), jnp.inf, apart)
        return jnp.max(apart, axis=tuple(range(1, found.ndim)))

    def unfinished(state):
        count, found = state
        doubtful = compared(found, last - 1)[last - 2] > _DOUBTFUL
        return (count < last) | ((count == last) & doubtful)

    def attempt(state):
        count, found = state
        return count + 1, found.at[count].set(tips(schemes[count]))

    tip = jax.eval_shape(tips, schemes[0])
    count, found = jax.lax.while_loop(
        unfinished, attempt, (0, jnp.zeros((len(schemes), *tip.shape), tip.dtype))
    )
    errors = compared(found, count - 1)
    for k in (last - 1, last):
        errors = jnp.where(k >= count - 1, errors.at[k].set(errors[k - 1] / gain), errors)
    return jnp.roll(jnp.maximum(errors, _ROUNDOFF), -1)


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
