"""The six-leg peer solves the robot that it is compared on."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cpr_jax as cpr
from benchmarks import six_peer
from benchmarks.building import compiler

from ..oracles import stewart_gough as oracle

pytestmark = pytest.mark.skipif(compiler() is None, reason="there is no C++ compiler")

_POSE = np.array([0.01, 0.0, 0.41, 0.0, np.deg2rad(10.0), 0.0])


@pytest.fixture(scope="module")
def tilted():
    """Both algorithms, from an upright platform to a tilted one."""
    robot = cpr.stewart_gough()
    start = cpr.solve_inverse(robot, (0.0, 0.0, 0.4, 0.0, 0.0, 0.0))
    begin = [np.asarray(part) for part in (start.q_a, start.mu, start.q_p)]
    way = np.linspace(0.05, 1.0, 20)[:, None]
    poses = (1.0 - way) * begin[2] + way * _POSE
    return six_peer.make(robot, six_peer.Problem(*begin, poses[None]))


@pytest.mark.parametrize("lean", [False, True], ids=["printed", "lean"])
def test_lengths_are_those_of_another_program(tilted, lean):
    printed, lean_one = tilted
    lengths = lean_one(60, 8) if lean else printed(60, 1e-22, 1e-6)
    expected, _ = oracle.inverse(_POSE[:3], Rotation.from_rotvec(_POSE[3:]).as_matrix())
    np.testing.assert_allclose(lengths[0, -1], expected, rtol=0, atol=1e-8)
