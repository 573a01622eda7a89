"""Random rods with every effect against an independent integration, and what they conserve."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate

from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.rods.integration import rod_energy, rod_shape
from cpr_jax.rods.rod import Rod
from cpr_jax.rods.solver import ExtrapolatedMidpoint
from tests.oracles import cosserat

COUNT, STEPS = 4, 16
WEIGHTS = ExtrapolatedMidpoint().weights[:5]


class Sample:
    """Random rods in bending by up to about three radians, and the same for the oracle."""

    def __init__(self, geometry, loaded):
        rng = np.random.default_rng(3)
        self.geometry = geometry
        d, r = geometry.d, geometry.r
        self.length = rng.uniform(0.5, 1.0, COUNT)
        self.bend = rng.uniform(0.5, 2.0, (COUNT, r))
        self.rest = rng.uniform(-1.5, 1.5, (COUNT, r))
        self.stretch = rng.uniform(0.0, 0.05, (COUNT, d))
        self.load = rng.uniform(-2.0, 2.0, (COUNT, d)) * loaded
        self.couple = rng.uniform(-1.0, 1.0, (COUNT, r)) * loaded
        self.force = rng.uniform(-2.0, 2.0, (COUNT, d))
        self.moment = rng.uniform(-1.0, 1.0, (COUNT, r))
        self.rods = Rod(
            *(jnp.asarray(x) for x in (self.length, self.bend, self.rest, self.stretch)),
            force=jnp.asarray(self.load) if loaded else None,
            moment=jnp.asarray(self.couple) if loaded else None,
        )

    def vector(self, values):
        return np.pad(values, (0, 3 - self.geometry.d))

    def axial(self, values):
        return np.pad(values, (3 - self.geometry.r, 0))

    def oracle(self, k, s=None):
        rod = cosserat.SpatialRod(
            self.length[k],
            self.axial(self.bend[k]),
            self.axial(self.rest[k]),
            self.vector(self.stretch[k]),
            self.vector(self.load[k]),
            self.axial(self.couple[k]),
        )
        return cosserat.integrate(rod, self.vector(self.force[k]), self.axial(self.moment[k]), s)


def batched(function, sample):
    geometry = sample.geometry
    run = jax.jit(jax.vmap(lambda rod, n, m: function(geometry, rod, n, m, STEPS)))
    return run(sample.rods, sample.force, sample.moment)


@pytest.fixture(scope="module")
def loaded(geometry):
    return Sample(geometry, True)


@pytest.fixture(scope="module")
def unloaded(geometry):
    return Sample(geometry, False)


@pytest.fixture(scope="module")
def shapes(loaded):
    return batched(rod_shape, loaded)


@pytest.fixture(scope="module")
def energies(loaded):
    return batched(rod_energy, loaded)


@pytest.fixture(scope="module")
def unloaded_shapes(unloaded):
    return batched(rod_shape, unloaded)


def tangents_of(geometry, rotations):
    return jax.vmap(jax.vmap(lambda q: jnp.stack(geometry.tangent(geometry.rows(q)))))(rotations)


def test_whole_shapes_with_distributed_loads(geometry, loaded, shapes):
    tangents = tangents_of(geometry, shapes.rotation)
    for k in range(COUNT):
        s = np.linspace(0.0, loaded.length[k], STEPS + 1)
        p, R, n, m, _, _ = loaded.oracle(k, s)
        np.testing.assert_allclose(shapes.position[k], p[:, : geometry.d], rtol=0, atol=1e-10)
        np.testing.assert_allclose(tangents[k], R[:, : geometry.d, 0], rtol=0, atol=1e-10)
        np.testing.assert_allclose(shapes.force[k], n[:, : geometry.d], rtol=0, atol=1e-10)
        np.testing.assert_allclose(shapes.moment[k], m[:, 3 - geometry.r :], rtol=0, atol=1e-10)


def test_tip_is_the_end_of_the_shape(geometry, loaded, shapes, tip):
    """Up to rounding, which the weights of each step's extrapolation multiply."""
    atol = STEPS * np.sum(np.abs(WEIGHTS)) * np.finfo(float).eps
    found = tip(geometry, loaded.rods, loaded.force, loaded.moment, steps=STEPS)
    for end, along in zip(found, shapes, strict=True):
        np.testing.assert_allclose(end, along[:, -1], rtol=0, atol=atol)


