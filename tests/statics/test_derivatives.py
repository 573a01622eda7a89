"""First derivatives of equilibria: differences of solves, identities of mechanics, both modes."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.statics.problem import Problem, forward_rows
from cpr_jax.statics.roots import find_root
from cpr_jax.statics.solve import solve_forward, solve_inverse


@pytest.fixture(scope="module")
def slopes():
    """Jacobian of `y` in every number of the robot and in the motor angles, as pytrees."""

    @eqx.filter_jit
    def jacobians(robot, q_a, guess):
        def solve(robot, q_a):
            return solve_forward(robot, q_a, guess=guess, throw=False).y

        return jax.jacfwd(solve, argnums=(0, 1))(robot, q_a)

    return jacobians


@pytest.fixture(scope="module")
def off_axis(paper):
    """An equilibrium without any symmetry."""
    return solve_inverse(paper, (0.05, 0.17))


@pytest.fixture(scope="module")
def by_motors_held(paper, off_axis, slopes):
    return slopes(paper, off_axis.q_a, off_axis)


LEAVES = {
    "f_P": lambda r: r.f_P,
    "base_position": lambda r: r.legs.base_position,
    "base_rotation": lambda r: r.legs.base_rotation,
    "a": lambda r: r.legs.a,
    "b": lambda r: r.legs.b,
    "length": lambda r: r.legs.rod.length,
    "compliance": lambda r: r.legs.rod.curvature_compliance,
    "precurvature": lambda r: r.legs.rod.precurvature,
    "attachment": lambda r: r.legs.attachment_position,
    "transmission": lambda r: r.transmission,
}


@pytest.mark.parametrize("name", LEAVES)
def test_jacobian_against_differences_of_solves(paper, off_axis, by_motors_held, name):
    leaf = LEAVES[name](paper)
    jacobian = np.asarray(LEAVES[name](by_motors_held[0]))
    for at in np.ndindex(leaf.shape):
        step = 1e-5 * max(1.0, abs(float(leaf[at])))

        def solved(change, at=at):
            moved = eqx.tree_at(LEAVES[name], paper, leaf.at[at].add(change))
            return np.asarray(solve_forward(moved, off_axis.q_a, guess=off_axis).y)

        expected = (solved(step) - solved(-step)) / (2.0 * step)
        np.testing.assert_allclose(
            jacobian[(..., *at)], expected, rtol=0, atol=1e-6 * scale(expected)
        )


def scale(values):
    return max(1.0, np.max(np.abs(values)))


def test_jacobian_in_the_motor_angles(paper, off_axis, by_motors_held):
    step = 1e-5
    for i, unit in enumerate(step * np.eye(2)):
        above, below = (
            solve_forward(paper, off_axis.q_a + sign * unit, guess=off_axis).y for sign in (1, -1)
        )
        expected = (above - below) / (2.0 * step)
        np.testing.assert_allclose(
            by_motors_held[1][:, i], expected, rtol=0, atol=1e-6 * scale(expected)
        )
    # The motors are held, and each moves with its own angle.
    np.testing.assert_allclose(by_motors_held[1][:2], np.eye(2), rtol=0, atol=1e-14)


def test_what_is_not_physics_has_no_derivative(by_motors_held):
    by_robot, _ = by_motors_held
    np.testing.assert_array_equal(by_robot.home.q_a, 0.0)
    np.testing.assert_array_equal(by_robot.home.q_p, 0.0)
    np.testing.assert_array_equal(by_robot.legs.joint.free, 0.0)


def test_scaling_all_stiffnesses_and_forces_moves_nothing(pushed, slopes):
    """Straight inextensible rods: `Σ k ∂p/∂k + f · ∂p/∂f = 0`, and `μ` scales with both."""
    robot, equilibrium = pushed
    by_robot, _ = slopes(robot, equilibrium.q_a, equilibrium)
    compliance = robot.legs.rod.curvature_compliance
    stiffer = -jnp.tensordot(by_robot.legs.rod.curvature_compliance, compliance, 2)
    change = np.asarray(stiffer + by_robot.f_P @ robot.f_P)
    assert np.max(np.abs(stiffer[2:4])) > 1e-3
    np.testing.assert_allclose(change[:4], 0.0, rtol=0, atol=1e-10)
    np.testing.assert_allclose(change[4:], equilibrium.mu.reshape(-1), rtol=0, atol=1e-9)


def test_moving_and_turning_the_whole_robot(paper, off_axis, by_motors_held):
    """Shifting both motors shifts the platform and changes no angle and no wrench."""
    by_robot, _ = by_motors_held
    shift = np.asarray(by_robot.legs.base_position).sum(axis=1)
    expected = np.zeros_like(shift)
    expected[2:4] = np.eye(2)
    np.testing.assert_allclose(shift, expected, rtol=0, atol=1e-11)
    # Turning the mounts does what turning the motors does.
    np.testing.assert_allclose(
        by_robot.legs.base_rotation[2:, :, 0], by_motors_held[1][2:], rtol=0, atol=1e-10
    )


def test_compliance_of_the_platform_is_symmetric(off_axis, by_motors_held, slopes):
    """Dead loads are conservative; with the moment row as (15) prints it, the legs are not."""
    compliance = np.asarray(by_motors_held[0].f_P[2:4])
    np.testing.assert_allclose(compliance, compliance.T, rtol=0, atol=1e-11)
    assert np.all(np.linalg.eigvalsh(compliance) > 0.0)
    printed = rfrfr(printed_moment_row=True)
    equilibrium = solve_inverse(printed, off_axis.q_p)
    by_robot, _ = slopes(printed, equilibrium.q_a, equilibrium)
    skewed = np.asarray(by_robot.f_P[2:4])
    assert abs(skewed[0, 1] - skewed[1, 0]) > 1e-3 * np.max(np.abs(skewed))


def test_reverse_mode_equals_forward_mode(paper, off_axis, by_motors_held):
    target = jnp.concatenate([off_axis.q_a, jnp.zeros(2)])

    def root(robot):
        return find_root(Problem(robot, forward_rows(paper), target), off_axis.y).y

    reverse = jax.jit(jax.jacrev(root))(paper)
    for name, leaf in LEAVES.items():
        forward = leaf(by_motors_held[0])
        np.testing.assert_allclose(
            leaf(reverse), forward, rtol=0, atol=1e-10 * scale(forward), err_msg=name
        )
