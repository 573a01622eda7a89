"""Ellipsoids: geometry, degenerate cases, derivatives."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.ellipsoid import LINEAR_COVERAGE


def test_linear_image_of_the_parameter_ellipsoid(robot, equilibria):
    """The farthest image of the ellipsoid (11) in any direction is on the boundary of (13)."""
    result = cpr.sensitivity(robot, equilibria[0.06, 0.15])
    ellipse = cpr.ellipsoid(result)
    rng = np.random.default_rng(1)
    sphere = rng.normal(size=(20000, 4))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    images = ellipse.center + (sphere * np.asarray(result.delta)) @ np.asarray(result.Pi_p).T
    levels = np.asarray(ellipse.level(images))
    assert np.all(levels <= 1.0 + 1e-9)
    assert np.max(levels) > 0.99
    np.testing.assert_allclose(ellipse.level(ellipse.boundary(50)), 1.0, rtol=1e-9)


def test_axes_are_those_of_the_kernel(robot, equilibria):
    ellipse = cpr.ellipsoid(cpr.sensitivity(robot, equilibria[0.06, 0.15]))
    values, vectors = np.linalg.eigh(np.asarray(ellipse.kernel))
    np.testing.assert_allclose(np.asarray(ellipse.semi_axes) ** 2, values[::-1], rtol=1e-9)
    alignment = np.abs(np.asarray(ellipse.directions) @ vectors[:, ::-1])
    np.testing.assert_allclose(alignment, np.eye(2), atol=1e-7)
    assert ellipse.semi_axes[0] >= ellipse.semi_axes[1]


def test_one_parameter_makes_a_flat_ellipse(robot, equilibria):
    result = cpr.sensitivity(robot, equilibria[0.06, 0.15], ["k_b1"])
    ellipse = cpr.ellipsoid(result)
    np.testing.assert_allclose(ellipse.semi_axes[1], 0.0, atol=1e-12)
    tip = ellipse.center + 0.5 * ellipse.semi_axes[0] * ellipse.directions[0]
    aside = ellipse.center + 0.1 * ellipse.semi_axes[0] * ellipse.directions[1]
    assert bool(ellipse.contains(tip))
    assert not bool(ellipse.contains(aside))


def test_a_flat_ellipse_covers_by_the_directions_it_has(robot, equilibria):
    flat = cpr.ellipsoid(cpr.sensitivity(robot, equilibria[0.06, 0.15], ["k_b1"]))
    along, across = np.asarray(flat.directions) * float(flat.semi_axes[0])
    points = flat.center + np.array([0.5 * along + 0.1 * across, 1.1 * along, np.nan * along])
    np.testing.assert_array_equal(flat.covers(points), [True, False, False])
    np.testing.assert_array_equal(flat.contains(points), [False] * 3)
    whole = cpr.ellipsoid(cpr.sensitivity(robot, equilibria[0.06, 0.15]))
    near = whole.center + np.random.default_rng(0).normal(scale=whole.semi_axes[0], size=(99, 2))
    np.testing.assert_array_equal(whole.covers(near), whole.contains(near))


def test_no_rows_and_no_boundary_are_named(robot, equilibria):
    result = cpr.sensitivity(robot, equilibria[0.06, 0.15])
    with pytest.raises(cpr.InputError, match="`rows`"):
        cpr.ellipsoid(result, ())
    with pytest.raises(cpr.InputError, match="has 3: q1, p_P_y, p_P_z"):
        cpr.ellipsoid(result, ("q1", "p_P")).boundary()


def test_nan_is_not_inside(robot, equilibria):
    ellipse = cpr.ellipsoid(cpr.sensitivity(robot, equilibria[0.06, 0.15]))
    assert not bool(ellipse.contains(jnp.full(2, jnp.nan)))


def test_linear_coverage_is_the_chi_square_value():
    from scipy.stats import chi2

    assert pytest.approx(chi2(2).cdf(9.0), abs=1e-15) == LINEAR_COVERAGE


def test_design_gradient_of_the_longer_axis(equilibria):
    """Through solve, sensitivity and ellipse, and of the platform's stiffness, by differences."""
    nominal = equilibria[0.06, 0.15]

    def chain(length, point):
        varied = cpr.rfrfr(l=length)
        found = cpr.solve_inverse(varied, point, guess=nominal, throw=False)
        slopes = cpr.sensitivity(varied, found)
        axis = cpr.ellipsoid(slopes).semi_axes[0]
        return jnp.append(1e3 * axis, slopes.platform_stiffness), found.status

    point = jnp.array([0.06, 0.15])
    pushed = jax.jit(lambda length: jax.jvp(lambda x: chain(x, point)[0], (length,), (1.0,)))
    h = 1e-4
    (above, _), (below, _), (_, forward) = (pushed(0.25 + step) for step in (h, -h, 0.0))
    np.testing.assert_allclose(forward, (above - below) / (2 * h), rtol=1e-4)

    def total(length):
        """Where one of two points is out of reach."""
        values, status = jax.vmap(lambda point: chain(length, point))(jnp.stack([point, 9 * point]))
        return jnp.sum(jnp.where((status == cpr.Status.SOLVED)[:, None], values, 0.0))

    backward = jax.jit(jax.grad(total))(0.25)
    np.testing.assert_allclose(backward, jnp.sum(forward), rtol=1e-9)
