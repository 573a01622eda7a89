"""Small dense linear algebra for batches, with the lanes last.

Written out rather than left to LAPACK, as jaxlib spreads a batch of LAPACK calls over the same
threads that run the program: two such batches that meet can block each other for good.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Float, Int

from ..lanes import in_blocks, over_lanes

BLOCK = 64
"""Lanes worked on at a time, so that their matrices stay in the cache of a core."""

_REGULAR = 1e-4
"""How far from the identity a matrix times its inverse may be."""


def solve_with_sign(
    matrix: Float[Array, "n n"], right: Float[Array, " n"]
) -> tuple[Float[Array, " n"], Float[Array, ""]]:
    """`A⁻¹ b` and the sign of `det A`; not finite where A is singular. Not differentiated."""
    solution, sign = _eliminate(matrix, right[:, None])
    return solution[:, 0], sign


def solve_many_with_sign(
    matrix: Float[Array, "n n"], rights: Float[Array, "n k"]
) -> tuple[Float[Array, "n k"], Float[Array, ""]]:
    """As `solve_with_sign` for several right-hand sides, the columns of `rights`."""
    return _eliminate(matrix, rights)


def inverse_with_sign(matrix: Float[Array, "n n"]) -> tuple[Float[Array, "n n"], Float[Array, ""]]:
    """`A⁻¹` and the sign of `det A`; not finite where A is singular. Not differentiated."""
    return _eliminate(matrix, jnp.eye(matrix.shape[0], dtype=matrix.dtype))


@jax.custom_jvp
def inverse(matrix: Float[Array, "n n"]) -> Float[Array, "n n"]:
    """`A⁻¹`, differentiable to any order in both modes; not finite where A is singular."""
    return inverse_with_sign(matrix)[0]


@inverse.defjvp
def _inverse_jvp(primals, tangents):
    inverted = inverse(*primals)
    return inverted, -inverted @ tangents[0] @ inverted


def regular_inverse(matrix: Float[Array, "n n"]) -> Float[Array, "n n"]:
    """`inverse`; NaN where it is none, as A is singular but for rounding."""
    inverted = inverse(matrix)
    off = jnp.max(jnp.abs(matrix @ inverted - jnp.eye(matrix.shape[0])))
    return jnp.where(off < _REGULAR, inverted, jnp.nan)


def negative_eigenvalues(matrix: Float[Array, "n n"]) -> Int[Array, ""]:
    """How many eigenvalues of a symmetric matrix are negative; zeros count as positive.

    Sylvester's law of inertia: as many as pivots of `L D Lᵀ`. Not differentiated.
    """
    return _negative_pivots(matrix)


def row_axes(matrix: Float[Array, "k m"]) -> tuple[Float[Array, " k"], Float[Array, "k k"]]:
    """Singular values of a matrix with few rows, largest first, and left vectors as rows.

    One-sided Jacobi rotations keep the digits of the small ones, and they differentiate in both
    modes: where two singular values agree, the vectors are a choice, held fixed by derivatives.
    """
    k = matrix.shape[0]
    pairs = [(i, j) for i in range(k) for j in range(i + 1, k)]

    def sweep(_, state):
        for i, j in pairs:
            state = _orthogonalise(state, i, j)
        return state

    both = jnp.concatenate([matrix, jnp.eye(k, dtype=matrix.dtype)], axis=1)
    # Two rows are orthogonal after one rotation; more need sweeps, which converge quadratically.
    both = sweep(0, both) if k <= 2 else lax.fori_loop(0, 8 + k, sweep, both)
    squares = jnp.sum(both[:, :-k] ** 2, axis=1)
    order = jnp.argsort(-squares)
    positive = squares > 0.0
    lengths = jnp.where(positive, jnp.sqrt(jnp.where(positive, squares, 1.0)), 0.0)
    lengths = jnp.where(jnp.isnan(squares), jnp.nan, lengths)
    return lengths[order], both[order, -k:]


def _orthogonalise(rows, i: int, j: int):
    """Turns two rows about one another until their first parts are orthogonal."""
    k = rows.shape[0]
    x, y = rows[i], rows[j]
    product = 2.0 * jnp.dot(x[:-k], y[:-k])
    difference = jnp.dot(y[:-k], y[:-k]) - jnp.dot(x[:-k], x[:-k])
    needed = product != 0.0
    size = jnp.sqrt(jnp.where(needed, difference**2 + product**2, 1.0))
    side = jnp.where(difference < 0.0, -1.0, 1.0)
    # A product that vanishes keeps its derivative if the rows differ in length.
    apart = difference + side * jnp.where(needed, size, jnp.abs(difference))
    equal = apart == 0.0
    tangent = jnp.where(equal, 0.0, product / jnp.where(equal, 1.0, apart))
    cosine = 1.0 / jnp.sqrt(1.0 + tangent**2)
    sine = cosine * tangent
    return rows.at[i].set(cosine * x - sine * y).at[j].set(sine * x + cosine * y)


def eliminated(
    matrix: Float[Array, "n n lanes"], rights: Float[Array, "n k lanes"]
) -> tuple[Float[Array, "n k lanes"], Float[Array, " lanes"]]:
    """`A⁻¹ B` and the sign of `det A` for arrays that have their lanes last."""
    lanes = max(matrix.shape[-1], rights.shape[-1])
    both = [jnp.broadcast_to(a, (*a.shape[:2], lanes)) for a in (matrix, rights)]
    if len(matrix) == 1:
        # As below, but for the loop: the plane has many of these.
        return both[1] / both[0], jnp.sign(both[0][0, 0])
    return in_blocks(_gauss_jordan, [jnp.concatenate(both, axis=1)], BLOCK)


class Eliminated(NamedTuple):
    """A square system `A x = B` of which one unknown is left, lanes last.

    **Attributes:**

    - `solved`: x while the unknown that is left is zero, `(n, k)`.
    - `weak`: how x goes with the unknown that is left, `(n,)`; it is 1 for that itself.
    - `own`, `left`: the equation that remains, `own` times the unknown equals `left`.
    - `sign`: of `det A` without the factor `own`.
    """

    solved: Float[Array, "n k lanes"]
    weak: Float[Array, "n lanes"]
    own: Float[Array, " lanes"]
    left: Float[Array, "k lanes"]
    sign: Float[Array, " lanes"]


def eliminated_but_one(
    matrix: Float[Array, "n n lanes"], rights: Float[Array, "n k lanes"]
) -> Eliminated:
    """All unknowns of `A x = B` but the one that A determines least; A may be singular so far.

    The order is that of Gauss and Jordan with complete pivoting.
    """
    return Eliminated(*in_blocks(_but_one, [jnp.concatenate([matrix, rights], axis=1)], BLOCK))


def _but_one(rows):
    n, lanes = rows.shape[0], rows.shape[-1]
    index = lax.broadcasted_iota(jnp.int32, (n, n, lanes), 0) * n
    index += lax.broadcasted_iota(jnp.int32, (n, n, lanes), 1)

    def eliminate(_, state):
        rows, free, place, sign = state
        size = jnp.where(free, jnp.abs(rows[:, :n]), -1.0)
        largest = size == jnp.max(size, axis=(0, 1))
        chosen = index == jnp.min(jnp.where(largest, index, n * n), axis=(0, 1))
        row, column = jnp.any(chosen, axis=1), jnp.any(chosen, axis=0)
        pivot_row = jnp.sum(jnp.where(row[:, None], rows, 0.0), axis=0)
        pivot = jnp.sum(jnp.where(column, pivot_row[:n], 0.0), axis=0)
        factors = jnp.sum(jnp.where(column, rows[:, :n], 0.0), axis=1)
        pivot_row = pivot_row / pivot
        others = rows - factors[:, None] * pivot_row
        rows = jnp.where(row[:, None], pivot_row, others)
        free = free & ~row[:, None] & ~column
        return rows, free, place | chosen, sign * jnp.sign(pivot)

    none = jnp.zeros((n, n, lanes), bool)
    start = rows, ~none, none, jnp.ones(lanes, rows.dtype)
    rows, free, place, sign = lax.fori_loop(0, n - 1, eliminate, start)
    last_row, last_column = jnp.any(free, axis=1), jnp.any(free, axis=0)
    by_left = jnp.sum(jnp.where(last_column, rows[:, :n], 0.0), axis=1)
    left = jnp.sum(jnp.where(last_row[:, None], rows[:, n:], 0.0), axis=0)
    own = jnp.sum(jnp.where(last_row, by_left, 0.0), axis=0)
    solved = sum(jnp.where(place[i][:, None], rows[i, n:], 0.0) for i in range(n))
    weak = jnp.where(last_column, 1.0, -sum(jnp.where(place[i], by_left[i], 0.0) for i in range(n)))
    whose = jnp.sum(jnp.where(place | free, index // n, 0), axis=0)
    swaps = sum((whose[i] > whose[j]).astype(rows.dtype) for j in range(n) for i in range(j))
    return solved, weak, own, left, sign * (1.0 - 2.0 * (swaps % 2.0))


_eliminate = over_lanes(eliminated, lambda _, right: (right, jax.ShapeDtypeStruct((), right.dtype)))


def _gauss_jordan(rows):
    """`A⁻¹ B` and the sign of `det A` for `rows = (A, B)`, with partial pivoting per lane."""
    n, lanes = rows.shape[0], rows.shape[-1]
    index = lax.broadcasted_iota(jnp.int32, (n, lanes), 0)

    def eliminate(c, state):
        rows, sign = state
        column = lax.dynamic_index_in_dim(rows, c, 1, keepdims=False)
        size = jnp.where(index >= c, jnp.abs(column), -1.0)
        chosen = jnp.min(jnp.where(size == jnp.max(size, axis=0), index, n), axis=0)
        is_pivot = index == chosen
        pivot_row = jnp.sum(jnp.where(is_pivot[:, None], rows, 0.0), axis=0)
        swapped = lax.dynamic_index_in_dim(rows, c, 0, keepdims=False)
        pivot = lax.dynamic_index_in_dim(pivot_row, c, 0, keepdims=False)
        head = lax.dynamic_index_in_dim(swapped, c, 0, keepdims=False)
        pivot_row = pivot_row / pivot
        factors = jnp.where(is_pivot, head, column)[:, None]
        others = jnp.where(is_pivot[:, None], swapped, rows) - factors * pivot_row
        rows = jnp.where((index == c)[:, None], pivot_row, others)
        return rows, sign * jnp.sign(pivot) * jnp.where(chosen == c, 1.0, -1.0)

    rows, sign = lax.fori_loop(0, n, eliminate, (rows, jnp.ones(lanes, rows.dtype)))
    return rows[:, n:], sign


def _count_negative(matrix):
    if len(matrix) == 1:
        return (matrix[0, 0] < 0.0).astype(jnp.int32)
    return in_blocks(_pivots, [matrix], BLOCK)


def _pivots(matrix):
    """Negative pivots of `L D Lᵀ`, the largest first; a pivot of zero becomes a tiny one."""
    n, lanes = matrix.shape[0], matrix.shape[-1]
    index = lax.broadcasted_iota(jnp.int32, (n, lanes), 0)
    # In units of the diagonal, which change no sign: a small pivot is not one of zero because
    # another direction is many times as stiff.
    diagonal = jnp.stack([jnp.abs(matrix[i, i]) for i in range(n)])
    size = jnp.where(diagonal > 0.0, diagonal, jnp.max(jnp.abs(matrix), axis=1))
    unit = lax.rsqrt(jnp.where(size > 0.0, size, 1.0))
    matrix = matrix * unit[:, None] * unit
    tiny = 1e-14 * jnp.max(jnp.abs(matrix), axis=(0, 1))
    tiny = jnp.where(tiny > 0.0, tiny, 1.0)

    def eliminate(_, state):
        rest, used, count = state
        diagonal = jnp.sum(jnp.where(jnp.eye(n, dtype=bool)[:, :, None], rest, 0.0), axis=0)
        size = jnp.where(used, -1.0, jnp.abs(diagonal))
        chosen = jnp.min(jnp.where(size == jnp.max(size, axis=0), index, n), axis=0)
        is_pivot = index == chosen
        row = jnp.sum(jnp.where(is_pivot[:, None], rest, 0.0), axis=0)
        pivot = jnp.sum(jnp.where(is_pivot, diagonal, 0.0), axis=0)
        pivot = jnp.where(jnp.abs(pivot) < tiny, tiny, pivot)
        row = jnp.where(used, 0.0, row)
        rest = rest - row[:, None] * row / pivot
        return rest, used | is_pivot, count + (pivot < 0.0)

    start = matrix, jnp.zeros((n, lanes), bool), jnp.zeros(lanes, jnp.int32)
    return lax.fori_loop(0, n, eliminate, start)[2]


_negative_pivots = over_lanes(_count_negative, lambda _: jax.ShapeDtypeStruct((), jnp.int32))
