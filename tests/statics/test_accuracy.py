"""The choice of integration steps, against a much finer integration."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.geometry import PLANE
from cpr_jax.robots.joint import clamped
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.integration import rod_tip
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.rods.solver import Scheme
from cpr_jax.statics.accuracy import MENU, least_scheme, tip_errors
from cpr_jax.statics.residual import leg_base
from cpr_jax.statics.unknowns import unravel
from tests.oracles.whole_robot import unbalanced


def tips(robot, y, scheme):
    state = unravel(robot, y)

    def one(leg, q, mu):
        base = leg_base(robot.geometry, leg, q, mu)
        tip = rod_tip(robot.geometry, base.rod, base.force, base.moment, scheme)
        return tip.position / base.rod.length

    return jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu)


def alone(robot, y):
    """One case as the only one of several."""
    return jax.tree.map(lambda leaf: leaf[None], (robot, y))


@pytest.mark.parametrize("point", [(0.0, 0.25), (0.06, 0.18), (0.11, 0.1), (0.05, 0.045)])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_the_chosen_scheme_is_the_first_that_is_accurate(point, tolerance):
    robot = cpr.rfrfr()
    y = cpr.solve_inverse(robot, point).y
    chosen = int(least_scheme(tip_errors(*alone(robot, y)), tolerance))
    reference = tips(robot, y, 60)
    errors = [np.max(np.abs(tips(robot, y, scheme) - reference)) for scheme in MENU[: chosen + 1]]
    # Each was measured against another integration than this one.
    assert errors[-1] < tolerance + 1e-12
    assert all(error > tolerance - 1e-12 for error in errors[:-1])


@pytest.mark.parametrize("bent", ["sharply", "gently"])
def test_errors_of_the_menu_and_of_a_further_scheme(bent):
    """The most steps of the menu are tried for the rod that is bent sharply only."""
    if bent == "sharply":
        robot = column(8.0)
        y = cpr.solve_forward(robot, [0.0]).y
    else:
        robot = cpr.rfrfr()
        y = cpr.solve_inverse(robot, (0.05, 0.17)).y
    errors = np.asarray(tip_errors(*alone(robot, y), 5))
    reference = tips(robot, y, 100)
    for scheme, error in zip((*MENU, Scheme(5)), errors, strict=True):
        true = np.max(np.abs(tips(robot, y, scheme) - reference))
        assert 0.5 * true - 1e-12 < error < 2.0 * true + 1e-12, scheme
    assert np.all(np.diff([scheme.work for scheme in MENU]) > 0)


def test_of_several_cases_the_largest_errors_count():
    robot = cpr.rfrfr()
    ys = jnp.stack([cpr.solve_inverse(robot, point).y for point in ((0.0, 0.25), (0.11, 0.1))])
    apart = [tip_errors(*alone(robot, y)) for y in ys]
    robots = jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), robot)
    together = tip_errors(robots, ys)
    np.testing.assert_allclose(together, np.max(apart, axis=0), rtol=1e-2, atol=1e-13)
    assert np.any(apart[0] != apart[1])


def test_nothing_is_enough_for_the_impossible():
    errors = np.full(len(MENU), 1e-3)
    assert int(least_scheme(errors, 1e-30)) == len(MENU) - 1
    assert int(least_scheme(errors, 1e-2)) == 0


def column(force):
    """A rod of 0.2 m that a force bends sharply next to its base, as it is much too strong for it.

    It turns within `√(k_b / f)`, a fifth of its length at 8 N.
    """
    rod = kirchhoff_rod(PLANE, 0.2, 0.01)
    leg = make_leg(PLANE, (0.0, 0.0), rod, screw=np.zeros(3), feed=1.0, joint=clamped(PLANE))
    home = (0.0,), (0.2, 0.0, 0.0)
    return make_robot(PLANE, [leg], oriented=True, f_P=jnp.stack([0.0, force]), home=home)


def test_as_many_steps_as_it_takes():
    robot = column(8.0)
    rough, found = (cpr.solve_forward(robot, [0.0], steps=steps) for steps in (10, None))
    assert 1e-8 < unbalanced(robot, rough.y) < 2.0 * float(rough.measures.unbalanced)
    assert unbalanced(robot, found.y) < 1e-8
    assert float(found.measures.unbalanced) < 5e-9


def test_what_moves_far_with_more_steps_is_followed_anew():
    """A rod that is curled up five times: 10 steps leave its tip so far off that no more of them
    find anything from there."""
    bend = 150.0
    rod = kirchhoff_rod(PLANE, 0.2, 0.01, precurvature=bend)
    leg = make_leg(PLANE, (0.0, 0.0), rod, feed=1.0, joint=clamped(PLANE))
    turn = 0.2 * bend
    home = (0.0,), (np.sin(turn) / bend, (1.0 - np.cos(turn)) / bend, turn)
    robot = make_robot(PLANE, [leg], oriented=True, f_P=(0.0, 0.02), home=home)
    rough, found = (cpr.solve_forward(robot, [0.0], steps=steps) for steps in (10, None))
    assert float(rough.measures.unbalanced) > 1e-3
    assert int(found.status) == cpr.Status.SOLVED
    assert unbalanced(robot, found.y) < 1e-8


def test_what_takes_more_steps_is_not_called_solved_in_a_batch():
    forces = jnp.array([2.0, 20.0])

    def solve(force, steps):
        found = cpr.solve_forward(column(force), [0.0], steps=steps)
        return found.status, found.y

    (chosen, y), (given, finer) = (jax.vmap(solve, (0, None))(forces, n) for n in (None, 20))
    np.testing.assert_array_equal(chosen, [cpr.Status.SOLVED, cpr.Status.INACCURATE])
    assert np.all(np.isfinite(y[0])) and np.all(np.isnan(y[1]))
    np.testing.assert_array_equal(given, cpr.Status.SOLVED)
    np.testing.assert_allclose(finer[0], y[0], rtol=0, atol=1e-9)


def test_a_case_that_cannot_be_integrated_tells_nothing_unless_it_is_alone():
    robot = cpr.rfrfr()
    y = cpr.solve_inverse(robot, (0.0, 0.25)).y
    robots = jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), robot)
    beside = tip_errors(robots, jnp.stack([y, jnp.nan * y]))
    np.testing.assert_allclose(beside, tip_errors(*alone(robot, y)), rtol=1e-2, atol=1e-13)
    unknown = np.asarray(tip_errors(*alone(robot, jnp.nan * y)))
    assert not np.any(np.isfinite(unknown))
    assert int(least_scheme(unknown)) == len(MENU) - 1
