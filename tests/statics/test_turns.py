"""Small rotations per change of a rotation vector, beside scipy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cpr_jax.robots.catalogue import rfrfr, three_rfr
from cpr_jax.robots.catalogue_space import stewart_gough
from cpr_jax.statics.turns import coordinate_jacobian, has_rotation_vector, motion_jacobian


@pytest.mark.parametrize("angle", [0.0, 1e-3, 0.0999, 0.1001, 1.0, 3.0, 6.0])
def test_a_body_in_space(angle):
    robot = stewart_gough()
    vector = angle * np.array([0.48, -0.6, 0.64])
    q_p = np.array([0.1, 0.2, 0.3, *vector])
    found = np.asarray(motion_jacobian(robot, q_p))
    np.testing.assert_allclose(found[:3], np.eye(6)[:3], atol=0)
    np.testing.assert_allclose(found[3:, :3], 0.0, atol=0)
    back, step = Rotation.from_rotvec(vector).inv(), 1e-5
    for k, way in enumerate(step * np.eye(3)):
        ahead, behind = (Rotation.from_rotvec(vector + s * way) * back for s in (1.0, -1.0))
        turn = (ahead.as_rotvec() - behind.as_rotvec()) / (2.0 * step)
        np.testing.assert_allclose(found[3:, 3 + k], turn, rtol=0, atol=1e-9)
    # Across the vector changes turn the less the longer it is.
    smallest = np.sinc(angle / (2.0 * np.pi))
    assert np.linalg.svd(found[3:, 3:])[1][-1] == pytest.approx(smallest, rel=1e-9)
    np.testing.assert_allclose(found @ coordinate_jacobian(robot, q_p), np.eye(6), atol=1e-13)


def test_it_is_the_identity_without_rotation_vectors():
    assert has_rotation_vector(stewart_gough())
    for robot in (rfrfr(), three_rfr()):
        assert not has_rotation_vector(robot)
        for jacobian in (motion_jacobian, coordinate_jacobian):
            found = jacobian(robot, np.asarray(robot.home.q_p) + 0.3)
            np.testing.assert_allclose(found, np.eye(robot.n_p), atol=0)
