"""Many ways along a branch, by both compilations of the same step."""

import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.statics.problem import inverse_rows
from cpr_jax.statics.status import Status
from cpr_jax.statics.unknowns import unknown_scales
from cpr_jax.studies.follower import Follower

AXES = (2, 3)
POINTS = np.array([[0.02, 0.21], [0.1, 0.15], [0.05, 0.05], [0.0, 0.5]])


@pytest.fixture(scope="module")
def start():
    robot = cpr.rfrfr()
    seed = cpr.solve_inverse(robot, (0.0, 0.2))
    y = np.tile(np.asarray(seed.y) / np.asarray(unknown_scales(robot)), (len(POINTS), 1))
    begin = np.tile(np.concatenate([seed.q_a, seed.q_p]), (len(POINTS), 1))
    goal = begin.copy()
    goal[:, 2:] = POINTS
    return robot, y, begin, goal


@pytest.mark.parametrize("many", [False, True])
def test_ways_end_where_single_solves_do(start, many):
    robot, y, begin, goal = start
    follower = Follower(robot, inverse_rows(robot), AXES, 10, many)
    follower.compile()
    found = follower.creep(y, begin, goal)
    # The last point is beyond the reach of the legs: its way ends at a fold.
    np.testing.assert_array_equal(found.status, [Status.SOLVED] * 3 + [Status.LOST])
    for k, point in enumerate(POINTS[:3]):
        single = cpr.solve_inverse(robot, point)
        ends, units = np.asarray(found.y[k]), np.asarray(unknown_scales(robot))
        np.testing.assert_allclose(ends, single.y / units, rtol=0, atol=1e-9)
