"""A rod's tip where mathematics knows it: elastica, arcs, helices, bars, and a benchmark."""

import dataclasses
import json
import pathlib

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize
from scipy.spatial.transform import Rotation

from cpr_jax.geometry import SPACE
from cpr_jax.rods.integration import rod_tip
from cpr_jax.rods.rod import Rod, kirchhoff_rod
from tests.oracles import elastica

CASES = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())
LOADS = [0.05, 1.0, 10.0, 20.0]
L, EI = 0.7, 0.3


def rotvec(rotation):
    return np.stack([np.asarray(jnp.stack(SPACE.log(tuple(q)))) for q in rotation])


def planar(geometry, pairs):
    """Vectors in the plane of the first two axes."""
    return np.pad(np.asarray(pairs), ((0, 0), (0, geometry.d - 2)))


def normal(geometry, values):
    """Moments about the normal of that plane, the last axis."""
    return np.pad(np.asarray(values)[:, None], ((0, 0), (geometry.r - 1, 0)))


def full(geometry, rest=0.0, **effects):
    """The Kirchhoff rod with every other effect there, of size zero unless given."""
    zero = {"strain_compliance": geometry.d, "force": geometry.d, "moment": geometry.r}
    effects = {name: jnp.zeros(size) for name, size in zero.items()} | effects
    return dataclasses.replace(kirchhoff_rod(geometry, L, EI, rest), **effects)


def test_the_oracle_reproduces_the_published_elastica():
    for load, published in CASES["elastica"]["PL2_over_EI"].items():
        found = elastica.cantilever(float(load))
        assert 1.0 - found.along == pytest.approx(published["u_over_L"], abs=1e-7)
        assert found.across == pytest.approx(published["w_over_L"], abs=1e-7)
        assert found.angle == pytest.approx(published["theta"], abs=1e-7)


def test_cantilever_under_a_transverse_load(geometry, tip):
    """With the clamp's moment of the closed form, the tip lies on the elastica and is free."""
    exact = [elastica.cantilever(load) for load in LOADS]
    forces = planar(geometry, [(0.0, load * EI / L**2) for load in LOADS])
    moments = normal(geometry, [e.moment * EI / L for e in exact])
    found = tip(geometry, [kirchhoff_rod(geometry, L, EI)] * len(LOADS), forces, moments)
    expected = planar(geometry, [(e.along * L, e.across * L) for e in exact])
    np.testing.assert_allclose(found.position, expected, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.moment, 0.0, rtol=0, atol=1e-10)
    angles = np.array([e.angle for e in exact])
    directions = jax.vmap(lambda q: jnp.stack(geometry.tangent(geometry.rows(q))))(found.rotation)
    np.testing.assert_allclose(directions[:, 0], np.cos(angles), rtol=0, atol=1e-11)
    np.testing.assert_allclose(directions[:, 1], np.sin(angles), rtol=0, atol=1e-11)


def test_cantilever_bends_alike_in_every_direction(tip):
    exact = elastica.cantilever(10.0)
    rolls = np.linspace(0.0, 2.0 * np.pi, 5)[:-1] + 0.3
    zero = np.zeros_like(rolls)
    across = np.stack([zero, np.cos(rolls), np.sin(rolls)], axis=1)
    about = np.stack([zero, -np.sin(rolls), np.cos(rolls)], axis=1)
    rods = [kirchhoff_rod(SPACE, L, EI)] * len(rolls)
    found = tip(SPACE, rods, 10.0 * EI / L**2 * across, exact.moment * EI / L * about)
    expected = exact.across * L * across + np.array([exact.along * L, 0.0, 0.0])
    np.testing.assert_allclose(found.position, expected, rtol=0, atol=1e-11)
    np.testing.assert_allclose(rotvec(found.rotation), exact.angle * about, rtol=0, atol=1e-11)


def test_pure_moment_bends_a_precurved_rod_into_an_arc(geometry, tip):
    rest = 1.5
    turns = np.array([-6.5, -1.0, 1e-9, 0.4, 2.0 * np.pi, 8.0])
    moments = normal(geometry, EI * (turns / L - rest))
    rods = [kirchhoff_rod(geometry, L, EI, rest)] * len(turns)
    found = tip(geometry, rods, np.zeros((len(turns), geometry.d)), moments)
    arc = [(L * np.sin(t) / t, 2.0 * L * np.sin(t / 2.0) ** 2 / t) for t in turns]
    np.testing.assert_allclose(found.position, planar(geometry, arc), rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.moment, moments, rtol=0, atol=1e-12)


def test_a_rod_with_curvature_and_torsion_at_rest_is_a_helix(tip):
    """`R(s) = exp(s u)`, and its first column integrates by Rodrigues' formula."""
    for rest in ([2.0, 0.0, 3.0], [-4.0, 1.0, 5.0]):
        rods = [kirchhoff_rod(SPACE, L, (0.2, 0.3, 0.4), rest)]
        found = tip(SPACE, rods, np.zeros((1, 3)), np.zeros((1, 3)))
        np.testing.assert_allclose(found.position[0], helix(np.array(rest), L), rtol=0, atol=1e-12)
        turned = Rotation.from_rotvec(L * np.array(rest)).as_matrix()
        columns = [
            jnp.stack(SPACE.rotate(SPACE.rows(found.rotation[0]), axis)) for axis in np.eye(3)
        ]
        np.testing.assert_allclose(np.stack(columns, axis=1), turned, rtol=0, atol=1e-12)


