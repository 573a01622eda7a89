"""Expansions of an equilibrium against differences of solves and of Jacobians."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.expansion import HeldEquations, expand
from cpr_jax.analysis.parameters import ranges, select
from cpr_jax.statics.unknowns import unknown_scales

ROBOTS = {"paper": (cpr.rfrfr, (0.06, 0.18)), "3-RFR": (cpr.three_rfr, (0.01, 0.02, 0.1))}


@pytest.fixture(scope="module", params=list(ROBOTS))
def case(request):
    make, point = ROBOTS[request.param]
    robot = make()
    selection = select(robot)
    nominal = cpr.sensitivity(robot, cpr.solve_inverse(robot, point))
    delta = ranges(robot, selection, None)
    return robot, selection, nominal, expand(robot, selection, nominal.y, nominal.Pi_y, delta)


def test_second_order_predicts_to_third(case):
    """Halving the way divides what the prediction lacks by eight."""
    robot, selection, nominal, expansion = case
    delta = np.asarray(nominal.delta) * np.where(np.arange(nominal.delta.size) % 2, 0.4, -0.3)
    lacks = []
    for share in (0.25, 0.125):
        varied = selection.set(robot, expansion.rho + share * delta)
        guess = cpr.solve_forward(robot, nominal.y[: robot.n_a])
        found = cpr.solve_forward(varied, nominal.y[: robot.n_a], guess=guess)
        step = share * delta
        predicted = expansion.y + expansion.first @ step + 0.5 * (expansion.second @ step) @ step
        reached = (found.y / unknown_scales(robot))[robot.n_a :]
        lacks.append(np.max(np.abs(predicted - reached)))
    assert lacks[1] < lacks[0] / 6.5
    assert lacks[0] < 1e-3


def test_inverse_follows_the_branch(case):
    """`A (1 + T) Aᵀ M` is the inverse Jacobian at a varied equilibrium, to third order."""
    robot, selection, nominal, expansion = case
    equations = HeldEquations(robot, selection, nominal.y, 10)
    slope = jax.jit(lambda y, rho: jax.jacfwd(equations)(y, rho))
    turn_at = jax.jit(lambda step: expansion.turned(step))
    axes = expansion.axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(expansion.y.size), atol=1e-12)
    signs = np.where(np.arange(nominal.delta.size) % 3, 0.7, -1.0)
    errors = []
    for share in (0.16, 0.08):
        step = share * signs * jnp.asarray(nominal.delta)
        y = expansion.y + expansion.first @ step + 0.5 * (expansion.second @ step) @ step
        jacobian = slope(y, expansion.rho + step)
        turn = axes @ turn_at(step) @ axes.T
        product = (jnp.eye(y.size) + turn) @ expansion.inverse @ jacobian
        errors.append(np.max(np.abs(product - np.eye(y.size))))
    assert errors[0] < 1e-2
    assert errors[1] < errors[0] / 6.5


def turned(case, reach, samples=2000):
    """T at random parameters, as far away as `reach` of their ranges."""
    _, _, nominal, expansion = case
    random = np.random.default_rng(0).uniform(-reach, reach, (samples, nominal.delta.size))
    return jax.vmap(expansion.turned)(random * np.asarray(nominal.delta))


def test_what_is_said_to_be_regular_has_a_positive_determinant(case):
    """Far away some samples have not: none of them is taken for regular."""
    expansion = case[3]
    for reach in (1.0, 3.0, 10.0):
        T = turned(case, reach)
        regular = np.asarray(jax.vmap(expansion.is_regular)(T))
        signs = np.linalg.slogdet(np.eye(expansion.y.size) + np.asarray(T))[0]
        assert np.all(signs[regular] > 0.0)
    assert np.mean(signs > 0.0) < 0.9


def test_most_of_what_is_near_is_seen_to_be_regular(case):
    expansion = case[3]
    assert np.mean(jax.vmap(expansion.is_regular)(turned(case, 0.5))) > 0.9


def test_a_second_order_of_many_numbers_is_left_out():
    robot = cpr.stewart_gough()
    selection = select(robot)
    nominal = cpr.sensitivity(robot, cpr.solve_inverse(robot, robot.home.q_p))
    delta = ranges(robot, selection, None)
    expansion = expand(robot, selection, nominal.y, nominal.Pi_y, delta)
    assert len(expansion.turn) == delta.size
    np.testing.assert_array_equal(expansion.turned(0.0 * delta), 0.0)
