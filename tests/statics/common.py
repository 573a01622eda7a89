"""Robots of one structure, so that one compiled solve serves all planar tests."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.robots.robot import Home
from cpr_jax.statics.solve import solve_forward
from tests.oracles.planar_shooting import PlanarRobot

LANES = 300
"""Length of every batch."""


def like_rfrfr(robot):
    """A planar robot of two legs with the labels of the paper's, which decide on recompiling."""
    paper = rfrfr()
    return dataclasses.replace(robot, name=paper.name, uncertainty=paper.uncertainty)


def from_oracle(oracle: PlanarRobot):
    """The package's robot with the numbers of the oracle's, without distributed load."""
    robot = rfrfr(d=oracle.d, f_P=oracle.f_P, printed_moment_row=oracle.printed)
    segments = np.zeros((2, 2, 2))
    segments[0, :, 0], segments[1, :, 0] = oracle.a, oracle.b
    return eqx.tree_at(
        lambda r: (
            r.legs.a,
            r.legs.b,
            r.legs.rod.length,
            r.legs.rod.curvature_compliance,
            r.legs.rod.precurvature,
        ),
        robot,
        (
            jnp.asarray(segments[0]),
            jnp.asarray(segments[1]),
            jnp.asarray(oracle.l),
            1.0 / jnp.asarray(oracle.k_b)[:, None],
            jnp.asarray(oracle.curvature)[:, None],
        ),
    )


def with_stiffness(robot, k_b):
    """The robot with other bending stiffnesses, one a leg."""
    return eqx.tree_at(lambda r: r.legs.rod.curvature_compliance, robot, 1.0 / k_b[:, None])


def home_at(robot, q_a, q_p):
    """The robot with another home."""
    return dataclasses.replace(robot, home=Home(jnp.asarray(q_a, float), jnp.asarray(q_p, float)))


def in_space_unknowns(spatial, y):
    """Unknowns of a planar robot as those of the same robot in space."""
    n, n_a = spatial.n, spatial.n_a
    q_a, q_p, mu = jnp.split(y, [n_a, y.size - 3 * n])
    position = jnp.concatenate([jnp.zeros(1), q_p[:2]])
    turn = jnp.pad(q_p[2:], (0, 2 * (q_p.size - 2)))
    wrenches = jnp.pad(mu.reshape(n, 3), ((0, 0), (1, 2)))
    return jnp.concatenate([q_a, position, turn, wrenches.reshape(-1)])


def torques_are_slopes_of_the_energy(robot, equilibrium, guess):
    """Work of the motors, by central differences of equilibria with the motors held."""
    step = 1e-4
    for torque, unit in zip(equilibrium.motor_torques, np.eye(robot.n_a), strict=True):
        above, below = (
            solve_forward(robot, equilibrium.q_a + sign * step * unit, guess=guess).measures.energy
            for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(torque, (above - below) / (2.0 * step), rtol=1e-6)
