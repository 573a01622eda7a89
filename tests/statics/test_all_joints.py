"""Robots with every kind of joint and motor, held against an independent residual."""

import numpy as np
import pytest

from tests.oracles.whole_robot import unbalanced
from tests.statics.random_robots import KINDS, solved_robots


@pytest.fixture(scope="module", params=KINDS)
def solved(request):
    return solved_robots(*request.param)


def test_what_is_called_solved_is_balanced(solved):
    """Integrated by scipy, with joints written down by themselves."""
    assert len(solved) >= 4
    for robot, equilibrium in solved:
        assert unbalanced(robot, equilibrium.y) < 1e-8


def test_the_oracle_sees_a_joint_that_is_not_met(solved):
    for robot, equilibrium in solved[:2]:
        moved = np.asarray(equilibrium.y).copy()
        moved[robot.n_a] += 1e-4
        assert unbalanced(robot, moved) > 1e-5
