"""Robots and compiled solves that the tests of the statics share.

All planar robots here have the structure of the paper's robot, so that one compiled solve serves
them all; batches have one length for the same reason.
"""

import dataclasses
import json
import pathlib

import jax
import jax.numpy as jnp
import pytest

from cpr_jax.robots.catalogue import rfrfr, rfrfr_straight
from cpr_jax.statics.solve import solve_forward, solve_inverse
from tests.statics.common import like_rfrfr, with_stiffness

REFERENCE = pathlib.Path(__file__).parents[1] / "reference_cases.json"


@pytest.fixture(scope="session")
def paper():
    """The robot of Table 1."""
    return rfrfr()


@pytest.fixture(scope="session")
def nominal(paper):
    """Its equilibrium with the end-effector at (0, 200) mm."""
    return solve_inverse(paper, (0.0, 0.2))


@pytest.fixture(scope="session")
def straight():
    """The robot with straight rods."""
    return like_rfrfr(rfrfr_straight())


@pytest.fixture(scope="session")
def pushed(straight):
    """The straight robot, its motors at 120° and 60°, under a load to the side."""
    robot = dataclasses.replace(straight, f_P=jnp.array([0.15, -0.1]))
    return robot, solve_forward(robot, robot.home.q_a)


@pytest.fixture(scope="session")
def published():
    """The unknowns of the published equilibrium of the paper's robot, its point at (0, 200) mm."""
    case = json.loads(REFERENCE.read_text())["rfrfr_paper"]["inverse"]
    legs = [*case["n_1_base"], case["m_1_base"], *case["n_2_base"], case["m_2_base"]]
    return jnp.array([*case["q_rad"], *case["point"], *legs])


@pytest.fixture(scope="session")
def batch(paper):
    """`batch(k_b, points)`: inverse solves from home, and gradients of their first motor angle.

    Returns the equilibria, and the gradients in the stiffnesses and in the point.
    """

    @jax.jit
    @jax.vmap
    def solve(k_b, point):
        def angle(k_b, point):
            equilibrium = solve_inverse(with_stiffness(paper, k_b), point, throw=False)
            return equilibrium.q_a[0], equilibrium

        gradients, equilibrium = jax.grad(angle, argnums=(0, 1), has_aux=True)(k_b, point)
        return equilibrium, gradients

    return solve
