"""Sensitivities of a spatial robot: differences, frames, and what its platform answers."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select
from cpr_jax.robots.catalogue_space import three_rfs
from cpr_jax.robots.robot import Home

LABELS = ("k_21", "k_32", "l3", "base1_x", "m_P_y", "kappa2")
DELTA = dict(zip(LABELS, (1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-2), strict=True))


@pytest.fixture(scope="module")
def robot():
    return three_rfs()


@pytest.fixture(scope="module")
def solved(robot):
    """Away from the symmetric home, under a load with a moment."""
    loaded = dataclasses.replace(
        robot, f_P=jnp.array([0.1, -0.05, 0.2]), m_P=jnp.array([2e-3, 1e-3, -1e-3])
    )
    return loaded, cpr.solve_forward(loaded, loaded.home.q_a + jnp.array([0.1, -0.1, 0.05]))


def around(robot, solved, changed):
    """Equilibria of a robot with other numbers, from the nominal one."""
    return cpr.solve_forward(changed, solved.q_a, guess=solved)


def test_Pi_y_by_central_differences(solved):
    robot, equilibrium = solved
    selection = select(robot, LABELS)
    found = cpr.sensitivity(robot, equilibrium, LABELS, DELTA)
    rho = selection.get(robot)
    # Long enough for ten digits, short enough for the second order to vanish.
    for k, step in enumerate(1e-4 * np.maximum(np.abs(rho), 1e-2)):
        aside = [
            around(robot, equilibrium, selection.set(robot, rho.at[k].add(sign * step))).y
            for sign in (1.0, -1.0)
        ]
        slope = (aside[0] - aside[1]) / (2.0 * step)
        column = found.Pi_y[:, k]
        size = np.max(np.abs(column))
        np.testing.assert_allclose(column / size, slope / size, rtol=0, atol=1e-6)


def test_a_small_turn_is_the_same_as_a_change_of_the_rotation_vector(solved):
    robot, equilibrium = solved
    found = cpr.sensitivity(robot, equilibrium, LABELS, DELTA)
    phi = np.array(equilibrium.q_p[3:])
    change = np.array(found.Pi("phi_P"))[:, 2] * 1e-5
    back = Rotation.from_rotvec(phi).inv()
    ahead, behind = (Rotation.from_rotvec(phi + s * change) * back for s in (1.0, -1.0))
    turn = (ahead.as_rotvec() - behind.as_rotvec()) / 2e-5
    np.testing.assert_allclose(np.asarray(found.Pi_turn)[:, 2], turn, rtol=1e-6)


def test_another_frame_changes_the_frame_only(solved):
    """The whole robot, its loads and its platform, turned and moved."""
    robot, equilibrium = solved
    turn, shift = Rotation.from_rotvec([0.3, -0.5, 0.8]), np.array([0.2, -0.1, 0.3])

    def turned(vectors):
        return jnp.asarray(turn.apply(np.array(vectors)))

    def composed(vectors):
        return jnp.asarray((turn * Rotation.from_rotvec(np.array(vectors))).as_rotvec())

    moved = eqx.tree_at(
        lambda r: (
            r.legs.base_position,
            r.legs.base_rotation,
            r.legs.rod.force,
            r.f_P,
            r.m_P,
            r.loads.force,
            r.home,
        ),
        robot,
        (
            turned(robot.legs.base_position) + shift,
            composed(robot.legs.base_rotation),
            turned(robot.legs.rod.force),
            turned(robot.f_P),
            turned(robot.m_P),
            turned(robot.loads.force),
            Home(
                robot.home.q_a,
                jnp.concatenate([turned(robot.home.q_p[:3]) + shift, composed(robot.home.q_p[3:])]),
            ),
        ),
    )
    found = cpr.solve_forward(moved, equilibrium.q_a)
    q_p = np.asarray(equilibrium.q_p)
    np.testing.assert_allclose(found.q_p[:3], turned(q_p[:3]) + shift, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.q_p[3:], composed(q_p[3:]), rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.mu[:, :3], turned(equilibrium.mu[:, :3]), rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.motor_torques, equilibrium.motor_torques, rtol=0, atol=1e-9)
    # Numbers of the robot itself, not of its place in the world.
    own = ("k_21", "k_32", "l3", "kappa2")
    one, other = (
        cpr.ellipsoid(cpr.sensitivity(r, e, own, {label: DELTA[label] for label in own})).semi_axes
        for r, e in ((robot, equilibrium), (moved, found))
    )
    np.testing.assert_allclose(one, other, rtol=1e-9)


def test_the_platform_answers_to_motors_and_loads(solved):
    robot, equilibrium = solved
    found = cpr.mobility(robot, equilibrium)

    def motion(changed, q_a):
        moved = cpr.solve_forward(changed, q_a, guess=equilibrium)
        back = Rotation.from_rotvec(np.array(equilibrium.q_p[3:])).inv()
        turn = (Rotation.from_rotvec(np.array(moved.q_p[3:])) * back).as_rotvec()
        return np.concatenate([moved.q_p[:3] - equilibrium.q_p[:3], turn])

    h = 1e-5
    for k in range(3):
        step = h * np.eye(3)[k]
        ends = [motion(robot, equilibrium.q_a + s * step) for s in (1.0, -1.0)]
        np.testing.assert_allclose(
            found.jacobian[:, k], (ends[0] - ends[1]) / (2 * h), rtol=1e-6, atol=1e-8
        )
    for k in range(6):
        load = h * np.eye(6)[k]
        ends = [
            motion(
                dataclasses.replace(
                    robot, f_P=robot.f_P + s * load[:3], m_P=robot.m_P + s * load[3:]
                ),
                equilibrium.q_a,
            )
            for s in (1.0, -1.0)
        ]
        slope = (ends[0] - ends[1]) / (2 * h)
        size = np.max(np.abs(slope))
        np.testing.assert_allclose(found.compliance[:, k] / size, slope / size, rtol=0, atol=1e-6)
    singular = np.linalg.svd(np.asarray(found.jacobian)[:3], compute_uv=False)
    assert float(found.manipulability) == pytest.approx(np.prod(singular), rel=1e-9)
    assert float(found.condition) == pytest.approx(singular[-1] / singular[0], rel=1e-9)


def test_small_uncertainty_covers_what_chi_square_says(robot):
    """97.071 % of a Gaussian in three dimensions, σ = δ/3."""
    nominal = cpr.solve_forward(robot, robot.home.q_a)
    delta = {label: float(value) / 100.0 for label, value in robot.uncertainty.items()}
    study = cpr.monte_carlo(robot, nominal, 50_000, delta=delta)
    expected = cpr.linear_coverage(3)
    assert expected == pytest.approx(0.97071, abs=1e-5)
    # Four standard deviations of a count.
    slack = 4.0 * np.sqrt(expected * (1.0 - expected) / study.samples)
    assert study.coverage == pytest.approx(expected, abs=slack)
    assert study.solved == study.samples


def test_the_ellipsoid_of_the_orientation_needs_an_orientation():
    with pytest.raises(ValueError, match="`rows` must not be 'turn_P'"):
        planar = cpr.rfrfr()
        found = cpr.solve_inverse(planar, (0.0, 0.2))
        jax.block_until_ready(cpr.ellipsoid(cpr.sensitivity(planar, found), "turn_P"))
