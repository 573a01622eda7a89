"""The largest and the smallest singular value of a matrix, with their first derivatives."""

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Float

from ..lanes import in_blocks, over_lanes
from .linear import BLOCK, inverse_with_sign

_SQUARINGS = 30
"""Most squarings of a Gram matrix: two singular values 1e-9 apart (relative) still differ."""

_LONG = 12
"""Rows from which on products of many matrices are written out: XLA's own sum strides through
memory and takes up to ten times as long, but compiles in half the time."""


@jax.custom_jvp
def norm_2(matrix: Float[Array, "n m"]) -> Float[Array, ""]:
    """Largest singular value; NaN where an entry is not finite.

    Its first derivative is `u vᵀ`; where two values agree it is that along one of their mixtures.
    Second derivatives are not provided: they are NaN.
    """
    return _largest(matrix)[0]


@norm_2.defjvp
def _norm_2_jvp(primals, tangents):
    (matrix,), (change,) = primals, tangents
    fixed = lax.stop_gradient(matrix)
    norm, projector = _largest(fixed)
    return norm_2(matrix), jnp.sum(_final(fixed @ projector / norm, matrix) * change)


@jax.custom_jvp
def smallest(matrix: Float[Array, "n n"]) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Smallest singular value of a matrix, and the sign of its determinant.

    Derivatives as for `norm_2`; where it vanishes, which is no smooth point, they are zero.
    """
    inverted, sign = inverse_with_sign(matrix)
    singular = jnp.all(jnp.isfinite(matrix)) & ~jnp.all(jnp.isfinite(inverted))
    return jnp.where(singular, 0.0, 1.0 / norm_2(inverted)), jnp.where(singular, 0.0, sign)


@smallest.defjvp
def _smallest_jvp(primals, tangents):
    (matrix,), (change,) = primals, tangents
    inverted, _ = inverse_with_sign(lax.stop_gradient(matrix))
    norm, projector = _largest(inverted)
    value, sign = smallest(matrix)
    # With the inverse B: dσ = -d‖B‖ / ‖B‖² and dB = -B dA B.
    slope = inverted.T @ inverted @ projector @ inverted.T / norm**3
    return (value, sign), (jnp.sum(_final(slope, matrix) * change), jnp.zeros_like(sign))


@jax.custom_jvp
def _final(slope, matrix):
    """A slope by a matrix: zero where there is none, and without a derivative of its own."""
    return jnp.where(jnp.all(jnp.isfinite(slope)), slope, 0.0)


@_final.defjvp
def _final_jvp(primals, tangents):
    return _final(*primals), jnp.nan * tangents[1]


@over_lanes
def _largest(matrix):
    return in_blocks(_power, [matrix], BLOCK)


def _power(matrix):
    """Largest singular value, and `v vᵀ` of its right vector, lanes last.

    From high powers of the Gram matrix, found by squaring.
    """
    size = jnp.max(jnp.abs(matrix), axis=(0, 1))
    some = (size > 0.0) & jnp.isfinite(size)
    scaled = jnp.where(some, matrix, 1.0) / jnp.where(some, size, 1.0)
    gram = _product(jnp.swapaxes(scaled, 0, 1), scaled)
    n = gram.shape[0]

    def trace(g):
        return jnp.sum(jnp.where(jnp.eye(n, dtype=bool)[:, :, None], g, 0.0), axis=(0, 1))

    def spread(g):
        """Zero once one singular value has outgrown the others."""
        return 1.0 - jnp.sum(g**2, axis=(0, 1)) / trace(g) ** 2

    def unfinished(state):
        count, g = state
        return (count < _SQUARINGS) & jnp.any(spread(g) > 1e-15 * n)

    def square(state):
        count, g = state
        g = g / trace(g)
        return count + 1, _product(g, g)

    _, power = lax.while_loop(unfinished, square, (0, gram))
    projector = power / trace(power)
    largest = jnp.sum(gram * projector, axis=(0, 1))
    norm = jnp.where(some, size * jnp.sqrt(largest), jnp.where(size == 0.0, 0.0, jnp.nan))
    return norm, projector


def _product(a, b):
    """Matrix product, lanes last."""
    if len(b) < _LONG or b.shape[-1] == 1:
        return jnp.sum(a[:, :, None] * b, axis=1)
    return sum(a[:, k, None] * b[k] for k in range(len(b)))


def evenness(lengths: Float[Array, " k"]) -> Float[Array, ""]:
    """Smallest over largest of singular values, the largest first; 0 if all are."""
    longest = lengths[0]
    return jnp.where(longest == 0.0, 0.0, lengths[-1] / jnp.where(longest == 0.0, 1.0, longest))
