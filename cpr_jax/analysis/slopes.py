"""Π_y (9)–(10) of an equilibrium, and what hangs on it: numbers without their labels."""

import enum
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..programs import program
from ..robots.robot import Robot
from ..statics.linear import inverse, regular_inverse
from ..statics.measures import motor_torques
from ..statics.residual import residual
from ..statics.turns import coordinate_jacobian, motion_jacobian
from ..statics.unknowns import scales, unknown_scales, unravel
from .parameters import Selection


class Hold(enum.Enum):
    """What stays where it is while the parameters vary."""

    MOTORS = "motors"
    PLATFORM = "platform"


class Answer(NamedTuple):
    """What `Sensitivity` has of these names."""

    Pi_y: Float[Array, "n_y n_rho"]
    Pi_tau: Float[Array, "n_a n_rho"]
    Pi_turn: Float[Array, "turns n_rho"]


class Slopes(NamedTuple):
    """All numbers of a `Sensitivity`, for whatever is held.

    **Attributes:**

    - `answers`: by the values of `Hold`.
    - `platform_stiffness`, `rho`: see `Sensitivity`.
    - `residual`: largest entry of `R₀` where they were taken.
    """

    answers: dict[str, Answer]
    platform_stiffness: Float[Array, "n_p n_p"]
    rho: Float[Array, " n_rho"]
    residual: Float[Array, ""]


@program
def slopes_at(robot: Robot, y: Float[Array, " n_y"], selection: Selection, steps: int) -> Slopes:
    """Π_y by (10) in its conforming order, `-(∂R/∂y)⁻¹ ∂R/∂ρ`, and what hangs on it."""
    units = unknown_scales(robot)
    rho = selection.get(robot)
    n_a, n_p, d = robot.n_a, robot.n_p, robot.geometry.d
    q_p = y[n_a : n_a + n_p]
    motion = motion_jacobian(robot, q_p)

    def equations(scaled, rho):
        varied = selection.set(robot, rho)
        R_0 = residual(varied, unravel(varied, scaled * units), steps)
        return R_0, R_0

    def torques(y, rho):
        return motor_torques(selection.set(robot, rho), y)

    slopes = jax.jacfwd(equations, argnums=(0, 1), has_aux=True)
    (by_y, by_rho), R_0 = slopes(y / units, rho)
    tau_y, tau_rho = jax.jacfwd(torques, argnums=(0, 1))(y, rho)

    # Equally many unknowns from here on are held: the motors, or the platform.
    starts = {Hold.MOTORS.value: 0}
    if n_a == n_p:
        starts[Hold.PLATFORM.value] = n_a
    free = [
        jnp.concatenate([by_y[:, :start], by_y[:, start + n_a :]], axis=1)
        for start in starts.values()
    ]
    moving = -jax.vmap(inverse)(jnp.stack(free)) @ by_rho

    def sensitivities(moving, start: int):
        held = jnp.zeros((n_a, rho.size))
        Pi_y = jnp.concatenate([moving[:start], held, moving[start:]]) * units[:, None]
        return Answer(Pi_y, tau_y @ Pi_y + tau_rho, motion[d:, d:] @ Pi_y[n_a + d : n_a + n_p])

    answers = {
        name: sensitivities(part, start)
        for part, (name, start) in zip(moving, starts.items(), strict=True)
    }

    # Motors held and joints closed, the legs' wrenches follow the platform.
    by_p, by_mu = by_y[:, n_a : n_a + n_p], by_y[:, n_a + n_p :]
    wrench_by_p = -regular_inverse(by_mu[n_p:]) @ by_p[n_p:]
    stiffness = -(by_p[:n_p] + by_mu[:n_p] @ wrench_by_p)
    wrench_units = scales(robot).wrench(robot)[:n_p]
    stiffness = stiffness * wrench_units[:, None] / units[n_a : n_a + n_p]
    return Slopes(answers, stiffness @ coordinate_jacobian(robot, q_p), rho, jnp.max(jnp.abs(R_0)))
