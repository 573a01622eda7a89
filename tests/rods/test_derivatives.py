"""First derivatives of a rod's tip in all of its numbers: both modes, differences, batches."""

import dataclasses

import jax
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

from cpr_jax.geometry import PLANE
from cpr_jax.rods.integration import rod_energy, rod_shape, rod_tip
from tests.rods.common import differences, tip_of


@pytest.fixture(scope="module")
def subject(geometry):
    return tip_of(geometry)


@pytest.fixture(scope="module")
def planar():
    return tip_of(PLANE)


@pytest.fixture(scope="module")
def jacobian(subject):
    return np.asarray(subject.jacobian(subject.x))


def test_forward_mode_in_every_number(subject, jacobian):
    expected = differences(subject.value, subject.x, 1e-3)
    np.testing.assert_allclose(jacobian, expected, rtol=0, atol=1e-10)
    # Nothing that was perturbed is without an effect.
    assert np.all(np.max(np.abs(jacobian), axis=0) > 1e-4)


def test_reverse_mode_equals_forward_mode(subject, jacobian):
    reverse = jax.jit(jax.jacrev(subject))(subject.x)
    np.testing.assert_allclose(reverse, jacobian, rtol=0, atol=1e-12)


def test_one_number_at_a_time(planar):
    """Leaving the other leaves unperturbed takes another path through the integration."""
    rod, force, moment = planar.unravel(planar.x)

    def tip(length, last):
        changed = dataclasses.replace(rod, length=length)
        return ravel_pytree(rod_tip(PLANE, changed, force, moment.at[-1].set(last)))[0]

    expected = planar.jacobian(planar.x)
    slope = jax.jit(jax.jacfwd(tip, argnums=1))(rod.length, moment[-1])
    np.testing.assert_allclose(slope, expected[:, -1], rtol=0, atol=1e-13)


def test_derivatives_in_a_batch(planar):
    """Each lane of a batch gets the derivative that it gets alone."""
    xs = planar.x + np.random.default_rng(7).normal(size=(3, planar.x.size)) * 0.05
    batch = jax.jit(jax.vmap(jax.jacfwd(planar)))(xs)
    for x, slope in zip(xs, batch, strict=True):
        np.testing.assert_allclose(slope, planar.jacobian(x), rtol=0, atol=1e-13)


def test_derivatives_of_shape_and_energy(planar):
    rod, force, moment = planar.unravel(planar.x)

    def everything(length):
        changed = dataclasses.replace(rod, length=length)
        shape = rod_shape(PLANE, changed, force, moment)
        return shape.position, rod_energy(PLANE, changed, force, moment)

    value = jax.jit(everything)
    slope = jax.jit(jax.jacfwd(everything))(rod.length)
    step = 1e-4
    above, below = value(rod.length + step), value(rod.length - step)
    for found, high, low in zip(*map(jax.tree.leaves, (slope, above, below)), strict=True):
        np.testing.assert_allclose(found, (high - low) / (2.0 * step), rtol=0, atol=1e-7)
