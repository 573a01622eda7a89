"""Small dense linear algebra for batches, lanes last."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..lanes import lanes_last


@lanes_last
def _eliminate(lift, matrix, right):
    """Gauss–Jordan elimination with partial pivoting: `A⁻¹ b` and the sign of `det A`."""
    n, k = right.shape[:2]
    lanes = matrix.shape[2:] or right.shape[2:]
    table = jnp.concatenate(
        [
            jnp.broadcast_to(
                part.reshape(*part.shape, *(1,) * (2 + len(lanes) - part.ndim)),
                (*part.shape[:2], *lanes),
            )
            for part in (matrix, right)
        ],
        axis=1,
    )
    rows = jnp.arange(n).reshape(n, *(1,) * len(lanes))

    def column(i, carry):
        table, sign = carry
        entries = jax.lax.dynamic_index_in_dim(table, i, axis=1, keepdims=False)
        pivot = jnp.argmax(jnp.where(rows >= i, jnp.abs(entries), -1.0), axis=0)
        chosen = (rows == pivot)[:, None]
        pivot_row = jnp.sum(jnp.where(chosen, table, 0.0), axis=0)
        row_i = jax.lax.dynamic_index_in_dim(table, i, axis=0, keepdims=False)
        table = jnp.where(chosen, row_i, table)
        value = jax.lax.dynamic_index_in_dim(pivot_row, i, axis=0, keepdims=False)
        sign = sign * jnp.sign(value) * jnp.where(pivot == i, 1.0, -1.0)
        pivot_row = pivot_row / value
        factors = jax.lax.dynamic_index_in_dim(table, i, axis=1, keepdims=True)
        table = jnp.where((rows == i)[:, None], pivot_row, table - factors * pivot_row)
        return table, sign

    table, sign = jax.lax.fori_loop(0, n, column, (table, jnp.ones(lanes)))
    return table[:, n : n + k], sign


def solve_with_sign(
    matrix: Float[Array, "n n"], right: Float[Array, " n"]
) -> tuple[Float[Array, " n"], Float[Array, ""]]:
    """`A⁻¹ b` and the sign of `det A`; not finite where A is singular. Not differentiable."""
    solution, sign = _eliminate(matrix, right[:, None])
    return solution[:, 0], sign


@jax.custom_jvp
def inverse(matrix: Float[Array, "n n"]) -> Float[Array, "n n"]:
    """`A⁻¹`, differentiable to any order in both modes; not finite where A is singular."""
    return _eliminate(matrix, jnp.eye(matrix.shape[0]))[0]


@inverse.defjvp
def _inverse_jvp(primals, tangents):
    inverted = inverse(*primals)
    return inverted, -inverted @ tangents[0] @ inverted
