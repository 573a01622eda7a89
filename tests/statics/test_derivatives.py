"""Derivatives of equilibria: identities of mechanics, both modes, both orders, differences."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.equilibrium import solve_forward, solve_inverse
from cpr_jax.statics.problem import Problem, find_root, forward_rows, inverse_rows
from tests.statics.common import with_stiffness


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
        np.testing.assert_allclose(jacobian[(..., *at)], expected, atol=1e-6 * scale(expected))


def scale(values):
    return max(1.0, np.max(np.abs(values)))


def test_jacobian_in_the_motor_angles(paper, off_axis, by_motors_held):
    step = 1e-5
    for i, unit in enumerate(step * np.eye(2)):
        above, below = (
            solve_forward(paper, off_axis.q_a + sign * unit, guess=off_axis).y for sign in (1, -1)
        )
        expected = (above - below) / (2.0 * step)
        np.testing.assert_allclose(by_motors_held[1][:, i], expected, atol=1e-6 * scale(expected))
    # The motors are held, and each moves with its own angle.
    np.testing.assert_allclose(by_motors_held[1][:2], np.eye(2), atol=1e-14)


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
    np.testing.assert_allclose(change[:4], 0.0, atol=1e-10)
    np.testing.assert_allclose(change[4:], equilibrium.mu.reshape(-1), atol=1e-9)


def test_moving_and_turning_the_whole_robot(paper, off_axis, by_motors_held):
    """Shifting both motors shifts the platform and changes no angle and no wrench."""
    by_robot, _ = by_motors_held
    shift = np.asarray(by_robot.legs.base_position).sum(axis=1)
    expected = np.zeros_like(shift)
    expected[2:4] = np.eye(2)
    np.testing.assert_allclose(shift, expected, atol=1e-11)
    # Turning the mounts does what turning the motors does.
    np.testing.assert_allclose(
        by_robot.legs.base_rotation[2:, :, 0], by_motors_held[1][2:], atol=1e-10
    )


def test_compliance_of_the_platform_is_symmetric_with_the_pivot_s_moment(
    paper, off_axis, by_motors_held, slopes
):
    """Dead loads are conservative; (15) as printed is not in equilibrium unless b = 0."""
    compliance = np.asarray(by_motors_held[0].f_P[2:4])
    np.testing.assert_allclose(compliance, compliance.T, rtol=1e-10)
    assert np.all(np.linalg.eigvalsh(compliance) > 0.0)
    printed = eqx.tree_at(lambda r: r.legs.joint.lever, paper, jnp.zeros(2))
    equilibrium = solve_inverse(printed, off_axis.q_p)
    by_robot, _ = slopes(printed, equilibrium.q_a, equilibrium)
    skewed = np.asarray(by_robot.f_P[2:4])
    assert abs(skewed[0, 1] - skewed[1, 0]) > 0.01 * np.max(np.abs(skewed))


@pytest.fixture(scope="module")
def root_at(off_axis):
    """`root_at(imposed, target)(robot)`: the root as a function of the robot alone."""

    def with_target(imposed, target):
        return lambda robot: find_root(Problem(robot, imposed, target), off_axis.y).y

    return with_target


def test_reverse_mode_equals_forward_mode(paper, off_axis, by_motors_held):
    target = jnp.concatenate([off_axis.q_a, jnp.zeros(2)])

    def root(robot):
        return find_root(Problem(robot, forward_rows(paper), target), off_axis.y).y

    reverse = jax.jit(jax.jacrev(root))(paper)
    for name, leaf in LEAVES.items():
        forward = leaf(by_motors_held[0])
        np.testing.assert_allclose(
            leaf(reverse), forward, atol=1e-10 * scale(forward), err_msg=name
        )


@pytest.fixture(scope="module")
def scalar(paper, off_axis):
    """Any combination of all unknowns with the platform held, in stiffnesses and curvatures."""
    weights = jnp.asarray(np.random.default_rng(0).normal(size=paper.n_y))
    target = jnp.concatenate([jnp.zeros(2), off_axis.q_p])

    def value(rho):
        robot = with_stiffness(paper, 0.01 * rho[:2])
        robot = eqx.tree_at(lambda r: r.legs.rod.precurvature, robot, rho[2:, None])
        return weights @ find_root(Problem(robot, inverse_rows(robot), target), off_axis.y).y

    return value, jnp.array([1.83, 1.83, -1.0, 1.0])


@pytest.fixture(scope="module")
def gradient(scalar):
    return jax.jit(jax.grad(scalar[0]))


@pytest.fixture(scope="module")
def forward_hessian(scalar):
    value, rho = scalar
    return np.asarray(jax.jit(jax.jacfwd(jax.jacfwd(value)))(rho))


def test_second_derivatives_against_differences(scalar, gradient, forward_hessian):
    _, rho = scalar
    step = 1e-4
    columns = [
        (gradient(rho + step * unit) - gradient(rho - step * unit)) / (2.0 * step)
        for unit in np.eye(4)
    ]
    expected = np.stack(columns, axis=1)
    np.testing.assert_allclose(forward_hessian, expected, atol=1e-5 * scale(expected))
    assert np.max(np.abs(expected)) > 0.1


def test_second_derivatives_in_forward_and_in_reverse(scalar, forward_hessian):
    value, rho = scalar
    reverse = jax.jit(jax.jacrev(jax.grad(value)))(rho)
    np.testing.assert_allclose(reverse, forward_hessian, atol=1e-10 * scale(forward_hessian))
    np.testing.assert_allclose(forward_hessian, forward_hessian.T, atol=1e-9)


def test_guess_and_number_of_iterations_do_not_change_a_derivative(paper, off_axis, gradient):
    """The implicit derivative belongs to the root, not to the way to it."""
    near = dataclasses.replace(off_axis, q_a=off_axis.q_a + 0.01)
    assert np.max(np.abs(near.y - off_axis.y)) > 5e-3
    target = jnp.concatenate([jnp.zeros(2), off_axis.q_p])

    @jax.jit
    def slope(guess):
        def root(point):
            goal = target.at[2:].set(point)
            return find_root(Problem(paper, inverse_rows(paper), goal), guess).y

        return jax.jacfwd(root)(off_axis.q_p)

    np.testing.assert_allclose(slope(near.y), slope(off_axis.y), atol=1e-9)
