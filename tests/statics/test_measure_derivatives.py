"""Derivatives of the measures of an equilibrium beside central differences."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.statics.singular_values import norm_2, smallest
from cpr_jax.statics.solve import solve_inverse
from cpr_jax.statics.status import Status

RNG = np.random.default_rng(0)


def displaced(robot, distance):
    """The same robot with its first motor elsewhere, m; the units of its equations stay."""
    return eqx.tree_at(
        lambda robot: robot.legs.base_position,
        robot,
        robot.legs.base_position.at[0, 0].add(distance),
    )


AT = np.array([0.02, 0.2, 0.0, 0.25, 0.0183])
"""Where the platform is, how far the first motor is moved, length and stiffness of the rods."""

STEPS = np.array([2e-6, 2e-6, 2e-6, 2e-6, 2e-7])


def measures(x, guess):
    """Every smooth measure of the paper's robot, as one flat array."""
    robot = displaced(rfrfr(l=x[3], k_b=x[4]), x[2])
    found = solve_inverse(robot, x[:2], guess=guess, throw=False).measures
    names = ("sigma_t1", "sigma_t2", "condition", "motor_torques", "energy", "bows")
    return jnp.concatenate([jnp.atleast_1d(getattr(found, name)) for name in names])


@pytest.fixture(scope="module")
def nearby():
    return solve_inverse(rfrfr(), AT[:2])


@pytest.fixture(scope="module")
def pushed():
    """Derivatives of the measures, and their values, by one program."""
    return jax.jit(jax.jacfwd(lambda x, guess: (measures(x, guess),) * 2, has_aux=True))


def beside_differences(pushed, at, guess, places):
    """Derivatives in some numbers, and central differences of values in their place."""
    columns = []
    for k in places:
        step = STEPS * np.eye(len(STEPS))[k]
        above, below = (pushed(at + sign * step, guess)[1] for sign in (1.0, -1.0))
        columns.append((above - below) / (2.0 * STEPS[k]))
    return np.asarray(pushed(at, guess)[0])[:, places], np.stack(columns, axis=1)


def test_derivatives_beside_differences(pushed, nearby):
    forward, expected = beside_differences(pushed, AT, nearby, [0, 1, 2])
    assert np.all(np.max(np.abs(expected), axis=1) > 0.0)
    scale = np.maximum(1.0, np.max(np.abs(expected)))
    np.testing.assert_allclose(forward, expected, rtol=1e-5, atol=1e-7 * scale)


def test_derivatives_in_numbers_that_are_units_beside_differences(pushed):
    """Length and stiffness of the rods: what is dimensionless changes with its units."""
    at = np.concatenate([(0.06, 0.15), AT[2:]])
    guess = solve_inverse(rfrfr(), at[:2])
    found, expected = beside_differences(pushed, at, guess, [3, 4])
    scale = np.max(np.abs(expected), axis=1, keepdims=True)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=2e-6)


def test_reverse_mode_and_failed_lanes(pushed, nearby):
    """Both modes agree, and a lane without a solution spoils no other."""
    points = np.stack([AT, np.concatenate([(2.0, 2.0), AT[2:]])])

    def total(x):
        values = jax.vmap(lambda x: measures(x, nearby))(x)
        return jnp.sum(jnp.where(jnp.isfinite(values), values, 0.0))

    backward = jax.jit(jax.grad(total))(points)
    forward = jnp.sum(pushed(AT, nearby)[0], axis=0)
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


def test_the_paper_robot_is_solved(nearby):
    """What is compared above are numbers of an equilibrium."""
    assert int(nearby.status) == Status.SOLVED
