"""Derivatives from the pieces of rods, beside those of the whole residual."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.analysis.jacobian import linearised, names_that_vary
from cpr_jax.analysis.parameters import select
from cpr_jax.analysis.pieces import rods_in_pieces
from cpr_jax.geometry import PLANE
from cpr_jax.robots.catalogue import rfrfr, three_pfr
from cpr_jax.robots.catalogue_space import three_rfs
from cpr_jax.statics.residual import residual
from cpr_jax.statics.unknowns import unknown_scales, unravel
from tests.statics.random_robots import KINDS, random_robot
from tests.statics.segmented import stepped

STEPS = 10
RNG = np.random.default_rng(0)


NUMBERS = (
    "legs.rod.length[0]",
    "legs.rod.curvature_compliance[1, 0]",
    "legs.rod.precurvature[0, 0]",
    "legs.a[0, 0]",
    "legs.b[1, 1]",
    "legs.base_position[0, 1]",
    "legs.base_rotation[1, 0]",
    "legs.attachment_rotation[0, 0]",
    "transmission[1, 0]",
    "f_P[0]",
)
"""Of rods and of everything else that moves their ends or loads the platform."""


def beside_automatic(robot, labels=NUMBERS):
    """Derivatives by the unknowns and by some numbers, where no equilibrium need be."""
    y = jnp.asarray(0.3 * RNG.normal(size=robot.n_y))
    units, selection = unknown_scales(robot), select(robot, labels)

    def whole(scaled, rho):
        return residual(selection.set(robot, rho), unravel(robot, scaled * units), STEPS)

    @jax.jit
    def derivatives(y, rho):
        names = names_that_vary(robot, selection)
        pieces = rods_in_pieces(robot, y * units, STEPS, names)
        found = linearised(robot, y * units, selection, pieces)
        return found, jax.jacfwd(whole, argnums=(0, 1))(y, rho)

    found, expected = derivatives(y, selection.get(robot))
    for a, b in zip(found, expected, strict=True):
        size = np.maximum(np.max(np.abs(b), axis=0), 1e-6 * np.max(np.abs(b)))
        # Both are exact but for the error of the integration, here some 1e-11.
        np.testing.assert_allclose(a / size, b / size, rtol=0, atol=1e-9)


@pytest.mark.parametrize("make", [rfrfr, three_pfr, three_rfs])
def test_robots_of_the_catalogue(make):
    beside_automatic(make())


@pytest.mark.parametrize("kind", KINDS)
def test_robots_at_random(kind):
    """All kinds of motors and joints, rods that stretch, weight, and loads on the platform."""
    geometry, legs = kind
    robot = random_robot(RNG, geometry, legs)
    couples = jnp.asarray(0.05 * RNG.normal(size=(legs, geometry.r)))
    robot = eqx.tree_at(lambda r: r.legs.rod.moment, robot, couples, is_leaf=lambda x: x is None)
    further = (
        "legs.rod.strain_compliance[0, 1]",
        "legs.rod.force[1, 0]",
        "legs.rod.moment[0, 0]",
        "loads.force[0, 0]",
        "loads.position[0, 1]",
    )
    beside_automatic(robot, NUMBERS + further)


def test_segments_of_which_the_first_is_fed():
    robot = stepped(random_robot(RNG, PLANE, 2), [[0.3, 0.7], [0.6, 0.4]])
    assert robot.legs.feed is not None
    legs = dataclasses.replace(robot.legs, feed=jnp.array([1.0, -0.5]))
    further = (
        "legs.rod.further.length[0, 0]",
        "legs.rod.further.precurvature[1, 0, 0]",
        "legs.rod.further.force[1, 0, 1]",
    )
    beside_automatic(dataclasses.replace(robot, legs=legs), NUMBERS + further)


def test_only_numbers_of_rods_that_vary_cost_tangents():
    robot = rfrfr()
    for labels, expected in (
        (("k_b1", "l2", "a1"), {"curvature_compliance", "length"}),
        (("b1", "base1_y", "f_P_y"), set()),
    ):
        assert set(names_that_vary(robot, select(robot, labels))) == expected
