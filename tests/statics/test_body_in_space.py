"""A robot with a rigid platform: against shooting in the plane, and in the plane of space."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.robots.embedding import in_space
from cpr_jax.statics.problem import Problem, forward_rows
from cpr_jax.statics.residual import residual
from cpr_jax.statics.roots import find_root
from cpr_jax.statics.status import Status
from cpr_jax.statics.unknowns import State, ravel, unravel
from tests.oracles import planar_shooting
from tests.oracles.planar_shooting import PlanarRobot
from tests.statics.common import in_space_unknowns


@pytest.fixture(scope="module")
def robot():
    """The 3-RFR under a load with a moment."""
    return dataclasses.replace(three_rfr(), f_P=jnp.array([0.2, -0.5]), m_P=jnp.array([0.02]))


@pytest.fixture(scope="module")
def planar(robot):
    """An equilibrium in the plane, by Newton's method from rods at rest, load by load."""
    q_a = robot.home.q_a + jnp.array([0.05, -0.02, 0.03])

    @jax.jit
    def root(load, guess):
        loaded = dataclasses.replace(robot, f_P=load * robot.f_P, m_P=load * robot.m_P)
        target = jnp.concatenate([q_a, jnp.zeros(3)])
        return find_root(Problem(loaded, forward_rows(loaded), target), guess)

    y = ravel(State(q_a, robot.home.q_p, jnp.zeros((3, 3))))
    for load in (0.0, 0.5, 1.0):
        found = root(load, y)
        assert int(found.status) == Status.SOLVED
        y = found.y
    return y


def test_the_planar_equilibrium_holds_in_the_shooting_model(robot, planar):
    """Pivots coincide and carry no moment; forces and moments balance about the platform."""
    y = np.asarray(planar)
    rod = PlanarRobot(a=(0.0, 0.0), b=(0.0, 0.0), d=0.0, curvature=(2.0, 2.0))
    turn = np.array([[np.cos(y[5]), -np.sin(y[5])], [np.sin(y[5]), np.cos(y[5])]])
    force, moment = np.asarray(robot.f_P), float(robot.m_P[0])
    for i in range(3):
        tip = planar_shooting.leg_tip(rod, 0, y[i], y[6 + 3 * i : 9 + 3 * i])
        arm = turn @ np.asarray(robot.legs.attachment_position[i])
        pivot = np.asarray(robot.legs.base_position[i]) + tip.pivot
        np.testing.assert_allclose(pivot, y[3:5] + arm, rtol=0, atol=1e-10)
        assert tip.moment == pytest.approx(0.0, abs=1e-10)
        force = force - tip.force
        moment -= arm[0] * tip.force[1] - arm[1] * tip.force[0]
    np.testing.assert_allclose(force, 0.0, rtol=0, atol=1e-9)
    assert moment == pytest.approx(0.0, abs=1e-10)


@pytest.fixture(scope="module")
def spatial(robot):
    return in_space(robot)


@pytest.fixture(scope="module")
def expected(spatial, planar):
    return in_space_unknowns(spatial, planar)


def test_the_planar_equilibrium_is_one_in_space(spatial, expected):
    rows = jax.jit(lambda y: residual(spatial, unravel(spatial, y)))(expected)
    assert rows.shape == (6 + 18,)
    np.testing.assert_allclose(rows, 0.0, rtol=0, atol=1e-9)


@pytest.fixture(scope="module")
def root(spatial):
    """Three imposed coordinates of nine, from a guess."""

    @jax.jit
    def find(imposed, target, guess):
        return find_root(Problem(spatial, imposed, target), guess)

    return find


def nudged(y):
    return y + 3e-3 * jnp.asarray(np.random.default_rng(0).normal(size=y.size))


def test_forward_problem(root, spatial, expected):
    found = root(forward_rows(spatial), expected[:9], nudged(expected))
    assert int(found.status) == Status.SOLVED
    np.testing.assert_allclose(found.y, expected, rtol=0, atol=1e-9)


def test_inverse_problem_in_the_coordinates_of_the_plane(root, expected):
    """Three motors impose three of the six coordinates: y, z and the angle about x."""
    imposed = jnp.zeros((3, 9)).at[jnp.arange(3), jnp.array([4, 5, 6])].set(1.0)
    found = root(imposed, expected[:9], nudged(expected))
    assert int(found.status) == Status.SOLVED
    np.testing.assert_allclose(found.y, expected, rtol=0, atol=1e-9)
