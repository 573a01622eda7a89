"""Small turns of arms and moments, and mirrors: against derivatives of finite rotations."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.geometry import PLANE, SPACE


@pytest.fixture(params=[PLANE, SPACE], ids=repr)
def geometry(request):
    return request.param


@pytest.fixture
def arm(geometry):
    return jnp.asarray(np.random.default_rng(4).normal(size=geometry.d))


@pytest.fixture
def force(geometry):
    return jnp.asarray(np.random.default_rng(5).normal(size=geometry.d))


def turned(geometry, turn, vector):
    return jnp.stack(geometry.rotate(geometry.rows(geometry.exp(turn)), vector))


def at_rest(geometry):
    return jnp.zeros(geometry.r)


def test_spin_is_the_slope_of_a_turned_arm(geometry, arm):
    slope = jax.jacfwd(lambda turn: turned(geometry, turn, arm))(at_rest(geometry))
    np.testing.assert_allclose(geometry.spin(arm), slope, atol=1e-15)


def test_lever_is_the_curvature_of_the_energy_of_a_dead_force(geometry, arm, force):
    energy = jax.hessian(lambda turn: -force @ turned(geometry, turn, arm))
    np.testing.assert_allclose(
        geometry.lever(arm, force), energy(at_rest(geometry)), rtol=1e-14, atol=1e-15
    )


def test_bracket_is_the_slope_of_a_turned_moment(geometry):
    turn, moment = jnp.asarray(np.random.default_rng(6).normal(size=(2, geometry.r)))

    def after(share):
        return jnp.stack(geometry.to_outer(geometry.rows(geometry.exp(share * turn)), moment))

    slope = jax.jacfwd(after)(0.0)
    np.testing.assert_allclose(geometry.bracket(turn, moment), slope, rtol=1e-14, atol=1e-15)


def test_a_dead_moment_of_the_plane_is_the_slope_of_its_potential():
    slope = jax.grad(PLANE.potential, argnums=1)(jnp.array([0.3]), jnp.array([0.7]))
    np.testing.assert_array_equal(slope, [-0.3])


def test_magnitude_of_an_area(geometry, arm, force):
    """The parallelogram of two vectors, by Gram's determinant."""
    area = jnp.stack(geometry.cross(arm, force))
    gram = (arm @ arm) * (force @ force) - (arm @ force) ** 2
    np.testing.assert_allclose(geometry.magnitude(area) ** 2, gram, rtol=1e-14)
    assert np.all(np.isfinite(jax.grad(geometry.magnitude)(at_rest(geometry))))


def test_the_plane_gives_an_area_its_sign():
    areas = [PLANE.magnitude(jnp.stack(PLANE.cross(arm, (0.0, 1.0)))) for arm in ((2, 0), (-2, 0))]
    np.testing.assert_array_equal(areas, [2.0, -2.0])


def test_a_mirror_commutes_with_turns_and_moments(geometry, arm, force):
    turn = jnp.asarray(np.random.default_rng(7).normal(size=geometry.r))
    for axis in geometry.axes:
        vectors, turns = geometry.mirror(axis)
        np.testing.assert_array_equal(vectors, [-1.0 if a == axis else 1.0 for a in geometry.axes])
        np.testing.assert_allclose(
            turned(geometry, turns * turn, vectors * arm),
            vectors * turned(geometry, turn, arm),
            rtol=1e-13,
        )
        moment = jnp.stack(geometry.cross(vectors * arm, vectors * force))
        expected = turns * jnp.stack(geometry.cross(arm, force))
        np.testing.assert_allclose(moment, expected, rtol=1e-13)


def test_known_numbers_are_turned_without_a_program(geometry):
    """Outside of programs exp computes with numpy, to the same digits."""
    for length in (0.0, 1e-9, 1e-3, 0.7):
        turn = np.full(geometry.r, length)
        known = geometry.exp(turn)
        assert not any(isinstance(part, jax.Array) for part in known)
        np.testing.assert_allclose(known, jax.jit(geometry.exp)(turn), rtol=1e-15, atol=1e-16)
