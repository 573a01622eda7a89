"""An equilibrium and the inverse of its Jacobian, expanded in the robot's parameters."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import Steps
from ..statics.accuracy import relative_tip_error
from ..statics.correction import values
from ..statics.linear import inverse
from ..statics.problem import Problem, forward_rows
from ..statics.unknowns import unknown_scales
from .parameters import Selection

_REACH = 0.01
"""Share of the parameters' half ranges over which the expansion's differences are taken."""


class Expansion(eqx.Module):
    """Predictions around an equilibrium whose motors are held, in `y / unknown_scales`.

    Only a root find starts from it, so that its small errors cost time and no accuracy.

    **Attributes:**

    - `y`, `rho`: where it is expanded.
    - `first`: `∂y/∂ρ`, shape `(n_y, n_ρ)`; `second`: `∂²y/∂ρ²`, shape `(n_y, n_ρ, n_ρ)`.
    - `inverse`: `M = (∂R/∂y)⁻¹`; `turn`: `(∂M/∂ρ_k) M⁻¹`, shape `(n_ρ, n_y, n_y)`.
    - `error`: `relative_tip_error`, the largest over the ranges of the parameters.
    - `weights`: positive `w` that make `max_i Σ_j |T_ij| w_j / w_i` small for what `turn` makes
        of the parameters' ranges. Below 1 it proves that `1 + T` is regular (Gershgorin).
    """

    y: Float[Array, " n_y"]
    rho: Float[Array, " n_rho"]
    first: Float[Array, "n_y n_rho"]
    second: Float[Array, "n_y n_rho n_rho"]
    inverse: Float[Array, "n_y n_y"]
    turn: Float[Array, "n_rho n_y n_y"]
    weights: Float[Array, " n_y"]
    error: Float[Array, ""]


def held_equations(robot: Robot, selection: Selection, y: Float[Array, " n_y"], steps: Steps):
    """`R(y, ρ)` with the motors held where `y` (SI units) has them.

    **Returns:** a function of the unknowns and of the parameters; unknowns and rows are in units
    of the nominal robot's.
    """
    rows, target = forward_rows(robot), y[: robot.n_a + robot.n_p]

    def equations(scaled, rho):
        varied = selection.set(robot, rho)
        return values(Problem(varied, rows, target), scaled, steps, robot)

    return equations


@program
def expand(
    robot: Robot,
    selection: Selection,
    y: Float[Array, " n_y"],
    Pi_y: Float[Array, "n_y n_rho"],
    delta: Float[Array, " n_rho"],
    steps: int,
) -> Expansion:
    """Expands the equilibrium at the unknowns `y` (SI units), its motors held.

    The second order comes from differences of exact first derivatives on the tangent space:
    at `y + Π Δρ, ρ + Δρ` the Jacobian differs by its total derivative along the branch.

    **Arguments:**

    - `Pi_y`: the sensitivity with the motors held, SI units.
    - `delta`: half ranges; the differences are taken over a hundredth of them.
    """
    units = unknown_scales(robot)
    equations = held_equations(robot, selection, y, steps)
    scaled, rho, first = y / units, selection.get(robot), Pi_y / units[:, None]

    # A parameter that does not vary still has a derivative.
    reach = _REACH * jnp.where(delta > 0.0, delta, 1e-3 * jnp.maximum(jnp.abs(rho), 1e-3))
    ways = jnp.diag(reach)
    ways = jnp.concatenate([jnp.zeros((1, rho.size)), ways, -ways])
    by_y, by_rho = jax.vmap(
        lambda way: jax.jacfwd(equations, argnums=(0, 1))(scaled + first @ way, rho + way)
    )(ways)

    def rate(values):
        ahead, behind = jnp.split(values[1:], 2)
        return (ahead - behind) / (2.0 * reach[:, None, None])

    def tips(way):
        varied = selection.set(robot, rho + way)
        return relative_tip_error(varied, (scaled + first @ way) * units)

    inverted = inverse(by_y[0])
    turn = -jnp.einsum("ij,kjl->kil", inverted, rate(by_y))
    bent = jnp.einsum("kij,jl->ilk", turn, first)
    second = bent - jnp.einsum("ij,kjl->ilk", inverted, rate(by_rho))
    return Expansion(
        y=scaled,
        rho=rho,
        first=first,
        second=0.5 * (second + second.swapaxes(1, 2)),
        inverse=inverted,
        turn=turn,
        weights=_weights(jnp.tensordot(delta, jnp.abs(turn), axes=1)),
        error=jnp.max(jax.vmap(tips)(ways / _REACH)),
    )


def _weights(matrix: Float[Array, "n n"]) -> Float[Array, " n"]:
    """The Perron vector of a nonnegative matrix, by power iteration, kept away from zero."""

    def turn(_, vector):
        vector = matrix @ vector
        return jnp.maximum(vector / jnp.max(vector), 1e-6)

    return jax.lax.fori_loop(0, 50, turn, jnp.ones(matrix.shape[0]))
