"""The paper's robot at points that the tests of this folder share."""

import jax
import pytest

import cpr_jax as cpr


@pytest.fixture(scope="session")
def robot() -> cpr.Robot:
    return cpr.rfrfr()


@pytest.fixture(scope="session")
def equilibria(robot) -> dict[tuple[float, float], cpr.Equilibrium]:
    return {point: cpr.solve_inverse(robot, point) for point in ((0.0, 0.2), (0.06, 0.15))}


@pytest.fixture(scope="session")
def platform(robot, equilibria):
    """p_P of given parameters, the motors held: the whole nonlinear solve, compiled once."""
    from cpr_jax.analysis.parameters import select

    labels = ("k_b1", "r_c1", "k_b2", "r_c2", "l1", "a2", "b1", "base1_y", "f_P_z")
    selection = select(robot, labels)
    nominal = equilibria[0.06, 0.15]

    @jax.jit
    def solve(rho):
        varied = selection.set(robot, rho)
        held = jax.numpy.asarray(nominal.q_a)
        return cpr.solve_forward(varied, held, guess=nominal, throw=False).y

    return selection, solve
