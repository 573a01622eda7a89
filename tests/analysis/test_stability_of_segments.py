"""Stability of robots with rods of several segments."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq

import cpr_jax as cpr
from cpr_jax.geometry import PLANE
from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.robots.embedding import in_space
from cpr_jax.robots.joint import clamped
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.rods.segments import segmented_rod
from tests.analysis.test_stability import at, by_chains, in_blocks, random_equilibria
from tests.statics.segmented import stepped

SHARES = [(1.0,), (7 / 12, 5 / 12), (0.25, 0.5, 0.25)]

judged = in_blocks(lambda robot, y: cpr.stability(robot, at(robot, y)), 40)


def test_index_of_random_equilibria():
    """Unlike segments, against chains of rigid links; stiffness as well."""
    robot = stepped(three_rfr(), SHARES, seed=7, spread=0.6)
    anywhere = {"place": 0.3, "turn": 1.5}
    held, free = {**anywhere, "force": 12.0}, {**anywhere, "force": 8.0}
    y = random_equilibria(robot, 1600, held=held, free=free)
    chains = by_chains(robot, y)
    sure = ~chains.doubtful & (chains.moved < 0.01)
    result = judged(robot, y)
    np.testing.assert_array_equal(result.index[sure], chains.index[sure])
    np.testing.assert_array_equal(result.leg_indices[sure], chains.leg_indices[sure])
    assert np.mean(sure) > 0.9 and np.sum(sure) > 150
    assert np.sum(chains.index[sure] >= 1) > 40
    forces = np.max(np.abs(y[:, 6:].reshape(len(y), 3, 3)[:, :, :2]), axis=(1, 2))
    few = y[np.argsort(forces)[:4]]
    K = np.asarray(judged(robot, few).platform_stiffness)
    coarse, fine = (by_chains(robot, few, links).stiffness for links in (120, 240))
    size = np.max(np.abs(K), axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(K / size, (4.0 * fine - coarse) / 3.0 / size, rtol=0, atol=1e-5)


def column(force, first, second):
    """A column, clamped at its base, that a dead load compresses at its free end."""
    rod = segmented_rod([kirchhoff_rod(PLANE, *first), kirchhoff_rod(PLANE, *second)])
    leg = make_leg(PLANE, (0.0, 0.0), rod, joint=clamped(PLANE))
    robot = make_robot(PLANE, [leg], oriented=True, f_P=(-force, 0.0))
    return robot, jnp.array([0.0, first[0] + second[0], 0.0, 0.0, -force, 0.0, 0.0])


def critical_forces(first, second, highest):
    """Roots of `tan(α₁ l₁) tan(α₂ l₂) = α₂ / α₁`, `α = √(P / k_b)`, up to a force."""
    (l_1, k_1), (l_2, k_2) = first, second

    def gap(P):
        a_1, a_2 = np.sqrt(P / k_1), np.sqrt(P / k_2)
        x, y = a_1 * l_1, a_2 * l_2
        return a_1 * np.sin(x) * np.sin(y) - a_2 * np.cos(x) * np.cos(y)

    grid = np.linspace(1e-6, highest, 4001)
    signs = np.sign([gap(P) for P in grid])
    return [brentq(gap, grid[k], grid[k + 1]) for k in np.flatnonzero(np.diff(signs))]


@pytest.mark.parametrize(("first", "second"), [((0.6, 1.0), (0.4, 0.2)), ((0.3, 0.15), (0.7, 1.0))])
def test_stepped_column(first, second):
    """The index of a stepped cantilever column jumps where closed forms say; twofold in space."""
    critical = critical_forces(first, second, 60.0)
    assert len(critical) >= 3
    for mode, P in enumerate(critical[:3]):
        for factor, index in ((1.0 - 3e-3, mode), (1.0 + 3e-3, mode + 1)):
            robot, y = column(factor * P, first, second)
            assert int(judged(robot, y[None]).index[0]) == index
            # In the axes (x, y, z) of space: motor, position, rotation, force, moment.
            y = jnp.array([0.0, 0.0, float(y[1]), *[0.0] * 5, -factor * P, *[0.0] * 4])
            assert int(judged(in_space(robot), y[None]).index[0]) == 2 * index
        # Eigenvalues of the platform's stiffness change their signs there to many more digits.
        for factor, index in ((1.0 - 1e-5, mode), (1.0 + 1e-5, mode + 1)):
            robot, y = column(factor * P, first, second)
            found = judged(robot, y[None])
            negative = np.sum(np.linalg.eigvalsh(found.platform_stiffness[0]) < 0.0)
            assert negative + found.leg_indices[0, 0] == index


def test_what_uniform_columns_say():
    """The closed form is Euler's, and another one than for the stiffness at either end."""
    uniform = critical_forces((0.5, 1.0), (0.5, 1.0), 60.0)
    np.testing.assert_allclose(uniform, (np.pi * np.array([0.5, 1.5])) ** 2, rtol=1e-9)
    first, second = (0.6, 1.0), (0.4, 0.2)
    robot, y = column(1.01 * critical_forces(first, second, 60.0)[0], first, second)
    softer = dataclasses.replace(robot.legs.rod, curvature_compliance=jnp.array([[5.0]]))
    stiffer = dataclasses.replace(
        robot.legs.rod,
        further=dataclasses.replace(
            robot.legs.rod.further, curvature_compliance=jnp.array([[[1.0]]])
        ),
    )
    for rod, index in ((softer, 1), (stiffer, 0)):
        changed = dataclasses.replace(robot, legs=dataclasses.replace(robot.legs, rod=rod))
        assert int(judged(changed, y[None]).index[0]) == index
