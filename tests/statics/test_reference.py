"""Published and analytic cases of planar robots, each digit of them."""

import dataclasses
import json
import pathlib

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize

from cpr_jax.statics.measures import measure
from cpr_jax.statics.shape import shape
from cpr_jax.statics.solve import solve_forward, solve_inverse
from cpr_jax.statics.status import Status

CASES = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())


def nine_digits(found, expected):
    expected = np.asarray(expected)
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * scale)


def test_the_paper_s_robot_at_its_first_point(nominal):
    case = CASES["rfrfr_paper"]["inverse"]
    nine_digits(nominal.q_a, case["q_rad"])
    nine_digits(nominal.q_p, case["point"])
    nine_digits(nominal.mu[0], [*case["n_1_base"], case["m_1_base"]])
    nine_digits(nominal.mu[1], [*case["n_2_base"], case["m_2_base"]])
    assert int(nominal.status) == Status.SOLVED
    assert float(nominal.residual) < 1e-10


def test_y_lists_motors_platform_and_wrenches(nominal):
    case = CASES["rfrfr_paper"]["inverse"]
    wrenches = [*case["n_1_base"], case["m_1_base"], *case["n_2_base"], case["m_2_base"]]
    nine_digits(nominal.y, [*case["q_rad"], *case["point"], *wrenches])


def test_the_forward_problem_returns_to_the_point(paper, nominal):
    back = solve_forward(paper, nominal.q_a)
    np.testing.assert_allclose(back.q_p, [0.0, 0.2], rtol=0, atol=1e-11)
    np.testing.assert_allclose(back.y, nominal.y, rtol=0, atol=1e-9)


def test_forward_and_inverse_agree_off_the_axis(paper, nominal):
    """From home and from a neighbour, through both problems, all are one branch."""
    point = np.array([0.06, 0.15])
    inverse = solve_inverse(paper, point)
    forward = solve_forward(paper, inverse.q_a, guess=nominal)
    neighbour = solve_inverse(paper, point, guess=nominal)
    np.testing.assert_allclose(forward.q_p, point, rtol=0, atol=1e-11)
    np.testing.assert_allclose(neighbour.y, inverse.y, rtol=0, atol=1e-9)
    assert (inverse.branch, forward.branch) == ("home", "home")


def test_the_straight_robot(straight):
    case = CASES["rfrfr_straight"]["forward"]
    found = solve_forward(straight, np.deg2rad(case["tangent_angles_deg"]))
    assert found.q_p[1] == pytest.approx(case["p"][1], rel=1e-9)
    assert found.q_p[0] == pytest.approx(0.0, abs=1e-10)
    nine_digits(found.mu[0], [*case["n_1"], case["m_1_base"]])
    rotation = shape(straight, found, points=17).rods.rotation[0, -1]
    nine_digits(np.arctan2(rotation[1], rotation[0]), case["theta_1_tip"])


@pytest.fixture(scope="module")
def apex(straight):
    """Measures of the straight robot with straight legs under a downward force."""
    height = np.sqrt(0.96)

    @jax.jit
    def measures(load):
        robot = dataclasses.replace(straight, f_P=jnp.stack([0.0 * load, -load]))
        # Each leg carries half of the load as a push along its axis.
        push = load / (2.0 * height)
        legs = [jnp.array([0.2, height]), jnp.array([-0.2, height])]
        q = [jnp.arctan2(leg[1], leg[0]) for leg in legs]
        wrench = [jnp.array([-push * leg[0], -push * leg[1], 0.0]) for leg in legs]
        y = jnp.concatenate([jnp.stack(q), jnp.array([0.0, height]), *wrench])
        return measure(robot, y, 10)

    return measures


def test_straight_legs_are_an_equilibrium_at_any_load(apex):
    for load in (0.0, 3.0, 8.0):
        _, residual = apex(load)
        assert float(residual) < 1e-12


def test_a_type_2_singularity_where_straight_legs_buckle(apex):
    """σ_min vanishes at the critical load, though the determinant keeps its sign."""
    case = CASES["buckling_t2"]
    found = scipy.optimize.minimize_scalar(
        lambda load: float(apex(load)[0].sigma_t2), bounds=(5.0, 7.5), options={"xatol": 1e-10}
    )
    assert found.x == pytest.approx(case["critical_downward_force_N"], rel=1e-6)
    assert found.fun < 1e-6 * float(apex(5.0)[0].sigma_t2)
    below, above = apex(0.99 * found.x)[0], apex(1.01 * found.x)[0]
    assert float(below.sign_t2) == float(above.sign_t2)
    assert float(apex(found.x)[0].condition) > 1e6
