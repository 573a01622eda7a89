"""Π_y against differences of whole solves, published numbers and identities."""

import json
import pathlib

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr

CASE = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())[
    "rfrfr_paper"
]


def differences(solve, rho, relative):
    """Central differences, extrapolated once: errors of the order of h⁴."""
    columns = []
    for k, value in enumerate(rho):
        h = relative * max(abs(value), 0.05)

        def slope(h, k=k):
            step = np.eye(len(rho))[k] * h
            return (np.asarray(solve(rho + step)) - np.asarray(solve(rho - step))) / (2 * h)

        columns.append((4 * slope(h / 2) - slope(h)) / 3)
    return np.stack(columns, axis=1)


def test_semi_axes_of_the_paper_robot(robot, equilibria):
    ellipse = cpr.ellipsoid(cpr.sensitivity(robot, equilibria[0.0, 0.2]))
    np.testing.assert_allclose(ellipse.semi_axes, CASE["semi_axes_m"], rtol=2e-9)
    np.testing.assert_allclose(np.abs(ellipse.directions), np.eye(2), atol=1e-9)


def test_all_kinds_of_parameters_against_differences(robot, equilibria, platform):
    selection, solve = platform
    nominal = equilibria[0.06, 0.15]
    result = cpr.sensitivity(robot, nominal, selection.labels, dict.fromkeys(selection.labels, 1.0))
    expected = differences(solve, np.asarray(selection.get(robot)), 1e-3)
    scale = np.max(np.abs(expected), axis=0)
    np.testing.assert_allclose(result.Pi_y / scale, expected / scale, atol=1e-6)


def test_formula_agrees_with_autodiff_through_the_solve(robot, equilibria, platform):
    selection, solve = platform
    rho = selection.get(robot)
    result = cpr.sensitivity(
        robot, equilibria[0.06, 0.15], selection.labels, dict.fromkeys(selection.labels, 1.0)
    )
    scale = jnp.max(jnp.abs(result.Pi_y), axis=0)
    np.testing.assert_allclose(jax.jacfwd(solve)(rho) / scale, result.Pi_y / scale, atol=1e-9)


def test_platform_held_moves_motors_only(robot, equilibria):
    nominal = equilibria[0.06, 0.15]
    held = cpr.sensitivity(robot, nominal, hold="platform")
    np.testing.assert_array_equal(held.Pi_p, 0.0)

    def inverse(k_b1):
        varied = cpr.rfrfr(k_b=(k_b1, 0.0183))
        return np.asarray(cpr.solve_inverse(varied, nominal.q_p, guess=nominal).q_a)

    h = 1e-5
    slope = (inverse(0.0183 + h) - inverse(0.0183 - h)) / (2 * h)
    np.testing.assert_allclose(held.Pi("q1")[:, 0], slope[0], rtol=1e-5)
    np.testing.assert_allclose(held.Pi("q2")[:, 0], slope[1], rtol=1e-5)


def test_the_two_holds_are_one_linear_map(robot, equilibria):
    """What the motors must do to undo the platform's motion: Π_p + (∂p/∂q_a) Π_qa = 0."""
    nominal = equilibria[0.06, 0.15]
    moved = cpr.sensitivity(robot, nominal).Pi_p
    undone = cpr.sensitivity(robot, nominal, hold=cpr.Hold.PLATFORM).Pi(("q1", "q2"))

    def platform_of(q_a):
        return cpr.solve_forward(robot, q_a, guess=nominal, throw=False).q_p

    manipulator = jax.jit(jax.jacfwd(platform_of))(nominal.q_a)
    np.testing.assert_allclose(moved + manipulator @ undone, 0.0, atol=1e-9)


def test_motor_torques_follow_by_differences(robot, equilibria):
    nominal = equilibria[0.06, 0.15]
    result = cpr.sensitivity(robot, nominal, ["f_P_y"], {"f_P_y": 0.1})

    def torques(force):
        varied = cpr.rfrfr(f_P=(force, 1.0))
        return np.asarray(cpr.solve_forward(varied, nominal.q_a, guess=nominal).motor_torques)

    slope = (torques(1e-4) - torques(-1e-4)) / 2e-4
    np.testing.assert_allclose(result.Pi_tau[:, 0], slope, rtol=1e-6)


def test_stiffness_is_symmetric_with_the_pivot_row_only(robot, equilibria):
    for point, nominal in equilibria.items():
        K = np.asarray(cpr.sensitivity(robot, nominal).platform_stiffness)
        assert np.max(np.abs(K - K.T)) < 1e-9 * np.max(np.abs(K)), point
    printed = cpr.rfrfr(printed_moment_row=True)
    other = cpr.solve_inverse(printed, (0.06, 0.15))
    K = np.asarray(cpr.sensitivity(printed, other).platform_stiffness)
    assert np.max(np.abs(K - K.T)) > 1e-4 * np.max(np.abs(K))


def test_stiffness_is_the_force_that_moves_the_platform(robot, equilibria):
    nominal = equilibria[0.06, 0.15]
    result = cpr.sensitivity(robot, nominal, ["f_P_y", "f_P_z"], {"f_P_y": 1.0, "f_P_z": 1.0})
    np.testing.assert_allclose(result.Pi_p @ result.platform_stiffness, np.eye(2), atol=1e-8)