def test_energy_and_mean_position(geometry, loaded, energies):
    energy, positions, _ = energies
    for k in range(COUNT):
        *_, expected, mean = loaded.oracle(k)
        np.testing.assert_allclose(energy[k], expected[-1], rtol=1e-10)
        np.testing.assert_allclose(positions[k], mean[-1, : geometry.d], rtol=0, atol=1e-10)


def test_energy_is_the_quadrature_of_its_density(geometry, loaded, shapes, energies):
    """Simpson's rule on the shape, with densities worked out here."""
    energy, positions, _ = energies
    local_n, local_m = local(geometry, shapes)
    density = 0.5 * np.sum(loaded.bend[:, None] * local_m**2, axis=2)
    density += 0.5 * np.sum(loaded.stretch[:, None] * local_n**2, axis=2)
    h = loaded.length / STEPS
    np.testing.assert_allclose(energy, h * scipy.integrate.simpson(density, axis=1), rtol=1e-5)
    mean = h[:, None] * scipy.integrate.simpson(shapes.position, axis=1)
    np.testing.assert_allclose(positions, mean, rtol=0, atol=1e-5)


def local(geometry, shapes):
    """Forces and moments in the axes of the sections."""
    turn = jax.vmap(jax.vmap(lambda q, n: jnp.stack(geometry.unrotate(geometry.rows(q), n))))
    turn_moment = jax.vmap(jax.vmap(lambda q, m: jnp.stack(geometry.to_local(geometry.rows(q), m))))
    return (
        np.asarray(turn(shapes.rotation, shapes.force)),
        np.asarray(turn_moment(shapes.rotation, shapes.moment)),
    )


def test_force_and_moment_about_the_origin_are_constant(geometry, unloaded, unloaded_shapes):
    """Without distributed loads `n` and `m + p × n` do not change along the rod."""
    shapes = unloaded_shapes
    np.testing.assert_array_equal(shapes.force, np.repeat(unloaded.force[:, None], STEPS + 1, 1))
    p, n = np.asarray(shapes.position), np.asarray(shapes.force)
    if geometry is PLANE:
        lever = (p[..., 0] * n[..., 1] - p[..., 1] * n[..., 0])[..., None]
    else:
        lever = np.cross(p, n)
    total = shapes.moment + lever
    np.testing.assert_allclose(total, np.repeat(total[:, :1], STEPS + 1, 1), rtol=0, atol=1e-11)


def test_hamiltonian_is_constant(geometry, unloaded, unloaded_shapes):
    """Along a uniform rod `n·p' + m·u - W` does not change, W being the energy per length."""
    local_n, local_m = local(geometry, unloaded_shapes)
    curvature = unloaded.bend[:, None] * local_m
    strain = unloaded.stretch[:, None] * local_n
    energy = 0.5 * np.sum(curvature * local_m, axis=2) + 0.5 * np.sum(strain * local_n, axis=2)
    work = np.sum((curvature + unloaded.rest[:, None]) * local_m, axis=2)
    work += local_n[..., 0] + np.sum(strain * local_n, axis=2)
    hamiltonian = work - energy
    assert np.ptp(energy, axis=1).min() > 1e-2
    np.testing.assert_allclose(
        hamiltonian, np.repeat(hamiltonian[:, :1], STEPS + 1, 1), rtol=0, atol=1e-11
    )


def test_torsion_of_an_isotropic_rod_is_constant(tip):
    """With equal bending stiffness, no shear and straight at rest, `m · t` does not change."""
    sample = Sample(SPACE, False)
    bend = np.stack([sample.bend[:, 0], sample.bend[:, 1], sample.bend[:, 1]], axis=1)
    rods = Rod(jnp.asarray(sample.length), jnp.asarray(bend), jnp.zeros((COUNT, 3)))
    found = tip(SPACE, rods, sample.force, sample.moment)
    along = jax.vmap(lambda q: jnp.stack(SPACE.tangent(SPACE.rows(q))))(found.rotation)
    torsion = np.sum(np.asarray(along) * np.asarray(found.moment), axis=1)
    np.testing.assert_allclose(torsion, sample.moment[:, 0], rtol=0, atol=1e-11)


def test_rotations_come_out_normal(shapes, unloaded_shapes):
    for rotation in (shapes.rotation, unloaded_shapes.rotation):
        np.testing.assert_allclose(np.sum(np.square(rotation), axis=-1), 1.0, rtol=0, atol=1e-14)
