"""Derivatives of the measures of an equilibrium beside central differences."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.statics.equilibrium import solve_inverse
from cpr_jax.statics.singular_values import norm_2, smallest
from cpr_jax.statics.status import Status

RNG = np.random.default_rng(0)


def displaced(robot, distance):
    """The same robot with its first motor elsewhere, m; the units of its equations stay."""
    return eqx.tree_at(
        lambda robot: robot.legs.base_position,
        robot,
        robot.legs.base_position.at[0, 0].add(distance),
    )


@pytest.fixture(scope="module")
def plane():
    """Measures of the paper's robot at (y, z) and with a motor moved, as one flat array."""
    robot = rfrfr()
    nearby = solve_inverse(robot, (0.02, 0.2))

    def measures(x):
        found = solve_inverse(displaced(robot, x[2]), x[:2], guess=nearby)
        return _flat(found.measures)

    return measures, np.array([0.02, 0.2, 0.0])


def _flat(measures):
    """Every number that is smooth."""
    names = ("sigma_t1", "sigma_t2", "condition", "motor_torques", "energy", "bows")
    return jnp.concatenate([jnp.atleast_1d(getattr(measures, name)) for name in names])


def test_derivatives_beside_differences(plane):
    measures, at = plane
    run = jax.jit(measures)
    h = 2e-6
    steps = h * np.eye(at.size)
    expected = np.stack([(run(at + e) - run(at - e)) / (2.0 * h) for e in steps], axis=1)
    assert np.all(np.max(np.abs(expected), axis=1) > 0.0)
    forward = np.asarray(jax.jit(jax.jacfwd(measures))(at))
    scale = np.maximum(1.0, np.max(np.abs(expected)))
    np.testing.assert_allclose(forward, expected, rtol=1e-5, atol=1e-7 * scale)


def test_derivatives_in_numbers_that_are_units_beside_differences():
    """Length and stiffness of the rods: what is dimensionless changes with its units."""
    nearby = solve_inverse(rfrfr(), (0.06, 0.15))

    def measures(x):
        robot = rfrfr(l=x[0], k_b=x[1])
        return _flat(solve_inverse(robot, (0.06, 0.15), guess=nearby, throw=False).measures)

    run, at, h = jax.jit(measures), np.array([0.25, 0.0183]), np.array([2e-6, 2e-7])
    expected = np.stack(
        [(run(at + e) - run(at - e)) / (2.0 * np.max(e)) for e in np.diag(h)], axis=1
    )
    found = np.asarray(jax.jit(jax.jacfwd(measures))(at))
    scale = np.max(np.abs(expected), axis=1, keepdims=True)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=2e-6)


def test_reverse_mode_and_failed_lanes(plane):
    """Both modes agree, and a lane without a solution spoils no other."""
    measures, at = plane
    points = np.stack([at, [2.0, 2.0, 0.0]])

    def sums(x):
        values = jax.vmap(measures)(x)
        return jnp.sum(jnp.where(jnp.isfinite(values), values, 0.0), axis=1)

    backward = jax.jit(jax.grad(lambda x: jnp.sum(sums(x))))(points)
    forward = jnp.sum(jax.jit(jax.jacfwd(measures))(at), axis=0)
    np.testing.assert_allclose(backward[0], forward, rtol=1e-9)
    np.testing.assert_array_equal(backward[1], 0.0)


@pytest.mark.parametrize("function", [norm_2, lambda a: smallest(a)[0]])
def test_singular_values_beside_differences(function):
    matrix, change = RNG.normal(size=(2, 6, 6))
    h = 1e-6
    expected = (function(matrix + h * change) - function(matrix - h * change)) / (2.0 * h)
    _, found = jax.jvp(function, (jnp.asarray(matrix),), (jnp.asarray(change),))
    np.testing.assert_allclose(found, expected, rtol=1e-8)
    second = jax.hessian(function)(jnp.asarray(matrix))
    assert np.all(np.isnan(second))


def test_a_singular_matrix_has_no_slope():
    matrix = jnp.asarray(np.diag([1.0, 2.0, 0.0]))
    (value, sign), (slope, _) = jax.jvp(smallest, (matrix,), (jnp.ones((3, 3)),))
    assert float(value) == float(sign) == float(slope) == 0.0


def test_the_paper_robot_is_solved(plane):
    """What is compared above are numbers of an equilibrium."""
    found = solve_inverse(rfrfr(), plane[1][:2])
    assert int(found.status) == Status.SOLVED
