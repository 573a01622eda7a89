"""Robots with rods of several segments, solved."""

import dataclasses
import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.geometry import PLANE
from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.robots.embedding import in_space
from cpr_jax.robots.joint import clamped
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.rods.segments import segmented_rod
from cpr_jax.statics.shape import shape
from cpr_jax.statics.solve import solve_forward, solve_inverse
from cpr_jax.statics.status import Status
from tests.oracles.whole_robot import unbalanced
from tests.statics.common import in_space_unknowns, torques_are_slopes_of_the_energy
from tests.statics.random_robots import random_robot
from tests.statics.segmented import cut, stepped, with_rods

SHARES = [(1.0,), (0.6, 0.4), (0.2, 0.5, 0.3)]


@pytest.fixture(scope="module")
def triangle():
    """A planar robot with legs of one, two and three segments, and an equilibrium."""
    robot = stepped(three_rfr(), SHARES)
    return robot, solve_forward(robot, robot.home.q_a + np.array([0.1, -0.05, 0.02]))


def test_rods_cut_into_segments_make_the_same_robot():
    robot = three_rfr()
    same = cut(robot, SHARES)
    a, b = (solve_forward(r, robot.home.q_a + 0.1) for r in (robot, same))
    np.testing.assert_allclose(b.y, a.y, rtol=0, atol=1e-10)
    np.testing.assert_allclose(b.motor_torques, a.motor_torques, rtol=0, atol=1e-11)
    for name in ("energy", "bows", "sigma_t1", "sigma_t2"):
        x, y = getattr(b.measures, name), getattr(a.measures, name)
        np.testing.assert_allclose(x, y, rtol=1e-10)


def test_balance_of_the_triangle(triangle):
    robot, solved = triangle
    assert unbalanced(robot, solved.y) < 1e-9
    assert unbalanced(three_rfr(), solved.y) > 1e-2


def test_inverse_problem(triangle):
    robot, forward = triangle
    inverse = solve_inverse(robot, forward.q_p)
    np.testing.assert_allclose(inverse.y, forward.y, rtol=0, atol=1e-8)


def test_random_robots():
    """All motors and joints; rods of up to three segments that stretch and shear, with weight.

    Those in space are among the robots with all joints.
    """
    rng = np.random.default_rng(5)
    shares = [(0.3, 0.3, 0.4), (0.7, 0.3)]
    solved = 0
    for seed in range(6):
        robot = stepped(random_robot(rng, PLANE, 2), shares, seed, 0.4)
        found = solve_forward(robot, np.zeros(2), throw=False)
        if int(found.status) == Status.SOLVED:
            assert unbalanced(robot, found.y) < 1e-8
            solved += 1
    assert solved >= 3


def test_torques_are_the_derivative_of_the_energy(triangle):
    """Weights differ from segment to segment, which the potential of the loads must know."""
    robot, solved = triangle
    torques_are_slopes_of_the_energy(robot, solved, solved)


def test_embedded_in_space(triangle):
    robot, solved = triangle
    plain = cut(three_rfr(), SHARES)
    spatial, loaded = in_space(plain), in_space(robot)
    np.testing.assert_array_equal(loaded.legs.rod.further.force[..., 0], 0.0)
    assert spatial.legs.rod.further.curvature_compliance.shape == (3, 2, 3)
    found = solve_forward(loaded, robot.home.q_a + np.array([0.1, -0.05, 0.02]))
    expected = in_space_unknowns(loaded, solved.y)
    np.testing.assert_allclose(found.y, expected, rtol=0, atol=1e-9)
    assert float(found.measures.energy) == pytest.approx(float(solved.measures.energy), abs=1e-9)


def test_shape_meets_the_joints(triangle):
    """Equidistant in each segment; a rod with fewer segments stays at its tip."""
    robot, solved = triangle
    drawn = shape(robot, solved, points=5)
    length = 0.25
    assert drawn.s.shape == (3, 13)
    quarters = np.linspace(0.0, 1.0, 5)[1:]
    begins = np.array([0.0, 0.2, 0.7, 1.0])
    third = [
        0.0,
        *(a + (b - a) * t for a, b in itertools.pairwise(begins) for t in quarters),
    ]
    np.testing.assert_allclose(drawn.s[2], length * np.array(third), rtol=0, atol=1e-15)
    np.testing.assert_allclose(drawn.s[0, 4:], length, rtol=0, atol=1e-15)
    assert np.ptp(np.asarray(drawn.rods.position)[0, 4:], axis=0).max() < 1e-13
    arms = np.exp(1j * float(solved.q_p[2])) * np.asarray(
        robot.legs.attachment_position @ np.array([1.0, 1.0j])
    )
    places = solved.q_p[0] + 1j * solved.q_p[1] + arms
    np.testing.assert_allclose(drawn.joints @ np.array([1.0, 1.0j]), places, rtol=0, atol=1e-10)


@pytest.fixture(scope="module")
def fed():
    """A rod that is fed through its base and whose far half is softer, clamped to a body."""
    rod = segmented_rod([kirchhoff_rod(PLANE, 0.1, 0.05), kirchhoff_rod(PLANE, 0.2, 0.01)])
    leg = make_leg(PLANE, (0.0, 0.0), rod, screw=np.zeros(3), feed=1.0, joint=clamped(PLANE))
    return make_robot(PLANE, [leg], oriented=True, f_P=(0.02, 0.03), home=((0.0,), (0.3, 0.0, 0.0)))


def test_a_fed_rod_grows_in_its_first_segment(fed):
    rods = [kirchhoff_rod(PLANE, 0.15, 0.05), kirchhoff_rod(PLANE, 0.2, 0.01)]
    longer = with_rods(fed, [segmented_rod(rods)])
    by_feed, by_length = solve_forward(fed, [0.05]), solve_forward(longer, [0.0])
    np.testing.assert_allclose(by_feed.y[1:], by_length.y[1:], rtol=0, atol=1e-11)
    step = 1e-4
    above, below = (solve_forward(fed, [0.05 + s]).measures.energy for s in (step, -step))
    slope = (above - below) / (2.0 * step)
    np.testing.assert_allclose(by_feed.motor_torques[0], slope, rtol=1e-6)


def test_a_first_segment_that_is_drawn_in_is_no_solution(fed):
    assert int(solve_forward(fed, [-0.09], throw=False).status) == Status.SOLVED
    assert int(solve_forward(fed, [-0.11], throw=False).status) == Status.OUT_OF_REACH


def test_derivatives_through_a_solve(triangle):
    """Of the platform in the compliances of all further segments, by central differences."""
    robot, solved = triangle

    def platform(compliances):
        further = dataclasses.replace(robot.legs.rod.further, curvature_compliance=compliances)
        rod = dataclasses.replace(robot.legs.rod, further=further)
        changed = dataclasses.replace(robot, legs=dataclasses.replace(robot.legs, rod=rod))
        return solve_forward(changed, solved.q_a, guess=solved).q_p

    nominal = robot.legs.rod.further.curvature_compliance
    direction = jnp.asarray(np.random.default_rng(0).normal(size=nominal.shape)) * nominal
    _, slope = jax.jvp(platform, (nominal,), (direction,))
    step = 1e-4
    above, below = (platform(nominal + sign * step * direction) for sign in (1.0, -1.0))
    expected = (above - below) / (2.0 * step)
    np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-6 * np.max(np.abs(expected)))