def test_kernel_and_tube(robot, equilibria):
    result = cpr.sensitivity(robot, equilibria[0.06, 0.15])
    W = np.diag(np.asarray(result.delta) ** 2)
    kernel = np.asarray(result.Pi_y) @ W @ np.asarray(result.Pi_y).T
    np.testing.assert_allclose(result.kernel, kernel, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(result.tube_radius, np.sqrt(np.diag(kernel)), rtol=1e-12)


def test_selection_by_path_is_the_selection_by_name(robot, equilibria):
    nominal = equilibria[0.06, 0.15]
    named = cpr.sensitivity(robot, nominal, ["l2"], {"l2": 1.0})
    label = "legs.rod.length[1]"
    by_path = cpr.sensitivity(robot, nominal, [label], {label: 1.0})
    np.testing.assert_array_equal(named.Pi_y, by_path.Pi_y)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"parameters": ["k_b3"]}, "k_b3"),
        ({"parameters": ["k_b0"]}, "k_b0"),
        ({"parameters": ["stiffness"]}, "stiffness"),
        ({"parameters": ["k_t1"]}, "k_t1"),
        ({"parameters": ["base1_x"]}, "base1_x"),
        ({"parameters": ["f1_y"]}, "f1_y"),
        ({"parameters": ["legs.rod.width[0]"]}, "legs.rod.width"),
        ({"parameters": ["legs.rod.length[7]"]}, "legs.rod.length"),
        ({"parameters": [5]}, "it names 5"),
        ({"parameters": 5}, "it names 5"),
        ({"parameters": ["l1"]}, "l1"),
        ({"delta": {"l1": 0.1}}, "l1"),
        ({"parameters": []}, "`parameters` must name at least one"),
        ({"parameters": ["k_b1", "k_b1"]}, "'k_b1' and 'k_b1' are the same"),
        ({"parameters": ["r_c1", "kappa1"]}, "'r_c1' and 'kappa1' are the same"),
        ({"parameters": ["k_b2", "legs.rod.curvature_compliance[1, 0]"]}, "are the same"),
        ({"delta": {"k_b1": -0.1}}, "k_b1"),
        ({"delta": {"k_b1": "2mm"}}, "k_b1"),
        ({"delta": {"k_b1": np.nan}}, "k_b1"),
        ({"delta": {"k_b1": np.inf}}, "k_b1"),
        ({"delta": {"k_b1": (0.1, 0.2)}}, "k_b1"),
        ({"delta": [0.1, 0.2]}, "delta"),
        ({"hold": "nothing"}, "hold"),
    ],
)
def test_mistakes_are_named(robot, equilibria, arguments, words):
    with pytest.raises(ValueError, match="must") as caught:
        cpr.sensitivity(robot, equilibria[0.0, 0.2], **arguments)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_radius_of_a_straight_rod_is_none(robot, equilibria):
    straight = eqx.tree_at(
        lambda r: r.legs.rod.precurvature, robot, 0.0 * robot.legs.rod.precurvature
    )
    with pytest.raises(ValueError, match="'r_c1' is infinite: name 'kappa1'"):
        cpr.sensitivity(straight, equilibria[0.0, 0.2])


def test_of_a_known_robot_within_a_transformation(robot, equilibria):
    """Its numbers are constants there, which checks of them must not make traced ones."""
    at = equilibria[0.0, 0.2]
    inside = jax.jit(lambda y: cpr.sensitivity(robot, eqx.tree_at(lambda e: e.mu, at, y)).Pi_y)
    np.testing.assert_allclose(
        inside(at.mu), cpr.sensitivity(robot, at).Pi_y, rtol=1e-9, atol=1e-12
    )


@pytest.mark.parametrize("look", [cpr.sensitivity, cpr.mobility, cpr.stability])
@pytest.mark.parametrize("steps", [0, 2.5, "10"])
def test_wrong_steps_are_named(robot, equilibria, look, steps):
    with pytest.raises(cpr.InputError, match="`steps` must"):
        look(robot, equilibria[0.0, 0.2], steps=steps)


def test_columns_keep_their_order_in_every_transformation(robot, equilibria):
    """That in which the robot declares its half ranges, which is not that of the alphabet."""
    at = equilibria[0.06, 0.15]
    slopes = cpr.sensitivity(robot, at)
    assert slopes.columns == ("k_b1", "r_c1", "k_b2", "r_c2")
    inside = jax.jit(lambda robot, at: cpr.sensitivity(robot, at))(robot, at)
    assert inside.columns == slopes.columns
    np.testing.assert_allclose(inside.Pi_p, slopes.Pi_p, rtol=1e-9, atol=1e-12)
    rebuilt = jax.tree.map(lambda leaf: leaf, robot)
    assert cpr.sensitivity(rebuilt, at).columns == slopes.columns
    # Of a plain dictionary put there by hand JAX remembers no order.
    plain = eqx.tree_at(lambda r: r.uncertainty, robot, dict(robot.uncertainty))
    alone = cpr.sensitivity(plain, at).columns
    assert cpr.sensitivity(jax.tree.map(lambda leaf: leaf, plain), at).columns == alone


@pytest.mark.parametrize("rows", ["", "q", "p"])
def test_a_part_of_a_name_is_no_name(robot, equilibria, rows):
    slopes = cpr.sensitivity(robot, equilibria[0.06, 0.15])
    with pytest.raises(cpr.InputError, match="`rows` must name states"):
        cpr.ellipsoid(slopes, rows)
