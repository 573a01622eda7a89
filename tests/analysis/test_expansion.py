"""Expansions of an equilibrium against differences of solves and of Jacobians."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.expansion import expand, held_equations
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
    return robot, selection, nominal, expand(robot, selection, nominal.y, nominal.Pi_y, delta, 10)


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
        lacks.append(np.max(np.abs(predicted - found.y / unknown_scales(robot))))
    assert lacks[1] < lacks[0] / 6.5
    assert lacks[0] < 1e-3


def test_inverse_follows_the_branch(case):
    """`(1 + T) M` is the inverse Jacobian at a varied equilibrium, to second order."""
    robot, selection, nominal, expansion = case
    equations = held_equations(robot, selection, nominal.y, 10)
    errors = []
    for share in (0.02, 0.01):
        step = share * jnp.asarray(nominal.delta)
        y = expansion.y + expansion.first @ step + 0.5 * (expansion.second @ step) @ step
        jacobian = jax.jacfwd(equations)(y, expansion.rho + step)
        turn = jnp.tensordot(step, expansion.turn, axes=1)
        product = (jnp.eye(y.size) + turn) @ expansion.inverse @ jacobian
        errors.append(np.max(np.abs(product - np.eye(y.size))))
    assert errors[0] < 1e-2
    assert errors[1] < errors[0] / 3.5


def test_weights_balance(case):
    _, _, nominal, expansion = case
    matrix = np.tensordot(np.asarray(nominal.delta), np.abs(expansion.turn), axes=1)
    weights = np.asarray(expansion.weights)
    assert np.all(weights > 0.0)
    norm = np.max(matrix @ weights / weights)
    radius = np.max(np.abs(np.linalg.eigvals(matrix)))
    assert radius <= norm * (1 + 1e-9)
    assert norm < 1.5 * radius
    assert norm < np.max(np.sum(matrix, axis=1))
