"""Random planar robots against plain shooting and against a discretised energy."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate

from cpr_jax.statics.problem import Problem, inverse_rows
from cpr_jax.statics.roots import find_root
from cpr_jax.statics.solve import solve_forward, solve_inverse
from cpr_jax.statics.status import Status
from tests.oracles import discrete_energy, planar_shooting
from tests.oracles.planar_shooting import PlanarRobot
from tests.statics.common import from_oracle, torques_are_slopes_of_the_energy


def random_robot(seed, printed=False):
    """Every number of the paper's robot changed by up to a few tens of percent."""
    rng = np.random.default_rng(seed)

    def pair(value, spread=0.2):
        return tuple(value * (1.0 + spread * rng.uniform(-1.0, 1.0, 2)))

    return PlanarRobot(
        l=pair(0.25, 0.1),
        a=pair(0.045),
        b=pair(0.035),
        d=0.2 * (1.0 + 0.2 * rng.uniform(-1.0, 1.0)),
        k_b=pair(0.0183, 0.4),
        curvature=tuple(np.array([-1.0, 1.0]) * rng.uniform(0.5, 1.5, 2)),
        f_P=tuple(rng.uniform(-1.5, 1.5, 2)),
        printed=printed,
    )


def nudged(y, seed=0):
    """A guess that gives nothing away: every unknown is off by about a percent."""
    rng = np.random.default_rng(seed)
    return np.asarray(y) * (1.0 + 0.01 * rng.normal(size=len(y)))


@pytest.mark.parametrize("printed", [False, True], ids=["pivot", "printed row"])
@pytest.mark.parametrize("seed", range(4))
def test_inverse_and_forward_problem_of_random_robots(seed, printed):
    oracle = random_robot(seed, printed)
    robot = from_oracle(oracle)
    point = np.random.default_rng(seed + 50).uniform([-0.08, 0.14], [0.08, 0.22])
    inverse = solve_inverse(robot, point)
    expected = planar_shooting.inverse(oracle, point, nudged(inverse.y))
    np.testing.assert_allclose(inverse.y, expected, rtol=0, atol=1e-9)

    q_a = inverse.q_a + np.array([0.05, -0.03])
    forward = solve_forward(robot, q_a, guess=inverse)
    expected = planar_shooting.forward(oracle, q_a, nudged(forward.y))
    np.testing.assert_allclose(forward.y, expected, rtol=0, atol=1e-9)


def test_the_moment_row_matters():
    """The two readings of (15) are different robots where b is not zero."""
    motors = [solve_inverse(from_oracle(random_robot(0, p)), (0.03, 0.18)).q_a for p in (0, 1)]
    assert np.max(np.abs(motors[0] - motors[1])) > 1e-3


def test_distributed_load(paper, nominal):
    """Weight, a push to the side and a distributed couple on both rods."""
    load = (0.4, -0.9, 0.02)
    robot = eqx.tree_at(
        lambda r: (r.legs.rod.force, r.legs.rod.moment),
        paper,
        (jnp.tile(jnp.array(load[:2]), (2, 1)), jnp.full((2, 1), load[2])),
        is_leaf=lambda leaf: leaf is None,
    )
    point = np.array([0.02, 0.19])
    target = jnp.asarray([0.0, 0.0, *point])
    problem = Problem(robot, inverse_rows(robot), target)
    found = jax.jit(find_root)(problem, nominal.y)
    assert int(found.status) == Status.SOLVED
    oracle = PlanarRobot(load=load)
    expected = planar_shooting.inverse(oracle, point, nudged(found.y))
    np.testing.assert_allclose(found.y, expected, rtol=0, atol=1e-9)
    assert np.max(np.abs(found.y - solve_inverse(paper, point).y)) > 1e-2


@pytest.fixture(scope="module")
def held():
    """A random robot, its equilibrium, and the discretised one at the same motor angles."""
    oracle = random_robot(1)
    solved = solve_inverse(from_oracle(oracle), (0.05, 0.17))
    coarse, fine = (
        discrete_energy.equilibrium(
            oracle, discrete_energy.angles_along(oracle, np.asarray(solved.y), links)
        )
        for links in (60, 120)
    )

    def limit(name):
        """Richardson: the discretisation errs by a multiple of h²."""
        return (4.0 * getattr(fine, name) - getattr(coarse, name)) / 3.0

    return oracle, solved, limit, fine


