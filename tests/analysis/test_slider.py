"""A body on a joint that slides: every part is conservative, so the stiffness is symmetric."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from cpr_jax.analysis.sensitivity import sensitivity
from cpr_jax.analysis.stability import stability
from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.statics.solve import solve_forward
from cpr_jax.statics.status import Status


def test_stiffness_of_a_platform_on_a_slider_is_symmetric():
    robot = three_rfr()
    free = jnp.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    robot = eqx.tree_at(lambda r: r.legs.joint.free, robot, free)
    equilibrium = solve_forward(robot, robot.home.q_a)
    assert int(equilibrium.status) == Status.SOLVED
    found = np.asarray(sensitivity(robot, equilibrium).platform_stiffness)
    size = np.max(np.abs(found))
    np.testing.assert_allclose(found, found.T, rtol=0, atol=1e-9 * size)
    independent = stability(robot, equilibrium).platform_stiffness
    np.testing.assert_allclose(found, independent, rtol=0, atol=1e-8 * size)
