"""A batch under `vmap` equals a Python loop of single solves."""

import jax
import jax.numpy as jnp
import numpy as np

from cpr_jax.statics.equilibrium import solve_inverse
from cpr_jax.statics.status import Status
from tests.statics.common import LANES, with_stiffness


def test_a_batch_equals_a_python_loop(paper, batch):
    rng = np.random.default_rng(0)
    points = rng.uniform([-0.1, 0.1], [0.1, 0.26], (LANES, 2))
    k_b = 0.0183 * rng.uniform(0.7, 1.3, (LANES, 2))
    equilibria, _ = batch(k_b, points)
    for k in range(12):
        single = solve_inverse(with_stiffness(paper, jnp.asarray(k_b[k])), points[k])
        lane = jax.tree.map(lambda leaf, k=k: leaf[k], equilibria)
        assert int(lane.status) == int(single.status) == Status.SOLVED
        np.testing.assert_allclose(lane.y, single.y, rtol=0, atol=1e-10)
        for a, b in zip(*map(jax.tree.leaves, (lane.measures, single.measures)), strict=True):
            # An estimated error is a difference of tips, each of which is known to rounding.
            np.testing.assert_allclose(a, b, rtol=1e-7, atol=1e-12)
