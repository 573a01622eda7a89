"""Rotations of the plane and of space against scipy's, and the identities between operations."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cpr_jax.geometry import PLANE, SPACE

GEOMETRIES = [PLANE, SPACE]
# Between the two, the series of exp and log hand over to the closed forms.
SMALL_ANGLES = [0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 9.99e-3, 1.001e-2, 1.999e-2, 2.001e-2]
LARGE_ANGLES = [0.1, 1.0, 2.0, 3.0, np.pi - 1e-3, np.pi - 1e-7]


def vectors_of_length(geometry, lengths, seed=0):
    """Rotation vectors in random directions, a row each."""
    directions = np.random.default_rng(seed).normal(size=(len(lengths), geometry.r))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return directions * np.asarray(lengths)[:, None]


def matrices(geometry, vectors):
    """What scipy makes of rotation vectors: matrices that act on the geometry's vectors."""
    if geometry.r == 3:
        return Rotation.from_rotvec(vectors).as_matrix()
    about_x = np.pad(vectors, ((0, 0), (0, 2)))
    return Rotation.from_rotvec(about_x).as_matrix()[:, 1:, 1:]


def batched(function):
    """A function of component tuples on arrays with a row a case."""

    def single(*rows):
        return jnp.stack(function(*(tuple(row) for row in rows)))

    return jax.jit(jax.vmap(single))


def turning(geometry, name):
    """As `batched`, of a method that takes the rows of a rotation."""
    method = getattr(geometry, name)
    return batched(lambda rotation, *vectors: method(geometry.rows(rotation), *vectors))


@pytest.fixture(scope="module", params=GEOMETRIES, ids=repr)
def geometry(request):
    return request.param


@pytest.fixture(scope="module")
def cases(geometry):
    lengths = SMALL_ANGLES + LARGE_ANGLES + list(np.linspace(0.0, 3.1, 40))
    return vectors_of_length(geometry, lengths)


@pytest.fixture(scope="module")
def rotations(geometry, cases):
    return batched(geometry.exp)(cases)


def test_exp_turns_vectors_as_scipy_does(geometry, cases, rotations):
    arms = np.random.default_rng(1).normal(size=(len(cases), geometry.d))
    expected = np.einsum("kij,kj->ki", matrices(geometry, cases), arms)
    np.testing.assert_allclose(
        turning(geometry, "rotate")(rotations, arms), expected, rtol=0, atol=2e-14
    )
    back = turning(geometry, "unrotate")(rotations, expected)
    np.testing.assert_allclose(back, arms, rtol=0, atol=1e-14)


def test_exp_is_normal_for_every_angle(geometry, rotations):
    np.testing.assert_allclose(np.sum(np.square(rotations), axis=1), 1.0, rtol=0, atol=4e-15)


def test_log_inverts_exp_relative_to_the_angle(geometry, cases, rotations):
    found = batched(geometry.log)(rotations)
    np.testing.assert_allclose(found, cases, rtol=1e-13, atol=1e-15)
    tiny = np.linalg.norm(cases, axis=1) < 1e-100
    np.testing.assert_allclose(found[tiny], cases[tiny], rtol=1e-14, atol=0.0)


def test_compose_is_the_product_of_matrices(geometry, cases, rotations):
    other = vectors_of_length(geometry, np.linspace(3.0, 0.0, len(cases)), seed=2)
    both = batched(geometry.compose)(rotations, batched(geometry.exp)(other))
    product = matrices(geometry, cases) @ matrices(geometry, other)
    for axis in np.eye(geometry.d):
        turned = turning(geometry, "rotate")(both, np.tile(axis, (len(cases), 1)))
        np.testing.assert_allclose(turned, product @ axis, rtol=0, atol=1e-14)


def test_inverse_undoes_a_rotation(geometry, rotations):
    nothing = batched(geometry.compose)(batched(geometry.inverse)(rotations), rotations)
    np.testing.assert_allclose(
        nothing, np.tile(geometry.identity, (len(rotations), 1)), rtol=0, atol=1e-15
    )


def test_tangent_is_the_turned_first_axis(geometry, cases, rotations):
    expected = matrices(geometry, cases)[:, :, 0]
    np.testing.assert_allclose(
        turning(geometry, "tangent")(rotations), expected, rtol=0, atol=1e-14
    )


def test_normalise_keeps_the_rotation(geometry, rotations):
    stretched = batched(geometry.normalise)(1.7 * rotations)
    np.testing.assert_allclose(stretched, rotations, rtol=0, atol=1e-15)


def test_moments_turn_like_vectors_in_space_and_not_at_all_in_the_plane(geometry, cases, rotations):
    moments = np.random.default_rng(3).normal(size=(len(cases), geometry.r))
    expected = moments
    if geometry is SPACE:
        expected = np.einsum("kij,kj->ki", matrices(geometry, cases), moments)
    outer = turning(geometry, "to_outer")(rotations, moments)
    np.testing.assert_allclose(outer, expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        turning(geometry, "to_local")(rotations, outer), moments, rtol=0, atol=1e-14
    )


