"""Rotation vectors of one orientation."""

import numpy as np
import pytest

from cpr_jax.robots.catalogue_space import six_rus
from cpr_jax.statics.nearest import nearest_turn


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.0, 0.0, 1e-9), (0.0, 0.0, -1e-9)])
def test_no_turn_is_a_whole_one_for_who_has_turned_that_far(turn):
    robot = six_rus()
    target = np.concatenate([np.zeros(robot.n_a + 3), turn])
    start = np.array([0.0, 0.0, 0.3, 0.0, 0.0, 1.9 * np.pi])
    found = nearest_turn(robot, target, start)[-3:]
    np.testing.assert_allclose(found, [0.0, 0.0, 2.0 * np.pi], atol=2e-9)
    start[-1] = 0.0
    np.testing.assert_allclose(nearest_turn(robot, target, start)[-3:], turn, atol=0)
