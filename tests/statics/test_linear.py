"""Small dense solves against LAPACK."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.linear import inverse, solve_with_sign

RNG = np.random.default_rng(0)


def needs_pivoting(n, size):
    """Well-conditioned matrices with zeros on the diagonal."""
    turn = np.linalg.qr(RNG.normal(size=(size, n, n)))[0]
    matrices = turn * RNG.uniform(0.5, 2.0, (size, 1, n)) * RNG.choice([-1.0, 1.0], (size, 1, n))
    shifted = np.roll(np.eye(n), 1, axis=0)
    return np.concatenate([matrices, shifted[None], -shifted[None]])


@pytest.mark.parametrize("n", [1, 2, 10])
def test_solution_and_sign_of_the_determinant(n):
    matrices = needs_pivoting(n, 20)
    rights = RNG.normal(size=matrices.shape[:2])
    solutions, signs = jax.jit(jax.vmap(solve_with_sign))(matrices, rights)
    expected = np.linalg.solve(matrices, rights[..., None])[..., 0]
    np.testing.assert_allclose(solutions, expected, atol=1e-12)
    np.testing.assert_array_equal(signs, np.linalg.slogdet(matrices)[0])
    assert n == 1 or len(np.unique(signs)) == 2


def test_nested_batches_and_shared_matrices():
    matrices = needs_pivoting(4, 4)[:4]
    rights = RNG.normal(size=(3, 4))
    nested = jax.vmap(jax.vmap(solve_with_sign, in_axes=(None, 0)), in_axes=(0, None))
    solutions, _ = jax.jit(nested)(matrices, rights)
    for i, j in np.ndindex(4, 3):
        expected = np.linalg.solve(matrices[i], rights[j])
        np.testing.assert_allclose(solutions[i, j], expected, atol=1e-12)


def test_singular_and_nan_lanes_do_not_touch_others():
    matrices = needs_pivoting(3, 3)[:3]
    matrices[0] = 1.0
    matrices[1, 0, 0] = np.nan
    solutions, _ = jax.jit(jax.vmap(solve_with_sign))(matrices, np.arange(9.0).reshape(3, 3))
    assert not np.all(np.isfinite(solutions[0]))
    assert not np.all(np.isfinite(solutions[1]))
    np.testing.assert_allclose(solutions[2], np.linalg.solve(matrices[2], [6.0, 7.0, 8.0]))


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_derivatives_of_the_inverse(mode):
    """`d A⁻¹ = -A⁻¹ dA A⁻¹`, and once more for the second derivative along a direction."""
    matrix, step = needs_pivoting(3, 2)[0], RNG.normal(size=(3, 3))
    exact = np.linalg.inv(matrix)
    np.testing.assert_allclose(jax.jit(inverse)(matrix), exact, atol=1e-13)

    def along(t):
        return inverse(matrix + t * step)

    first, second = jax.jit(lambda t: (mode(along)(t), mode(mode(along))(t)))(0.0)
    np.testing.assert_allclose(first, -exact @ step @ exact, atol=1e-12)
    np.testing.assert_allclose(second, 2.0 * exact @ step @ exact @ step @ exact, atol=1e-11)
    assert first.dtype == jnp.float64
