"""Grids keep to a user's box and enclose a workspace of their own."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cpr_jax.robots.catalogue import rfrfr, three_rfr
from cpr_jax.robots.catalogue_space import three_rfs
from cpr_jax.studies.grid import make_grid, out_of_reach, reaches


@pytest.mark.parametrize("spacing", [0.002, 0.003, 0.007])
def test_all_within_reach_is_enclosed(spacing):
    """Both legs reach 0.33 m from (∓0.1, 0): at most to y = ±0.23 and z = ±√(0.33² - 0.1²)."""
    grid = make_grid(rfrfr(), np.zeros(4), spacing, None)
    low, high = grid.box
    assert low[0] <= -0.23 + 1e-12 and high[0] >= 0.23 - 1e-12
    assert low[0] > -0.23 - spacing and high[0] < 0.23 + spacing
    assert high[1] >= np.sqrt(0.33**2 - 0.1**2)
    for line in grid.coordinates:
        np.testing.assert_allclose(line / spacing, np.round(line / spacing), atol=1e-9)


def test_a_box_is_kept_to():
    box = np.array([[-0.0105, 0.1], [0.0305, 0.2]])
    grid = make_grid(rfrfr(), np.zeros(4), 0.01, box)
    np.testing.assert_allclose(grid.box, [[-0.01, 0.1], [0.03, 0.2]], atol=1e-12)
    half = make_grid(rfrfr(), np.zeros(4), 0.01, box, mirror=True)
    assert half.box[0, 0] == 0.0


def test_the_turn_of_a_body_counts():
    """Each leg of the 3-RFR reaches from its motor to its corner of the turned platform."""
    robot = three_rfr()
    q_p = np.array([[0.02, 0.01, -0.2], [0.6, 0.0, 0.0]])
    arms = np.asarray(robot.legs.attachment_position)
    far = []
    for y, z, angle in q_p:
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        ends = np.array([y, z]) + arms @ turn.T
        ways = np.linalg.norm(ends - np.asarray(robot.legs.base_position), axis=1)
        far.append(np.any(ways > reaches(robot)))
    targets = np.pad(q_p, ((0, 0), (3, 0)))
    np.testing.assert_array_equal(out_of_reach(robot, targets, (3, 4, 5)), far)
    assert far == [False, True]
    # A turn that is not imposed may be any.
    np.testing.assert_array_equal(out_of_reach(robot, targets, (0, 3, 4)), [False, True])
    assert not np.any(out_of_reach(robot, targets, (0, 1, 3)))


def test_the_turn_of_a_body_in_space_counts():
    """By scipy's rotations of where the joints of the platform are."""
    robot = three_rfs()
    spread = np.array([0.1, 0.1, 0.1, 1.0, 1.0, 1.0])
    q_p = spread * np.random.default_rng(2).uniform(-1.0, 1.0, (60, 6))
    q_p[:, 2] += 0.25
    arms = np.asarray(robot.legs.attachment_position)
    turned = Rotation.from_rotvec(q_p[:, 3:]).as_matrix() @ arms.T
    ends = q_p[:, None, :3] + turned.swapaxes(1, 2)
    ways = np.linalg.norm(ends - np.asarray(robot.legs.base_position), axis=-1)
    far = np.any(ways > reaches(robot), axis=1)
    assert 10 < np.sum(far) < 50
    targets = np.pad(q_p, ((0, 0), (3, 0)))
    np.testing.assert_array_equal(out_of_reach(robot, targets, range(3, 9)), far)
