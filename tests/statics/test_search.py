"""Robots without a home: a systematic search."""

import dataclasses

import numpy as np
import pytest

from cpr_jax.statics.search import search_starts
from cpr_jax.statics.solve import solve_forward, solve_inverse
from cpr_jax.statics.status import SolveError, Status
from tests.oracles import planar_shooting
from tests.oracles.planar_shooting import PlanarRobot
from tests.statics.common import from_oracle

ROBOTS = [
    PlanarRobot(),
    PlanarRobot(f_P=(0.6, -0.8), k_b=(0.03, 0.015), curvature=(-0.5, 1.4)),
    PlanarRobot(l=(0.3, 0.25), d=0.25, curvature=(0.0, 0.0)),
]


def homeless(robot):
    return dataclasses.replace(robot, home=None)


@pytest.mark.parametrize("oracle", ROBOTS, ids=["table 1", "uneven", "straight"])
def test_what_is_found_is_an_equilibrium(oracle):
    """Every row of the independent residual vanishes, and the point is the one asked for."""
    point = np.array([0.05, 0.15])
    found = solve_inverse(homeless(from_oracle(oracle)), point)
    assert found.branch == "search"
    np.testing.assert_allclose(found.q_p, point, rtol=0, atol=1e-11)
    rows = planar_shooting.residual(oracle, np.asarray(found.y))
    np.testing.assert_allclose(rows, 0.0, rtol=0, atol=1e-9)


def test_motors_are_held_in_the_forward_problem():
    oracle = ROBOTS[1]
    q_a = np.array([2.5, 0.3])
    found = solve_forward(homeless(from_oracle(oracle)), q_a)
    np.testing.assert_allclose(found.q_a, q_a, rtol=0, atol=1e-12)
    rows = planar_shooting.residual(oracle, np.asarray(found.y))
    np.testing.assert_allclose(rows, 0.0, rtol=0, atol=1e-9)


def test_no_known_equilibrium_has_less_energy(paper, published):
    """The equilibria of the outward branch, from the published one."""
    oracle = PlanarRobot()
    for point in ((0.0, 0.2), (-0.05, 0.2)):
        known = planar_shooting.inverse(oracle, point, np.asarray(published))
        found = solve_inverse(homeless(paper), point)
        assert found.measures.energy <= planar_shooting.energy(oracle, known) + 1e-9
        exact = planar_shooting.energy(oracle, np.asarray(found.y))
        np.testing.assert_allclose(found.measures.energy, exact, rtol=1e-9)


def test_nothing_is_found_out_of_reach(paper):
    with pytest.raises(SolveError) as caught:
        solve_inverse(homeless(paper), (0.0, 0.6))
    assert caught.value.status is Status.OUT_OF_REACH


def test_starts_cover_all_angles_and_the_reach_of_the_rods(paper):
    starts = np.asarray(search_starts(paper))
    assert np.all(np.ptp(starts[:, :2], axis=0) > 1.9 * np.pi)
    np.testing.assert_allclose(starts[:, 2:].min(axis=0), -0.25, rtol=0, atol=0.02)
    np.testing.assert_allclose(starts[:, 2:].max(axis=0), 0.25, rtol=0, atol=0.02)
    # A second call must not search elsewhere.
    np.testing.assert_array_equal(search_starts(paper), starts)
