"""Motors that slide and that feed rod, on legs that stretch, shear and carry weight."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select
from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE
from cpr_jax.robots.joint import clamped
from cpr_jax.robots.leg import make_leg, revolute_screw
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import Rod, kirchhoff_rod
from cpr_jax.statics.correction import linearised
from cpr_jax.statics.measures import measure
from cpr_jax.statics.problem import Problem, forward_rows
from cpr_jax.statics.roots import find_root
from cpr_jax.statics.solve import solve_forward
from cpr_jax.statics.status import Status
from cpr_jax.statics.unknowns import State, ravel

WEIGHT = jnp.array([0.1, -0.4])


def rod(length, rest):
    """A rod in which every effect has a share of the energy."""
    return Rod(
        length=jnp.asarray(length),
        curvature_compliance=jnp.array([1.0 / 0.05]),
        precurvature=jnp.array([rest]),
        strain_compliance=jnp.array([0.02, 0.03]),
        force=WEIGHT,
        moment=jnp.zeros(1),
    )


@pytest.fixture(scope="module")
def robot():
    """A body on three legs: one slides askew, one feeds rod, one turns and feeds."""
    slides = jnp.array([0.8, 0.6, 0.0])
    still = jnp.zeros(3)
    platform = [(-0.05, 0.0), (0.05, 0.0), (0.0, 0.05)]
    legs = [
        make_leg(PLANE, (-0.2, 0.1), rod(0.4, 0.5), screw=slides, a=0.02, b=0.03, feed=0.0),
        make_leg(PLANE, (0.2, -0.1), rod(0.5, -0.5), screw=still, joint=clamped(PLANE), feed=1.0),
        make_leg(PLANE, (0.4, 0.3), rod(0.45, 0.3), a=0.02, screw=revolute_screw(PLANE), feed=0.2),
    ]
    turned = [0.7, 1.9, 3.0]
    legs = [
        dataclasses.replace(
            leg,
            base_rotation=jnp.array([angle]),
            attachment_position=jnp.array(place),
            attachment_rotation=jnp.array([1.9]),
        )
        for leg, angle, place in zip(legs, turned, platform, strict=True)
    ]
    return make_robot(PLANE, legs, oriented=True, f_P=(0.1, -0.2), m_P=[0.01])


@pytest.fixture(scope="module")
def solve(robot):
    """Motors held: unknowns, measures and status, from a guess, under a share of the weight."""

    @jax.jit
    def run(q_a, guess, share, transmission):
        loaded = eqx.tree_at(
            lambda r: (r.legs.rod.force, r.transmission),
            robot,
            (share * robot.legs.rod.force, transmission),
        )
        target = jnp.concatenate([q_a, jnp.zeros(3)])
        root = find_root(Problem(loaded, forward_rows(robot), target), guess)
        return root.y, measure(loaded, root.y, 10)[0], root.status

    def call(q_a, guess, share=1.0, transmission=None):
        transmission = np.eye(3) if transmission is None else transmission
        return run(jnp.asarray(q_a), guess, share, transmission)

    return call


@pytest.fixture(scope="module")
def start(robot, solve):
    q_a = jnp.array([0.03, 0.05, 0.1])
    guess = ravel(State(q_a, jnp.array([0.1, 0.35, 0.0]), jnp.zeros((3, 3))))
    for share in (0.0, 1.0):
        guess, _, status = solve(q_a, guess, share)
        assert int(status) == Status.SOLVED
    return q_a, guess


@pytest.mark.parametrize("share", [0.0, 1.0], ids=["weightless", "heavy"])
@pytest.mark.parametrize("i", range(3), ids=["slides", "feeds", "turns and feeds"])
def test_motor_torque_is_the_derivative_of_the_energy(solve, start, i, share):
    q_a, guess = start
    y, measures, status = solve(q_a, guess, share)
    assert int(status) == Status.SOLVED
    step = 1e-5 * jnp.eye(3)[i]
    above, below = (solve(q_a + sign * step, y, share)[1].energy for sign in (1.0, -1.0))
    slope = float(above - below) / 2e-5
    assert abs(slope) > 1e-3
    assert float(measures.motor_torques[i]) == pytest.approx(slope, rel=1e-6, abs=1e-8)


def test_a_shared_motor_carries_the_sum_of_its_legs(solve, start):
    """A transmission adds up the torques of what it moves."""
    q_a, guess = start
    y, measures, _ = solve(q_a, guess)
    # The same motion of each leg, by other motors.
    transmission = np.array([[1.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    motors = np.linalg.solve(transmission, q_a)
    found, coupled, status = solve(motors, y, 1.0, transmission)
    assert int(status) == Status.SOLVED
    np.testing.assert_allclose(found[3:], y[3:], rtol=0, atol=1e-10)
    expected = transmission.T @ measures.motor_torques
    np.testing.assert_allclose(coupled.motor_torques, expected, rtol=1e-9)
    assert abs(expected[0] - measures.motor_torques[0]) > 0.1


def test_a_rod_that_is_drawn_in_completely_is_no_solution():
    """The equations have solutions with rods of negative length; a cantilever finds them."""
    fed = kirchhoff_rod(PLANE, 0.2, 0.02, 0.5)
    leg = make_leg(PLANE, (0.0, 0.0), fed, screw=np.zeros(3), feed=1.0, joint=clamped(PLANE))
    home = ((0.0,), (0.2, 0.0, 0.1))
    cantilever = make_robot(PLANE, [leg], oriented=True, f_P=(0.0, 0.01), home=home)
    short = solve_forward(cantilever, [-0.19])
    assert float(short.q_p[0]) == pytest.approx(0.01, abs=1e-6)
    gone = solve_forward(cantilever, [-0.21], throw=False)
    assert int(gone.status) == Status.OUT_OF_REACH
    assert np.all(np.isnan(gone.q_p))


def test_a_motor_that_feeds_turns_nothing_by_itself():
    leg = make_leg(PLANE, (0.0, 0.0), kirchhoff_rod(PLANE, 0.2, 0.02), feed=1.0)
    np.testing.assert_array_equal(leg.screw, 0.0)
    telescopic = make_leg(PLANE, (0.0, 0.0), kirchhoff_rod(PLANE, 0.2, 0.02), stroke=1.0)
    np.testing.assert_array_equal(telescopic.screw, 0.0)
    robot = make_robot(PLANE, [leg, telescopic], oriented=False)
    assert not robot.legs.turns
    with pytest.raises(InputError, match=r"`parameters` must leave out 'legs.screw\[0,2\]'"):
        select(robot, ["legs.screw[0,2]"])
    select(robot, ["legs.screw[0,1]"])


def test_motors_that_turn_nothing_are_spared_its_derivatives(robot):
    """Of legs that only slide and feed, one program leaves out what the other finds to be zero."""
    screw = robot.legs.screw.at[:, 2].set(0.0)
    legs = [dataclasses.replace(robot.leg(i), screw=row, turns=True) for i, row in enumerate(screw)]
    spared = make_robot(PLANE, legs, oriented=True, f_P=robot.f_P, m_P=robot.m_P)
    whole = dataclasses.replace(spared, legs=dataclasses.replace(spared.legs, turns=True))
    assert robot.legs.turns
    assert not spared.legs.turns
    y = jnp.asarray(np.random.default_rng(5).normal(size=spared.n_y) * 0.3)

    def linear(robot):
        return linearised(Problem(robot, forward_rows(robot), jnp.zeros(6)), y, 10)

    for found, expected in zip(linear(spared), linear(whole), strict=True):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_a_screw_that_turns_after_all_is_refused():
    robot = eqx.tree_at(lambda r: r.legs.screw, cpr.three_pfr(), jnp.ones((3, 3)))
    with pytest.raises(InputError, match=r"legs\.turns"):
        solve_forward(robot, np.zeros(3))
