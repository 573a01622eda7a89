"""A planar robot in the yz-plane of space behaves as it does in the plane."""

import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.robots.embedding import in_space
from cpr_jax.statics.solve import solve_forward
from cpr_jax.statics.status import Status
from tests.oracles import planar_shooting
from tests.statics.common import in_space_unknowns


@pytest.fixture(scope="module")
def spatial(paper):
    return in_space(paper)


@pytest.fixture(scope="module")
def planar():
    """The oracle's equilibrium, without mirror symmetry."""
    q = np.array([2.55, 0.30])
    guess = [*q, 0.02, 0.19, 2.6, 0.5, -0.4, -2.6, 0.5, 0.4]
    return planar_shooting.forward(planar_shooting.PlanarRobot(), q, np.array(guess))


@pytest.fixture(scope="module")
def solved(spatial, planar):
    return solve_forward(spatial, planar[:2])


def test_forward_problem_of_the_paper_s_robot(solved, spatial, planar):
    assert int(solved.status) == Status.SOLVED
    np.testing.assert_allclose(
        solved.y, in_space_unknowns(spatial, jnp.asarray(planar)), rtol=0, atol=1e-9
    )


def test_energy_and_torques(solved, paper, planar):
    """The motors do the work that the planar motors do."""
    oracle = planar_shooting.PlanarRobot()
    for leg in range(2):
        n, m = planar[4 + 3 * leg : 6 + 3 * leg], planar[6 + 3 * leg]
        arm = oracle.a[leg] * np.array([np.cos(planar[leg]), np.sin(planar[leg])])
        torque = -(m + arm[0] * n[1] - arm[1] * n[0])
        assert float(solved.motor_torques[leg]) == pytest.approx(torque, abs=1e-9)
    assert float(solved.measures.sigma_t2) > 0.0
    assert np.isnan(solved.measures.sigma_t1), "two motors cannot hold a point in space"
