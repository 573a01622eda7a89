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


def test_few_ways_end_as_many_do(start):
    """What fills a batch up changes nothing, nor does a way that leads nowhere beside it."""
    robot, y, begin, goal = start
    follower = Follower(robot, inverse_rows(robot), AXES, 10)
    near = begin.copy()
    near[:, 2:] += 0.001 * (goal - begin)[:, 2:]
    many = follower.advance(*(np.tile(rows, (50, 1)) for rows in (y, near)))
    for count in (1, 3):
        few = follower.advance(y[:count], near[:count])
        for whole, part in zip(many, few, strict=True):
            assert len(part) == count
            np.testing.assert_allclose(part, whole[:count], rtol=1e-12, atol=1e-12)
    assert np.all(many.status == Status.SOLVED)
    # All the way at once is too far.
    far = near[:2].copy()
    far[1] = goal[3]
    mixed = follower.advance(y[:2], far)
    np.testing.assert_array_equal(mixed.status, [Status.SOLVED, Status.NOT_CONVERGED])
    np.testing.assert_allclose(mixed.y[0], many.y[0], rtol=1e-12, atol=1e-12)
