"""More motors than imposed coordinates: the criterion is least, bad numbers are refused."""

import jax
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.statics.status import SolveError, Status

TARGET = (0.01, 0.02)


@pytest.fixture(scope="module")
def robot():
    return cpr.three_rfr()


@pytest.fixture(scope="module")
def least(robot):
    return cpr.resolve_redundancy(robot, TARGET, imposed=("y", "z"), criterion="motion")


def test_the_target_is_met(robot, least):
    assert int(least.status) == Status.SOLVED
    np.testing.assert_allclose(least.q_p[:2], TARGET, rtol=0, atol=1e-9)
    back = cpr.solve_inverse(robot, least.q_p, guess=least)
    np.testing.assert_allclose(back.q_a, least.q_a, rtol=0, atol=1e-8)


def test_any_other_orientation_takes_longer_ways(robot, least):
    begin = np.asarray(cpr.solve_forward(robot, robot.home.q_a).q_a)

    def distance(equilibrium):
        return float(np.sum((np.asarray(equilibrium.q_a) - begin) ** 2))

    best = distance(least)
    for aside in (-0.1, -0.01, 0.01, 0.1):
        pose = np.asarray(least.q_p) + np.array([0.0, 0.0, aside])
        assert distance(cpr.solve_inverse(robot, pose, guess=least)) > best


def test_what_does_not_fit_is_refused(robot):
    with pytest.raises(ValueError, match="`criterion` must be"):
        cpr.resolve_redundancy(robot, TARGET, imposed=("y", "z"), criterion="speed")
    with pytest.raises(ValueError, match="`imposed` must name different platform"):
        cpr.resolve_redundancy(robot, (0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="`point` must be 2"):
        cpr.resolve_redundancy(robot, (0.0,), imposed=("y", "z"))
    with pytest.raises(ValueError, match="it names 'w'"):
        cpr.resolve_redundancy(robot, (0.0,), imposed=("w",))
    with pytest.raises(ValueError, match="`imposed` must be a sequence"):
        cpr.resolve_redundancy(robot, TARGET, imposed="yz")
    with pytest.raises(ValueError, match="`imposed` must name different"):
        cpr.resolve_redundancy(robot, TARGET, imposed=("y", "y"))
    with pytest.raises(ValueError, match="`imposed` must name different"):
        cpr.resolve_redundancy(robot, (), imposed=())
    with pytest.raises(ValueError, match="`point` must be 2 finite"):
        cpr.resolve_redundancy(robot, (np.nan, 0.0), imposed=("y", "z"))
    failed = cpr.solve_forward(robot, np.full(3, 9.0), throw=False)
    with pytest.raises(ValueError, match="`guess` must be solved"):
        cpr.resolve_redundancy(robot, TARGET, imposed=("y", "z"), guess=failed)
    with pytest.raises(ValueError, match="`point` must be numbers"):
        jax.jit(lambda point: cpr.resolve_redundancy(robot, point, imposed=("y", "z")).q_a)(TARGET)


def test_a_point_that_no_leg_reaches(robot):
    with pytest.raises(SolveError, match="reach") as caught:
        cpr.resolve_redundancy(robot, (5.0, 0.0), imposed=("y", "z"))
    assert caught.value.status == Status.OUT_OF_REACH


def test_names_of_an_inverse_problem(robot):
    """Mixtures of motors and platform coordinates; their number is that of the motors."""
    home = cpr.solve_forward(robot, robot.home.q_a)
    values = (float(home.q_a[0]) + 0.05, 0.0, 0.01)
    found = cpr.solve_inverse(robot, values, imposed=("q1", "y", "p_P_z"))
    mixed = (found.q_a[0], found.q_p[0], found.q_p[1])
    np.testing.assert_allclose(mixed, values, rtol=0, atol=1e-10)
    with pytest.raises(ValueError, match="must name 3 different coordinates"):
        cpr.solve_inverse(robot, (0.0, 0.0), imposed=("y", "z"))
    with pytest.raises(ValueError, match="must name 3 different coordinates"):
        cpr.solve_inverse(robot, (0.0, 0.0, 0.0), imposed=("y", "y", "z"))
