"""Small dense linear algebra, by LAPACK."""

import jax
import jax.numpy as jnp
from jax.scipy.linalg import lu_factor, lu_solve
from jaxtyping import Array, Float


def solve_with_sign(
    matrix: Float[Array, "n n"], right: Float[Array, " n"]
) -> tuple[Float[Array, " n"], Float[Array, ""]]:
    """`A⁻¹ b` and the sign of `det A`; not finite where A is singular. Not differentiated."""
    factors, pivots = lu_factor(matrix)
    swaps = jnp.sum(pivots != jnp.arange(matrix.shape[0]))
    sign = jnp.prod(jnp.sign(jnp.diagonal(factors))) * jnp.where(swaps % 2 == 0, 1.0, -1.0)
    return lu_solve((factors, pivots), right), sign


@jax.custom_jvp
def inverse(matrix: Float[Array, "n n"]) -> Float[Array, "n n"]:
    """`A⁻¹`, differentiable to any order in both modes; not finite where A is singular."""
    return jnp.linalg.inv(matrix)


@inverse.defjvp
def _inverse_jvp(primals, tangents):
    inverted = inverse(*primals)
    return inverted, -inverted @ tangents[0] @ inverted