def test_rate_is_the_derivative_of_a_turning_frame(geometry):
    """With a constant local curvature u, `R(s) = R(0) exp(s u)`."""
    start, turn = vectors_of_length(geometry, [0.7, 1.3], seed=4)

    def frame(s):
        turned = geometry.exp(tuple(s * u for u in turn))
        return jnp.stack(geometry.compose(geometry.exp(tuple(start)), turned))

    @jax.jit
    def both(s):
        value, derivative = jax.jvp(frame, (s,), (1.0,))
        return derivative, jnp.stack(geometry.rate(tuple(value), tuple(turn)))

    for s in (0.0, 0.4, 2.1):
        expected, found = both(s)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_exp_and_log_are_smooth_at_no_rotation(geometry, mode):
    """At 0, the rotation is `(1 - |h v|² / 2, h v)` with h = 1/2 (quaternion) or 1 (plane)."""

    def exp(v):
        return jnp.stack(geometry.exp(tuple(v)))

    def round_trip(v):
        return jnp.stack(geometry.log(tuple(exp(v))))

    half = 0.5 if geometry is SPACE else 1.0
    unit = np.eye(geometry.r)

    @jax.jit
    def derivatives(v):
        return mode(exp)(v), mode(mode(exp))(v), mode(round_trip)(v)

    first, second, identity = derivatives(jnp.zeros(geometry.r))
    np.testing.assert_allclose(first[0], 0.0, rtol=0, atol=1e-16)
    np.testing.assert_allclose(first[1:], half * unit, rtol=0, atol=1e-16)
    np.testing.assert_allclose(second[0], -(half**2) * unit, rtol=0, atol=1e-16)
    np.testing.assert_allclose(second[1:], 0.0, rtol=0, atol=1e-16)
    np.testing.assert_allclose(identity, unit, rtol=0, atol=1e-16)


def test_derivative_of_log_exp_is_the_identity(geometry):
    lengths = [1e-6, 9.9e-3, 1.01e-2, 1.99e-2, 2.01e-2, 1.5, 3.1]

    @jax.jit
    @jax.vmap
    @jax.jacfwd
    def slope(v):
        return jnp.stack(geometry.log(geometry.exp(tuple(v))))

    slopes = slope(vectors_of_length(geometry, lengths, seed=5))
    np.testing.assert_allclose(
        slopes, np.tile(np.eye(geometry.r), (len(lengths), 1, 1)), rtol=0, atol=1e-11
    )


def test_log_takes_the_short_way_round():
    """A quaternion and its negative are one rotation; beyond π the other way is shorter."""
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    rotation = SPACE.exp(tuple(4.0 * axis))
    expected = (4.0 - 2.0 * np.pi) * axis
    np.testing.assert_allclose(jnp.stack(SPACE.log(rotation)), expected, rtol=0, atol=1e-14)
    negative = tuple(-c for c in rotation)
    np.testing.assert_allclose(jnp.stack(SPACE.log(negative)), expected, rtol=0, atol=1e-14)
    (angle,) = PLANE.log(PLANE.exp((4.0,)))
    np.testing.assert_allclose(angle, 4.0 - 2.0 * np.pi, rtol=0, atol=1e-14)


def test_half_a_turn_has_a_rotation_vector_of_length_pi():
    for axis in (*np.eye(3), np.array([0.6, 0.0, 0.8])):
        found = jnp.stack(SPACE.log((0.0, *axis)))
        np.testing.assert_allclose(found, np.pi * axis, rtol=0, atol=1e-15)


def test_arrays_behind_components_turn_as_components_do(geometry, cases, rotations):
    """What is for arrays outside of integrations agrees with what is for components inside."""
    rng = np.random.default_rng(7)
    arms, forces = rng.normal(size=(2, geometry.d, len(cases)))
    rotation = tuple(jnp.asarray(rotations).T)
    rows, frame = geometry.rows(rotation), geometry.frame(rotation)
    for found, expected in (
        (geometry.outward(frame, arms), geometry.rotate(rows, arms)),
        (geometry.inward(frame, arms), geometry.unrotate(rows, arms)),
        (geometry.moment_of(arms, forces), geometry.cross(arms, forces)),
    ):
        np.testing.assert_allclose(found, jnp.stack(expected), rtol=0, atol=1e-14)


def test_cross_product():
    rng = np.random.default_rng(6)
    arm, force = rng.normal(size=(2, 3))
    np.testing.assert_allclose(jnp.stack(SPACE.cross(arm, force)), np.cross(arm, force))
    planar = np.cross([0.0, *arm[1:]], [0.0, *force[1:]])
    np.testing.assert_allclose(PLANE.cross(arm[1:], force[1:])[0], planar[0])


def test_the_plane_is_the_restriction_of_space():
    """Space turned about x, in axes whose last two are the plane's."""
    rng = np.random.default_rng(7)
    for angle in rng.uniform(-3.0, 3.0, 10):
        arm, force = rng.normal(size=(2, 2))
        planar, spatial = PLANE.exp((angle,)), SPACE.exp((angle, 0.0, 0.0))
        turned = SPACE.rotate(SPACE.rows(spatial), (0.0, *arm))
        assert turned[0] == 0.0
        np.testing.assert_allclose(
            turned[1:], PLANE.rotate(PLANE.rows(planar), arm), rtol=0, atol=1e-15
        )
        np.testing.assert_allclose(SPACE.log(spatial)[0], PLANE.log(planar)[0], rtol=0, atol=1e-15)
        np.testing.assert_allclose(
            SPACE.cross((0.0, *arm), (0.0, *force))[0],
            PLANE.cross(arm, force)[0],
            rtol=0,
            atol=1e-15,
        )
        twice = SPACE.log(SPACE.compose(spatial, spatial))[0]
        np.testing.assert_allclose(
            twice, PLANE.log(PLANE.compose(planar, planar))[0], rtol=0, atol=1e-14
        )


def test_geometries_serve_as_static_fields():
    assert hash(PLANE) == hash(type(PLANE)()) and type(PLANE)() == PLANE
    assert PLANE != SPACE
    assert (PLANE.d, PLANE.r, PLANE.freedoms) == (2, 1, 3)
    assert (SPACE.d, SPACE.r, SPACE.freedoms) == (3, 3, 6)
