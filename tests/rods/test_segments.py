"""Rods of several segments: closed forms, an independent integration, derivatives, accuracy."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree
from scipy.spatial.transform import Rotation

from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.rods.integration import rod_energy, rod_shape, rod_tip
from cpr_jax.rods.rod import Rod, kirchhoff_rod
from cpr_jax.rods.segments import alike, arc_lengths, segmented_rod, segments_of
from tests.oracles import cosserat
from tests.rods.common import differences
from tests.rods.test_closed_forms import helix

STEPS = 16
LENGTHS = (0.31, 0.22, 0.17)


@functools.partial(jax.jit, static_argnums=(0, 4))
def tip(geometry, rod, force, moment, steps=STEPS):
    return rod_tip(geometry, rod, force, moment, steps)


def random_rods(geometry, loaded=True, seed=3):
    """Three rods with every effect, and a wrench at the base of the first one."""
    rng = np.random.default_rng(seed)
    d, r = geometry.d, geometry.r
    rods = [
        Rod(
            length=jnp.asarray(length),
            curvature_compliance=jnp.asarray(np.exp(rng.uniform(-1.5, 1.5, r))),
            precurvature=jnp.asarray(rng.uniform(-2.0, 2.0, r)),
            strain_compliance=jnp.asarray(rng.uniform(0.0, 0.05, d)),
            force=jnp.asarray(rng.uniform(-2.0, 2.0, d)) if loaded else None,
            moment=jnp.asarray(rng.uniform(-1.0, 1.0, r)) if loaded else None,
        )
        for length in LENGTHS
    ]
    force, moment = jnp.asarray(rng.uniform(-2.0, 2.0, d)), jnp.asarray(rng.uniform(-1.0, 1.0, r))
    return rods, force, moment


def for_oracle(geometry, rod):
    d, r = geometry.d, geometry.r
    vector, axial = (0, 3 - d), (3 - r, 0)
    return cosserat.SpatialRod(
        float(rod.length),
        np.pad(rod.curvature_compliance, axial),
        np.pad(rod.precurvature, axial),
        np.pad(rod.strain_compliance, vector),
        np.zeros(3) if rod.force is None else np.pad(rod.force, vector),
        np.zeros(3) if rod.moment is None else np.pad(rod.moment, axial),
    )


@pytest.mark.parametrize("loaded", [True, False], ids=["loaded", "unloaded"])
def test_tips_and_energies_of_random_rods(geometry, loaded):
    d, r = geometry.d, geometry.r
    rods, force, moment = random_rods(geometry, loaded)
    p, R, n, m, energy, mean = cosserat.integrate_segments(
        [for_oracle(geometry, rod) for rod in rods],
        np.pad(force, (0, 3 - d)),
        np.pad(moment, (3 - r, 0)),
    )
    rod = segmented_rod(rods)
    found = tip(geometry, rod, force, moment)
    np.testing.assert_allclose(found.position, p[-1, :d], rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.force, n[-1, :d], rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.moment, m[-1, 3 - r :], rtol=0, atol=1e-11)
    tangent = jnp.stack(geometry.tangent(geometry.rows(found.rotation)))
    np.testing.assert_allclose(tangent, R[-1, :d, 0], rtol=0, atol=1e-11)

    total, positions, _ = rod_energy(geometry, rod, force, moment, STEPS)
    np.testing.assert_allclose(total, np.sum(energy), rtol=1e-10)
    np.testing.assert_allclose(positions, mean[:, :d], rtol=0, atol=1e-11)

    shape = rod_shape(geometry, rod, force, moment, STEPS)
    np.testing.assert_allclose(
        np.asarray(shape.position)[STEPS::STEPS], p[:, :d], rtol=0, atol=1e-11
    )
    np.testing.assert_allclose(shape.moment[STEPS::STEPS], m[:, 3 - r :], rtol=0, atol=1e-11)


def test_shape_between_the_ends(geometry):
    """Nodes in the second segment are where `arc_lengths` says."""
    rods, force, moment = random_rods(geometry)
    rod = segmented_rod(rods)
    shape, s = rod_shape(geometry, rod, force, moment, 4), arc_lengths(rod, 4)
    assert len(s) == len(shape.position) == 13
    np.testing.assert_allclose(np.asarray(s)[::4], np.cumsum([0.0, *LENGTHS]), rtol=0, atol=1e-13)
    cut = dataclasses.replace(rods[1], length=s[7] - s[4])
    expected = tip(geometry, segmented_rod([rods[0], cut]), force, moment)
    np.testing.assert_allclose(shape.position[7], expected.position, rtol=0, atol=1e-8)


def test_a_rod_cut_into_pieces_is_the_same_rod(geometry):
    rods, force, moment = random_rods(geometry)
    pieces = [dataclasses.replace(rods[0], length=jnp.asarray(x)) for x in (0.2, 0.3, 0.1)]
    whole = dataclasses.replace(rods[0], length=jnp.asarray(0.6))
    same, expected = (tip(geometry, rod, force, moment) for rod in (segmented_rod(pieces), whole))
    for a, b in zip(same, expected, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)
    energy, positions, _ = rod_energy(geometry, segmented_rod(pieces), force, moment, STEPS)
    expected_energy, expected_positions, _ = rod_energy(geometry, whole, force, moment, STEPS)
    np.testing.assert_allclose(energy, expected_energy, rtol=1e-12)
    np.testing.assert_allclose(positions.sum(axis=0), expected_positions, rtol=0, atol=1e-12)


def test_end_moment_bends_two_arcs():
    """In the plane the curvature `m / k_b + κ` is constant in each segment."""
    moment, numbers = 0.7, [(0.4, 0.5, 1.0), (0.3, 0.1, -2.0)]
    rod = segmented_rod([kirchhoff_rod(PLANE, *n) for n in numbers])
    found = tip(PLANE, rod, jnp.zeros(2), jnp.array([moment]))
    place, angle = 0.0, 0.0
    for length, k_b, rest in numbers:
        curvature = moment / k_b + rest
        turned = angle + curvature * length
        place += (np.exp(1j * turned) - np.exp(1j * angle)) / (1j * curvature)
        angle = turned
    np.testing.assert_allclose(found.position, [place.real, place.imag], rtol=0, atol=1e-13)
    np.testing.assert_allclose(found.rotation, [np.cos(angle), np.sin(angle)], rtol=0, atol=1e-13)


def test_end_moment_winds_two_helices():
    """In space each segment of an isotropic rod is a helix about the moment, joined smoothly."""
    moment, numbers = np.array([0.9, -0.4, 1.1]), [(0.4, 0.6), (0.5, 0.25)]
    rod = segmented_rod([kirchhoff_rod(SPACE, *n) for n in numbers])
    found = tip(SPACE, rod, jnp.zeros(3), jnp.asarray(moment))
    (first, k_1), (second, k_2) = numbers
    turn = Rotation.from_rotvec(first * moment / k_1)
    expected = helix(moment / k_1, first)
    expected = expected + turn.apply(helix(turn.inv().apply(moment) / k_2, second))
    np.testing.assert_allclose(found.position, expected, rtol=0, atol=1e-12)
    both = turn * Rotation.from_rotvec(second * turn.inv().apply(moment) / k_2)
    tangent = jnp.stack(SPACE.tangent(SPACE.rows(found.rotation)))
    np.testing.assert_allclose(tangent, both.as_matrix()[:, 0], rtol=0, atol=1e-12)


def test_stepped_cantilever(geometry):
    """Beam theory, `w(L) = ∫ (L - s) (F (L - s) + M) / k_b ds`, for small loads at the tip."""
    (l_1, k_1), (l_2, k_2) = (0.6, 0.5), (0.4, 0.08)
    length = l_1 + l_2
    rod = segmented_rod([kirchhoff_rod(geometry, l_1, k_1), kirchhoff_rod(geometry, l_2, k_2)])
    for F, M in ((1e-6, 0.0), (0.0, 1e-6), (1e-6, -2e-6)):
        force = np.zeros(geometry.d)
        force[1] = F
        moment = np.zeros(geometry.r)
        moment[-1] = F * length + M
        found = tip(geometry, rod, jnp.asarray(force), jnp.asarray(moment))
        sag = F * ((length**3 - l_2**3) / k_1 + l_2**3 / k_2) / 3.0
        sag += M * ((length**2 - l_2**2) / k_1 + l_2**2 / k_2) / 2.0
        slope = F * ((length**2 - l_2**2) / k_1 + l_2**2 / k_2) / 2.0 + M * (l_1 / k_1 + l_2 / k_2)
        np.testing.assert_allclose(found.position[1], sag, rtol=1e-9)
        direction = jnp.stack(geometry.tangent(geometry.rows(found.rotation)))
        np.testing.assert_allclose(direction[1], slope, rtol=1e-9)


def test_steps_end_where_stiffness_jumps():
    """Twice the steps leave less than a 500th of the error, as of a uniform rod: order 10."""
    rods = [kirchhoff_rod(PLANE, 0.37, 1.0), kirchhoff_rod(PLANE, 0.63, 0.05, 3.0)]
    rod, force, moment = segmented_rod(rods), jnp.array([-2.0, 3.0]), jnp.array([1.0])
    exact = tip(PLANE, rod, force, moment, 32).position
    errors = [
        float(jnp.max(jnp.abs(tip(PLANE, rod, force, moment, steps).position - exact)))
        for steps in (2, 4)
    ]
    assert errors[1] > 1e-13
    assert errors[0] / errors[1] > 500.0


@pytest.mark.parametrize("seed", [3, 4])
def test_derivatives_in_every_number(geometry, seed):
    """Lengths, compliances, curvatures at rest, loads of all segments; forward and reverse."""
    rods, force, moment = random_rods(geometry, seed=seed)
    x, unravel = ravel_pytree((segmented_rod(rods), force, moment))

    def function(x):
        return ravel_pytree(rod_tip(geometry, *unravel(x), 8))[0]

    jacobian = jax.jit(jax.jacfwd(function))(x)
    expected = differences(jax.jit(function), x, 1e-3)
    np.testing.assert_allclose(jacobian, expected, rtol=1e-8, atol=1e-9)
    weights = jnp.asarray(np.random.default_rng(seed).normal(size=len(jacobian)))
    pulled = jax.jit(jax.grad(lambda x: weights @ function(x)))(x)
    np.testing.assert_allclose(pulled, weights @ jacobian, rtol=0, atol=1e-12)


def test_second_derivatives_in_the_second_segment():
    rods, force, moment = random_rods(PLANE)
    rod = segmented_rod(rods)

    def function(x):
        lengths = rod.further.length.at[0].set(x[0])
        compliances = rod.further.curvature_compliance.at[0, -1].set(x[1])
        further = dataclasses.replace(rod.further, length=lengths, curvature_compliance=compliances)
        changed = dataclasses.replace(rod, length=x[2], further=further)
        return ravel_pytree(rod_tip(PLANE, changed, force, moment, 8))[0]

    x = jnp.array([LENGTHS[1], rods[1].curvature_compliance[-1], sum(LENGTHS)])
    found = jax.jit(jax.jacfwd(jax.jacrev(function)))(x)
    expected = differences(jax.jit(jax.jacfwd(function)), x, 1e-3)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_the_program_does_not_grow_with_the_segments():
    def size(count):
        rods = [kirchhoff_rod(SPACE, 0.1, 1.0)] * count
        arguments = segmented_rod(rods), jnp.zeros(3), jnp.zeros(3)
        lowered = jax.jit(lambda *a: rod_tip(SPACE, *a, STEPS)).lower(*arguments)
        return len(lowered.as_text().splitlines())

    assert size(2) == size(6)


def test_what_is_joined(geometry):
    """Effects that one rod lacks are zero there; segments of segments are segments."""
    plain = kirchhoff_rod(geometry, 0.2, 0.5)
    heavy = kirchhoff_rod(geometry, 0.3, 0.4, 1.0, force=np.ones(geometry.d))
    rod = segmented_rod([segmented_rod([plain, heavy]), plain])
    assert float(rod.length) == pytest.approx(0.7)
    parts = segments_of(rod)
    np.testing.assert_allclose(parts.length, [0.2, 0.3, 0.2], rtol=0, atol=1e-16)
    np.testing.assert_array_equal(parts.force[:, 0], [0.0, 1.0, 0.0])
    np.testing.assert_array_equal(parts.precurvature[:, -1], [0.0, 1.0, 0.0])
    assert rod.strain_compliance is None and rod.further.moment is None
    assert segmented_rod([heavy]) is heavy
    with pytest.raises(InputError, match="`rods` must hold at least one rod"):
        segmented_rod([])


def test_segments_without_length_do_nothing(geometry):
    rods, force, moment = random_rods(geometry)
    uniform, three = alike([rods[0], segmented_rod(rods)])
    assert uniform.further.length.shape == three.further.length.shape == (2,)
    for padded, rod in ((uniform, rods[0]), (three, segmented_rod(rods))):
        found, expected = (tip(geometry, r, force, moment) for r in (padded, rod))
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)