def helix(turn, length):
    """`∫ exp(s u) e₁ ds` from 0 to the length."""
    rate = np.linalg.norm(turn)
    axis = turn / rate
    start = np.array([1.0, 0.0, 0.0])
    along = axis * (axis @ start)
    angle = rate * length
    side = np.cross(axis, start)
    return along * length + ((start - along) * np.sin(angle) + side * (1.0 - np.cos(angle))) / rate


def test_end_moment_winds_a_straight_rod_into_a_helix(tip):
    """The tangent of an isotropic rod precesses about the moment at `|m| / k_b`."""
    k_t, k_b = 0.15, 0.3
    moment = np.array([0.9, -0.4, 1.1])
    rods = [kirchhoff_rod(SPACE, L, (k_t, k_b, k_b))]
    found = tip(SPACE, rods, np.zeros((1, 3)), moment[None])
    np.testing.assert_allclose(found.position[0], helix(moment / k_b, L), rtol=0, atol=1e-12)
    # Beyond the precession the section turns about its tangent, as torsion is softer.
    spin = Rotation.from_rotvec([L * moment[0] * (1.0 / k_t - 1.0 / k_b), 0.0, 0.0])
    expected = (Rotation.from_rotvec(L * moment / k_b) * spin).as_rotvec()
    np.testing.assert_allclose(rotvec(found.rotation)[0], expected, rtol=0, atol=1e-12)


def test_a_rod_that_cannot_bend_stretches_and_shears(geometry, tip):
    """The strain is constant, so that the tip is at `(e₁ + C n) L`, and `m' = -p' × n`."""
    rng = np.random.default_rng(0)
    n, compliance = rng.normal(size=(2, geometry.d))
    compliance = 0.3 * np.abs(compliance)
    moment = rng.normal(size=geometry.r)
    rod = full(
        geometry,
        curvature_compliance=jnp.zeros(geometry.r),
        strain_compliance=jnp.asarray(compliance),
    )
    found = tip(geometry, [rod], n[None], moment[None])
    end = L * (np.eye(geometry.d)[0] + compliance * n)
    np.testing.assert_allclose(found.position[0], end, rtol=0, atol=1e-13)
    np.testing.assert_allclose(found.rotation[0], geometry.identity, rtol=0, atol=1e-15)
    lever = jnp.stack(geometry.cross(end, n))
    np.testing.assert_allclose(found.moment[0], moment - lever, rtol=0, atol=1e-13)


def test_distributed_moment_on_a_straight_rod(geometry, tip):
    """Without force, `m(s) = m(0) - l s`; with `m(0) = l L` the tip is free and turns l L²/2k."""
    couple = 1.7
    rod = full(geometry, moment=normal(geometry, [couple])[0])
    found = tip(geometry, [rod], np.zeros((1, geometry.d)), normal(geometry, [couple * L]))
    np.testing.assert_allclose(found.moment, 0.0, rtol=0, atol=1e-13)
    turn = couple * L**2 / 2.0 / EI
    direction = jnp.stack(geometry.tangent(geometry.rows(found.rotation[0])))
    np.testing.assert_allclose(direction[:2], [np.cos(turn), np.sin(turn)], rtol=0, atol=1e-12)


@pytest.fixture(scope="module")
def bend_45():
    """Tip of the benchmark for a strain compliance, from the clamp's moment that frees the tip."""
    case = CASES["bend_45"]["rod"]
    E, G, I, J = (case[k] for k in ("E", "G", "I", "J"))  # noqa: E741
    length = case["radius_of_precurvature"] * np.deg2rad(case["angle_deg"])
    rest = 1.0 / case["radius_of_precurvature"]
    rod = kirchhoff_rod(SPACE, length, (G * J, E * I, E * I), rest)
    force = jnp.array([0.0, 0.0, 300.0])

    @jax.jit
    def shoot(moment, strain):
        def missing(moment):
            full = Rod(rod.length, rod.curvature_compliance, rod.precurvature, strain)
            state = rod_tip(SPACE, full, force, moment, 16)
            return state.moment / 1e4, (state.moment / 1e4, state.position)

        jacobian, (error, position) = jax.jacfwd(missing, has_aux=True)(moment)
        return error, jacobian, position

    def tip(strain):
        found = scipy.optimize.root(
            lambda m: [np.asarray(part) for part in shoot(m, strain)[:2]],
            np.zeros(3),
            jac=True,
            tol=1e-12,
        )
        assert np.max(np.abs(found.fun)) < 1e-12
        return np.asarray(shoot(found.x, strain)[2])

    return tip


def test_the_45_degree_bend(bend_45):
    """All seven digits need the rod that stretches and shears, with the full area in shear."""
    case = CASES["bend_45"]["rod"]
    E, G, A = (case[k] for k in ("E", "G", "A"))
    published = np.array(CASES["bend_45"]["tip"]["300"])
    cosserat = bend_45(1.0 / np.array([E * A, G * A, G * A]))
    np.testing.assert_allclose(cosserat, published, rtol=2e-8)
    kirchhoff = bend_45(np.zeros(3))
    assert np.max(np.abs(kirchhoff - published)) > 1e-3


def test_effects_of_size_zero_are_the_effects_left_out(geometry, tip):
    rng = np.random.default_rng(1)
    forces, moments = rng.normal(size=(3, geometry.d)), rng.normal(size=(3, geometry.r))
    plain = tip(geometry, [kirchhoff_rod(geometry, L, EI, 2.0)] * 3, forces, moments)
    same = tip(geometry, [full(geometry, rest=2.0)] * 3, forces, moments)
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=0, atol=1e-12), plain, same)
