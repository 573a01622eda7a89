"""Corrections by a matrix that stays, on problems with known roots."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.chord import Chord, chord_corrector
from cpr_jax.statics.continuation import DEVIATION


def corrected(equations, predicted, slope, h, dh):
    """One correction, compiled."""

    def linearised(y, h):
        return equations(y, h), jax.jacfwd(equations)(y, h)

    correct = jax.jit(chord_corrector(equations, linearised))
    return correct(*(jnp.asarray(x, float) for x in (predicted, slope, h, dh, DEVIATION)))


def coupled(y, h):
    """`x² + z = h₀`, `z³ + x z = h₁`: at x = 1.2, z = 0.8 for h = (2.24, 1.472)."""
    x, z = y
    return jnp.stack([x**2 + z - h[0], z**3 + x * z - h[1]])


ROOT, THERE = np.array([1.2, 0.8]), np.array([2.24, 1.472])


@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.3, -0.2)])
def test_root_sign_and_slope(slope):
    way = np.array([0.5, -0.3])
    found = corrected(coupled, ROOT + np.array([0.02, -0.01]), slope, THERE, way)
    assert bool(found.converged)
    np.testing.assert_allclose(found.y, ROOT, rtol=0, atol=1e-11)
    jacobian = np.array([[2.4, 1.0], [0.8, 3.0 * 0.64 + 1.2]])
    assert float(found.sign) == np.sign(np.linalg.det(jacobian))
    exact = np.linalg.solve(jacobian, way)
    np.testing.assert_allclose(found.slope, exact, rtol=0, atol=0.01 * np.max(np.abs(exact)))


def test_a_prediction_that_is_a_root_stays():
    found = corrected(coupled, ROOT, np.zeros(2), THERE, np.zeros(2))
    assert bool(found.converged)
    np.testing.assert_allclose(found.y, ROOT, rtol=0, atol=1e-14)
    np.testing.assert_allclose(found.slope, 0.0, atol=1e-10)


def test_roots_too_far_away_do_not_count():
    found = corrected(coupled, ROOT + 2.0 * DEVIATION, np.zeros(2), THERE, np.zeros(2))
    assert not bool(found.converged)


@pytest.mark.parametrize("offset, taken", [(0.002, True), (0.004, False), (0.012, False)])
def test_slow_contraction_does_not_count(offset, taken):
    """Near a fold the matrix may be from its other side: `y² = 1e-4` has the roots ±0.01."""
    found = corrected(lambda y, h: y**2 - h, [0.01 - offset], [0.0], [1e-4], [0.0])
    assert bool(found.converged) == taken
    if taken:
        np.testing.assert_allclose(found.y, 0.01, rtol=0, atol=1e-9)


def test_two_changes_of_a_linear_problem_solve_it():
    """Along one direction the combination of two changes is exact, however bad the matrix."""
    now = Chord.start(jnp.array([3.0]))
    for _ in range(3):
        f = 2.0 * (now.y - 1.0)
        now = now.advanced(-0.8 * f, jnp.max(jnp.abs(f)))
    np.testing.assert_allclose(now.y, 1.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(now.worst, 0.6, rtol=1e-12)


@pytest.mark.parametrize("enough", [1e-4, 1e-7, 1e-10])
def test_it_ends_where_it_is_good_enough(enough):
    """`y³ = 8` by a slope that is off by a tenth; what is left is told without a further value."""

    def residual(y):
        return y**3 - 8.0

    def advanced(now):
        f = residual(now.y)
        return now.advanced(-f / 10.8, jnp.max(jnp.abs(f)))

    now = Chord.start(jnp.array([2.1]), enough)
    while now.unfinished:
        now = advanced(now)
    assert bool(now.converged)
    assert float(jnp.abs(residual(now.y))[0]) < enough
    less = Chord.start(jnp.array([2.1]), enough)
    for _ in range(int(now.corrections) - 1):
        less = advanced(less)
    assert float(jnp.abs(residual(less.y))[0]) > 1e-3 * enough
