"""Batches: a lane gets what it gets alone, whatever happens in the lanes beside it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.problem import Problem, inverse_rows
from cpr_jax.statics.roots import find_root
from cpr_jax.statics.status import Status
from tests.statics.common import LANES, with_stiffness

NAN_POINT, FAR, NAN_STIFFNESS, NO_STIFFNESS, BEYOND_A_FOLD = 10, 20, 30, 40, 50
SICK = [NAN_POINT, FAR, NAN_STIFFNESS, NO_STIFFNESS, BEYOND_A_FOLD]
HEALTHY = np.setdiff1d(np.arange(LANES), SICK)


@pytest.fixture(scope="module")
def healthy():
    rng = np.random.default_rng(0)
    points = rng.uniform([-0.03, 0.17], [0.03, 0.22], (LANES, 2))
    return 0.0183 * rng.uniform(0.8, 1.2, (LANES, 2)), points


@pytest.fixture(scope="module")
def sick(healthy):
    k_b, points = (array.copy() for array in healthy)
    points[NAN_POINT] = np.nan
    points[FAR] = 0.0, 0.6
    k_b[NAN_STIFFNESS, 0] = np.nan
    k_b[NO_STIFFNESS] = 0.0
    points[BEYOND_A_FOLD] = 0.0, 0.32
    return k_b, points


@pytest.fixture(scope="module")
def alone(batch, healthy):
    return batch(*healthy)


@pytest.fixture(scope="module")
def beside(batch, sick):
    return batch(*sick)


def test_all_healthy_lanes_are_solved(alone):
    assert np.all(np.asarray(alone[0].status) == Status.SOLVED)
    assert np.max(alone[0].residual) < 1e-10


def test_gradients_of_lanes_against_differences(batch, alone, healthy):
    """Two batches, shifted in a random direction in each lane, give all lanes' differences."""
    k_b, points = healthy
    _, (by_k, by_point) = alone
    rng = np.random.default_rng(1)
    # Directions in which both kinds of number count.
    along_k, along_point = 0.02 * rng.normal(size=(LANES, 2)), 0.05 * rng.normal(size=(LANES, 2))
    step = 1e-6
    above, below = (
        batch(k_b + sign * step * along_k, points + sign * step * along_point)[0].q_a[:, 0]
        for sign in (1.0, -1.0)
    )
    slope = np.sum(by_k * along_k + by_point * along_point, axis=1)
    scale = np.max(np.abs(slope))
    assert np.max(np.abs(np.sum(by_k * along_k, axis=1))) > 0.05 * scale
    np.testing.assert_allclose(slope, (above - below) / (2.0 * step), rtol=0, atol=1e-7 * scale)


def test_sick_lanes_do_not_touch_healthy_ones(alone, beside):
    """Values, measures and gradients agree to rounding with a batch in which all is well."""
    for a, b in zip(*map(jax.tree.leaves, (alone, beside)), strict=True):
        healthy = np.asarray(a)[HEALTHY]
        scale = np.max(np.abs(healthy))
        np.testing.assert_allclose(np.asarray(b)[HEALTHY], healthy, rtol=1e-12, atol=1e-12 * scale)


def test_sick_lanes_look_like_no_solution(beside):
    equilibrium, _ = beside
    numbers = [
        *(equilibrium.q_a, equilibrium.q_p, equilibrium.mu, equilibrium.residual),
        *jax.tree.leaves(equilibrium.measures),
    ]
    for leaf in numbers:
        assert np.all(np.isnan(np.asarray(leaf)[SICK]))
        assert np.all(np.isfinite(np.asarray(leaf)[HEALTHY]))


def test_sick_lanes_say_what_ails_them(beside):
    status = np.asarray(beside[0].status)
    assert status[FAR] == Status.LOST
    assert status[BEYOND_A_FOLD] == Status.LOST
    assert status[NAN_POINT] == Status.NOT_FINITE
    assert status[NAN_STIFFNESS] == Status.NOT_FINITE
    assert status[NO_STIFFNESS] == Status.NOT_FINITE
    assert np.all(status[SICK] != Status.SOLVED)


def test_gradients_of_sick_lanes_are_no_numbers_to_trust(beside):
    """Zero or NaN: neither looks like a derivative."""
    for gradient in beside[1]:
        sick = np.asarray(gradient)[SICK]
        assert np.all(np.isnan(sick) | (sick == 0.0))


@pytest.fixture(scope="module")
def masked(paper, published):
    """Gradient of a sum over the lanes that solved: the usual way to differentiate a batch."""

    def masked_sum(k_b, points):
        def one(k_b, point):
            robot = with_stiffness(paper, k_b)
            target = jnp.concatenate([jnp.zeros(2), point])
            return find_root(Problem(robot, inverse_rows(robot), target), published)

        roots = jax.vmap(one)(k_b, points)
        solved = roots.status == Status.SOLVED
        return jnp.sum(jnp.where(solved, roots.y[:, 0], 0.0)), roots.status

    return jax.jit(jax.grad(masked_sum, has_aux=True))


def test_gradient_of_a_masked_sum(masked, alone, healthy, sick):
    expected, status = masked(*healthy)
    found, sick_status = masked(*sick)
    assert np.mean(status == Status.SOLVED) > 0.85
    assert np.all(np.asarray(sick_status)[SICK] != Status.SOLVED)
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(found[HEALTHY], expected[HEALTHY], rtol=1e-12, atol=1e-12 * scale)
    assert np.all(np.isfinite(np.asarray(found)[[NAN_POINT, FAR, BEYOND_A_FOLD]]))
    # Lane by lane, it is the gradient of the whole solve.
    solved = np.asarray(status) == Status.SOLVED
    np.testing.assert_allclose(expected[solved], alone[1][0][solved], rtol=1e-7, atol=1e-7 * scale)
