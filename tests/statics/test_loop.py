"""A batch under `vmap` equals a Python loop of single solves."""

import jax
import jax.numpy as jnp
import numpy as np

from cpr_jax.rods.integration import DEFAULT_STEPS
from cpr_jax.statics.solve import solve_inverse
from cpr_jax.statics.status import Status
from tests.statics.common import LANES, with_stiffness


def test_a_batch_equals_a_python_loop(paper, batch):
    rng = np.random.default_rng(0)
    points = rng.uniform([-0.1, 0.1], [0.1, 0.26], (LANES, 2))
    k_b = 0.0183 * rng.uniform(0.7, 1.3, (LANES, 2))
    equilibria, _ = batch(k_b, points)
    for k in range(12):
        # A single solve would choose its own number of steps.
        robot = with_stiffness(paper, jnp.asarray(k_b[k]))
        single = solve_inverse(robot, points[k], steps=DEFAULT_STEPS)
        lane = jax.tree.map(lambda leaf, k=k: leaf[k], equilibria)
        assert int(lane.status) == int(single.status) == Status.SOLVED
        np.testing.assert_allclose(lane.y, single.y, rtol=0, atol=1e-10)
        for name, value in vars(single.measures).items():
            # What an integration leaves is a difference of numbers that are known to rounding.
            atol = 1e-11 if name in ("tip_error", "unbalanced") else 1e-13
            np.testing.assert_allclose(getattr(lane.measures, name), value, rtol=1e-7, atol=atol)
