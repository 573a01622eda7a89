"""Second derivatives of equilibria: differences of gradients, and forward against reverse."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.problem import Problem, inverse_rows
from cpr_jax.statics.roots import find_root
from tests.statics.common import with_stiffness

POINT = (0.03, 0.19)
RHO = jnp.array([1.83, 1.83, -1.0, 1.0])
"""Bending stiffnesses in 0.01 N·m² and curvatures at rest in 1/m."""


@pytest.fixture(scope="module")
def value(paper):
    """A combination of all unknowns with the platform held, as a function of `RHO`."""
    weights = jnp.asarray(np.random.default_rng(0).normal(size=paper.n_y))
    target = jnp.array([0.0, 0.0, *POINT])

    def combination(rho, guess):
        robot = with_stiffness(paper, 0.01 * rho[:2])
        robot = eqx.tree_at(lambda r: r.legs.rod.precurvature, robot, rho[2:, None])
        return weights @ find_root(Problem(robot, inverse_rows(robot), target), guess).y

    return combination


@pytest.fixture(scope="module")
def gradient(value):
    return jax.jit(jax.grad(value))


@pytest.fixture(scope="module")
def hessian(value, published):
    return np.asarray(jax.jit(jax.jacfwd(jax.jacfwd(value)))(RHO, published))


def test_against_differences_of_gradients(gradient, hessian, published):
    step = 1e-4
    columns = [
        (gradient(RHO + step * unit, published) - gradient(RHO - step * unit, published))
        / (2.0 * step)
        for unit in np.eye(4)
    ]
    expected = np.stack(columns, axis=1)
    largest = np.max(np.abs(expected))
    assert largest > 0.1
    np.testing.assert_allclose(hessian, expected, rtol=0, atol=1e-5 * largest)


def test_forward_over_forward_equals_reverse_over_reverse(value, hessian, published):
    reverse = jax.jit(jax.jacrev(jax.grad(value)))(RHO, published)
    largest = np.max(np.abs(hessian))
    np.testing.assert_allclose(reverse, hessian, rtol=0, atol=1e-10 * largest)
    np.testing.assert_allclose(hessian, hessian.T, rtol=0, atol=1e-10 * largest)


def test_a_derivative_belongs_to_the_root_and_not_to_the_way_there(gradient, published):
    for other in (published * 1.01, published + 0.01):
        np.testing.assert_allclose(gradient(RHO, other), gradient(RHO, published), rtol=1e-9)