def test_energy_and_motor_torques_of_the_discretised_robot(held):
    _, solved, limit, _ = held
    np.testing.assert_allclose(solved.measures.energy, limit("energy"), rtol=1e-6)
    np.testing.assert_allclose(solved.motor_torques, limit("torques"), rtol=1e-6)


def test_platform_and_tip_force_of_the_discretised_robot(held):
    oracle, solved, limit, _ = held
    np.testing.assert_allclose(solved.q_p, limit("point"), rtol=0, atol=1e-7)
    y = np.asarray(solved.y)
    tip = planar_shooting.leg_tip(oracle, 1, y[1], y[7:10])
    np.testing.assert_allclose(tip.force, limit("force"), rtol=1e-5)


def test_bows_of_the_rods(held):
    """Mean distance from the line between base and pivot, to its left, by Simpson's rule."""
    oracle, solved, *_ = held
    y = np.asarray(solved.y)
    for leg in range(2):
        s = np.linspace(0.0, oracle.l[leg], 201)
        mu = y[4 + 3 * leg : 7 + 3 * leg]
        shape = planar_shooting.integrate(oracle, leg, y[leg], mu, t_eval=s).y
        base, line = shape[:2, :1], y[2:4] - shape[:2, 0]
        along = line / np.linalg.norm(line)
        distance = along[0] * (shape[1] - base[1]) - along[1] * (shape[0] - base[0])
        bow = scipy.integrate.simpson(distance, x=s) / oracle.l[leg] ** 2
        np.testing.assert_allclose(solved.measures.bows[leg], bow, rtol=1e-8)
    # Outward: the left leg bows to the left of its way up, the right one to the right.
    assert solved.measures.bows[0] > 0.0 > solved.measures.bows[1]


def test_the_outward_branch_is_stable(held):
    *_, fine = held
    assert fine.index == 0


def test_motor_torque_is_the_derivative_of_the_energy(paper, nominal):
    center = solve_inverse(paper, (0.05, 0.17))
    torques_are_slopes_of_the_energy(paper, center, nominal)


def test_along_a_path_of_the_platform_only_the_motors_do_work(paper, nominal):
    """`dE = τ · dq_a`: the potential of the force on the platform is a part of E."""
    point, step = np.array([0.05, 0.17]), 1e-4
    center = solve_inverse(paper, point)
    for unit in np.eye(2):
        above, below = (
            solve_inverse(paper, point + sign * step * unit, guess=nominal) for sign in (1.0, -1.0)
        )
        slope = (above.measures.energy - below.measures.energy) / (2.0 * step)
        turned = (above.q_a - below.q_a) / (2.0 * step)
        np.testing.assert_allclose(slope, center.motor_torques @ turned, rtol=1e-5)


def test_mirrored_point_gives_the_mirrored_solution(paper):
    """Reflection in the z-axis swaps the legs and turns `q` into `π - q`."""
    left, right = (solve_inverse(paper, (side * 0.07, 0.16)) for side in (-1.0, 1.0))
    np.testing.assert_allclose(left.q_a, np.pi - right.q_a[::-1], rtol=0, atol=1e-11)
    np.testing.assert_allclose(
        left.mu, right.mu[::-1] * np.array([-1.0, 1.0, -1.0]), rtol=0, atol=1e-9
    )
    for name in ("energy", "sigma_t1", "sigma_t2"):
        a, b = getattr(left.measures, name), getattr(right.measures, name)
        np.testing.assert_allclose(a, b, rtol=1e-8)


def test_a_scaled_robot_has_a_scaled_solution(paper):
    """Lengths by λ, stiffness by λ² and force by 1: the angles stay, moments grow by λ."""
    factor = 1.7
    oracle = PlanarRobot(f_P=(0.3, 0.8))
    scaled = dataclasses.replace(
        oracle,
        **{name: tuple(factor * np.array(getattr(oracle, name))) for name in ("l", "a", "b")},
        d=factor * oracle.d,
        k_b=tuple(factor**2 * np.array(oracle.k_b)),
        curvature=tuple(np.array(oracle.curvature) / factor),
    )
    small = solve_inverse(from_oracle(oracle), (0.04, 0.18))
    robot = from_oracle(scaled)
    robot = eqx.tree_at(lambda r: r.home.q_p, robot, factor * robot.home.q_p)
    large = solve_inverse(robot, factor * np.array([0.04, 0.18]))
    np.testing.assert_allclose(large.q_a, small.q_a, rtol=0, atol=1e-10)
    np.testing.assert_allclose(large.mu, small.mu * np.array([1.0, 1.0, factor]), rtol=0, atol=1e-9)
