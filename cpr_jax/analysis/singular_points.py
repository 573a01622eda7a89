"""Points of singular curves, corrected by Newton's method on a bordered system."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..programs import program
from ..statics.correction import linearised
from ..statics.linear import inverse_with_sign, solve_many_with_sign
from ..statics.problem import Problem, forward_rows

_CLOSE = 1e-9
_ITERATIONS = 8
_ITERATIONS_OF_STARTS = 25

_ASIDE = 1e-4
"""Length of the differences of Jacobians, in dimensionless unknowns."""


class Lane(NamedTuple):
    """A point of a curve: dimensionless y, unit tangent, borders of the singular matrix."""

    z: Float[Array | np.ndarray, "*lanes n_y"]
    tangent: Float[Array | np.ndarray, "*lanes n_y"]
    left: Float[Array | np.ndarray, "*lanes n_r"]
    right: Float[Array | np.ndarray, "*lanes n_r"]
    converged: Bool[Array | np.ndarray, "*lanes"]


@program
def correct_points(robot, columns, held, lanes: Lane, predicted, steps: int) -> Lane:
    """Newton's method on `R₀ = 0`, the held coordinates, `g = 0` and `t·(z - z_predicted) = 0`.

    `g` is the last unknown of the bordered system `[A b; cᵀ 0] (v, g) = (0, 1)`, which vanishes
    where A is singular and has the sign of `det A`; b and c follow the null vectors.
    """
    n_r = robot.n_y - robot.n_a
    problem = Problem(robot, forward_rows(robot), jnp.zeros(robot.n_a + robot.n_p))

    def linearise(z):
        R, by_z = linearised(problem, z, steps)
        return by_z[:n_r], R[:n_r]

    def one(lane: Lane, predicted):
        def newton(state):
            z, left, right, _, count, _ = state
            # What det A does along z needs second derivatives in one direction: differences of
            # Jacobians along the null vector known so far cost no second tangents of the rods.
            aside = _ASIDE * (columns @ right)
            around = jnp.stack([z, z + aside, z - aside])
            (J, ahead, behind), (R_0, *_) = jax.vmap(linearise)(around)
            A = J @ columns
            blank = jnp.sum(jnp.abs(left)) == 0.0
            inverted, _ = inverse_with_sign(A)
            # Inverse iteration finds the null vectors where none are known yet.
            guess = jnp.ones(A.shape[0])
            v = _unit(inverted @ _unit(inverted.T @ _unit(inverted @ guess)))
            u = _unit(inverted.T @ _unit(inverted @ _unit(inverted.T @ guess)))
            left, right = jnp.where(blank, u, left), jnp.where(blank, v, right)
            bordered = jnp.block([[A, left[:, None]], [right[None], jnp.zeros((1, 1))]])
            last = jnp.zeros(A.shape[0] + 1).at[-1].set(1.0)
            solved, sign = inverse_with_sign(bordered)
            v, g = (solved @ last)[:-1], solved[-1, -1]
            w = solved[-1, :-1]
            # With this orientation g has the sign of det A, and tangents one along a curve.
            flip = jnp.where(sign < 0.0, -1.0, 1.0)
            slope = -flip * (w @ (ahead - behind)) / (2.0 * _ASIDE)
            system = jnp.concatenate([J, held, slope[None], lane.tangent[None]])
            gap = jnp.concatenate(
                [
                    R_0,
                    held @ (z - predicted),
                    flip * g[None],
                    (lane.tangent @ (z - predicted))[None],
                ]
            )
            rights = jnp.column_stack([-gap, jnp.zeros(gap.size).at[-1].set(1.0)])
            moved, orientation = solve_many_with_sign(system, rights)
            norm = jnp.max(jnp.abs(gap))
            tangent = _unit(moved[:, 1])
            step = moved[:, 0]
            cut = jnp.minimum(1.0, 0.3 / jnp.max(jnp.abs(step)))
            # Without null vectors there is no slope yet: the first turn is for them.
            z = jnp.where(blank, z, z + cut * step)
            norm = jnp.where(blank, jnp.inf, norm)
            tangent = jnp.where(blank, lane.tangent, tangent)
            return z, _unit(w), _unit(v), norm, count + 1, (tangent, orientation)

        fresh = jnp.sum(jnp.abs(lane.left)) == 0.0
        most = jnp.where(fresh, _ITERATIONS_OF_STARTS, _ITERATIONS)

        def unfinished(state):
            return (state[3] > _CLOSE) & (state[4] < most)

        one = jnp.ones((), predicted.dtype)
        facts = (lane.tangent, one)
        first = (predicted, lane.left, lane.right, jnp.inf * one, jnp.array(0), facts)
        z, left, right, norm, _, (tangent, orientation) = jax.lax.while_loop(
            unfinished, newton, first
        )
        # A fresh tangent is oriented by the determinant, later ones by their predecessor.
        tangent = tangent * jnp.where(fresh & (orientation < 0.0), -1.0, 1.0)
        converged = (norm <= _CLOSE) & jnp.all(jnp.isfinite(z))
        return Lane(z, tangent, left, right, converged)

    return jax.vmap(one)(lanes, predicted)


def _unit(vector):
    return vector / jnp.sqrt(jnp.sum(vector**2))
