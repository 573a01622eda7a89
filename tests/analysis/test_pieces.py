"""Rods in pieces, beside their shape in one piece."""

import jax
import jax.numpy as jnp
import numpy as np

from cpr_jax.analysis.pieces import rods_in_pieces
from cpr_jax.robots.catalogue_space import three_rfs
from cpr_jax.rods.integration import rod_shape
from cpr_jax.statics.residual import leg_base, to_world
from cpr_jax.statics.unknowns import unknown_scales, unravel

STEPS = 10
RNG = np.random.default_rng(0)


def test_ends_of_pieces_lie_on_the_rods():
    robot = three_rfs()
    assert robot.home is not None
    y = jnp.asarray(0.3 * RNG.normal(size=robot.n_y)) * unknown_scales(robot)
    state = unravel(robot, y)
    nodes = rods_in_pieces(robot, y, STEPS).nodes
    for i in range(robot.n):
        base = leg_base(robot.geometry, robot.leg(i), state.q_a[i], state.mu[i])
        shape = rod_shape(robot.geometry, base.rod, base.force, base.moment, STEPS)
        whole = jax.vmap(lambda s, base=base: to_world(robot.geometry, base, s))(shape)
        for found, expected in zip(nodes, whole, strict=True):
            scale = np.max(np.abs(expected))
            np.testing.assert_allclose(found[i], expected, rtol=0, atol=1e-10 * scale)
