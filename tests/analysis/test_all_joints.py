"""The stiffness of robots with every kind of joint and motor, from two derivations."""

import numpy as np
import pytest

from cpr_jax.analysis.sensitivity import sensitivity
from cpr_jax.analysis.stability import stability
from tests.statics.random_robots import KINDS, solved_robots


@pytest.mark.parametrize("kind", KINDS)
def test_two_ways_to_the_stiffness_agree(kind):
    """From the residual by elimination, and from the second variation of the energy."""
    solved = solved_robots(*kind)
    assert any(np.any(np.asarray(robot.legs.base_joint.free)) for robot, _ in solved)
    for robot, equilibrium in solved:
        by_rows = sensitivity(robot, equilibrium, ["l1"], {"l1": 1e-3}).platform_stiffness
        by_rows = np.asarray(by_rows)
        by_energy = np.asarray(stability(robot, equilibrium).platform_stiffness)
        size = np.sqrt(np.abs(np.diag(by_energy)))
        size = np.outer(size, size) + 1e-6 * np.max(size) ** 2
        np.testing.assert_allclose(by_rows / size, by_energy / size, rtol=0, atol=1e-6)
        np.testing.assert_allclose(by_energy / size, by_energy.T / size, rtol=0, atol=1e-8)
