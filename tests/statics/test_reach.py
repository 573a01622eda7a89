"""What legs can reach, by geometry written down again."""

import numpy as np
from scipy.spatial.transform import Rotation

from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.robots.catalogue_space import three_rfs
from cpr_jax.statics.reach import out_of_reach, reaches


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
