"""Derivatives from the pieces of rods, beside those of the whole residual."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.analysis.pieces import jacobian, rods_in_pieces
from cpr_jax.geometry import PLANE
from cpr_jax.robots.catalogue import rfrfr, three_pfr
from cpr_jax.robots.catalogue_space import six_rus, three_rfs
from cpr_jax.rods.integration import rod_shape
from cpr_jax.statics.residual import leg_base, residual, to_world
from cpr_jax.statics.unknowns import unknown_scales, unravel
from tests.statics.random_robots import KINDS, random_robot
from tests.statics.segmented import stepped

STEPS = 10
RNG = np.random.default_rng(0)


def beside_automatic(robot):
    """Both derivatives at unknowns that need not be an equilibrium."""
    y = jnp.asarray(0.3 * RNG.normal(size=robot.n_y))
    units = unknown_scales(robot)

    def R_0(scaled):
        return residual(robot, unravel(robot, scaled * units), STEPS)

    @jax.jit
    def both(y):
        found = jacobian(robot, y * units, rods_in_pieces(robot, y * units, STEPS))
        return found, jax.jacfwd(R_0)(y)

    found, expected = both(y)
    # Both are exact but for the error of the integration, here some 1e-11.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.max(np.abs(expected)))


@pytest.mark.parametrize("make", [rfrfr, three_pfr, three_rfs, six_rus])
def test_jacobian_of_robots_of_the_catalogue(make):
    beside_automatic(make())


@pytest.mark.parametrize("kind", KINDS)
def test_jacobian_of_robots_at_random(kind):
    """All kinds of motors and joints, rods that stretch, weight, and loads on the platform."""
    geometry, legs = kind
    beside_automatic(random_robot(RNG, geometry, legs))


def test_jacobian_of_segments_of_which_the_first_is_fed():
    robot = stepped(random_robot(RNG, PLANE, 2), [[0.3, 0.7], [0.6, 0.4]])
    assert robot.legs.feed is not None
    legs = dataclasses.replace(robot.legs, feed=jnp.array([1.0, -0.5]))
    beside_automatic(dataclasses.replace(robot, legs=legs))


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
