"""Small dense linear algebra against LAPACK."""

import concurrent.futures

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.statics.linear import inverse, inverse_with_sign, row_axes, solve_with_sign
from cpr_jax.statics.singular_values import norm_2
from cpr_jax.statics.solve import solve_inverse

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
    np.testing.assert_allclose(solutions, expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(signs, np.linalg.slogdet(matrices)[0])
    assert n == 1 or len(np.unique(signs)) == 2


def test_nested_batches_and_shared_matrices():
    matrices = needs_pivoting(4, 4)[:4]
    rights = RNG.normal(size=(3, 4))
    nested = jax.vmap(jax.vmap(solve_with_sign, in_axes=(None, 0)), in_axes=(0, None))
    solutions, _ = jax.jit(nested)(matrices, rights)
    for i, j in np.ndindex(4, 3):
        expected = np.linalg.solve(matrices[i], rights[j])
        np.testing.assert_allclose(solutions[i, j], expected, rtol=0, atol=1e-12)


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
    np.testing.assert_allclose(jax.jit(inverse)(matrix), exact, rtol=0, atol=1e-13)

    def along(t):
        return inverse(matrix + t * step)

    first, second = jax.jit(lambda t: (mode(along)(t), mode(mode(along))(t)))(0.0)
    np.testing.assert_allclose(first, -exact @ step @ exact, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        second, 2.0 * exact @ step @ exact @ step @ exact, rtol=0, atol=1e-11
    )
    assert first.dtype == jnp.float64


@pytest.mark.parametrize("n", [6, 14])
def test_norm_beside_svd_zero_nan_and_equal_singular_values(n):
    matrices = RNG.normal(size=(70, n, n))
    matrices[1], matrices[2], matrices[3] = 0.0, np.nan, np.eye(n)
    matrices[4] *= 1e-200
    found = jax.jit(jax.vmap(norm_2))(matrices)
    expected = [np.nan if k == 2 else np.linalg.norm(a, 2) for k, a in enumerate(matrices)]
    np.testing.assert_allclose(found, expected, rtol=1e-13)


@pytest.mark.parametrize(("k", "m"), [(1, 4), (2, 5), (3, 7), (5, 2)])
def test_axes_of_the_rows_beside_svd(k, m):
    matrices = RNG.normal(size=(10, k, m))
    matrices[0, 0] *= 1e-9
    matrices[1] = 0.0
    lengths, directions = jax.jit(jax.vmap(row_axes))(matrices)
    expected = np.zeros((10, k))
    expected[:, : min(k, m)] = np.linalg.svd(matrices, compute_uv=False)
    np.testing.assert_allclose(lengths, expected, rtol=1e-12, atol=1e-15)
    gram = directions @ np.swapaxes(directions, 1, 2)
    np.testing.assert_allclose(gram, np.tile(np.eye(k), (10, 1, 1)), rtol=0, atol=1e-14)
    along = np.linalg.norm(directions @ matrices, axis=2)
    np.testing.assert_allclose(along, expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_derivatives_of_the_axes(mode):
    """Beside central differences, on rows that are orthogonal, skew and of equal length."""
    for matrix in (np.eye(2, 3) * [[2.0], [1.0]], RNG.normal(size=(3, 4))):

        def lengths(a):
            return row_axes(a)[0]

        step = RNG.normal(size=matrix.shape)
        exact = np.sum(mode(lengths)(matrix) * step, axis=(1, 2))
        differences = (lengths(matrix + 1e-6 * step) - lengths(matrix - 1e-6 * step)) / 2e-6
        np.testing.assert_allclose(exact, differences, rtol=0, atol=1e-8)
    assert np.all(np.isfinite(mode(lengths)(np.eye(2, 3))))


def test_batches_that_meet_do_not_block_each_other():
    """Several batches in one program, and several programs at once, on all threads."""

    @jax.jit
    def several(matrices):
        return [jax.vmap(inverse_with_sign)(matrices + k)[0] for k in range(3)]

    matrices = RNG.normal(size=(2048, 10, 10))
    several(matrices)
    pool = concurrent.futures.ThreadPoolExecutor(3)
    runs = [pool.submit(lambda: jax.block_until_ready(several(matrices))) for _ in range(30)]
    pool.shutdown(wait=False)
    assert not concurrent.futures.wait(runs, timeout=60.0).not_done


def test_a_batch_of_solves_calls_no_lapack():
    """jaxlib's batches of LAPACK calls wait for the threads that they run on."""
    points = np.array([[0.0, 0.2], [0.01, 0.2]])
    batch = jax.jit(jax.vmap(lambda point: solve_inverse(rfrfr(), point)))
    assert "lapack" not in batch.lower(points).as_text()
