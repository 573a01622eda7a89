"""Sensitivities of robots with rods of several segments."""

import jax
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select
from cpr_jax.errors import InputError
from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.robots.catalogue_space import three_rfs
from tests.oracles import cosserat
from tests.rods.common import differences
from tests.statics.segmented import stepped

SHARES = [(1.0,), (7 / 12, 5 / 12), (0.25, 0.5, 0.25)]
PLANAR = ("k_b1", "l1", "k_b2_1", "k_b2_2", "l2_1", "l2_2", "kappa3_2", "r_c3_3", "f3_2_y", "f1_z")
SPATIAL = ("k_21", "k_22_1", "k_33_3", "kappa3_1", "l1", "l3_3", "f2_2_x", "f2_1_z")


@pytest.fixture(scope="module", params=["plane", "space"])
def nominal(request):
    """A robot with legs of one, two and three segments, an equilibrium, and some parameters."""
    plane = request.param == "plane"
    robot = stepped(three_rfr() if plane else three_rfs(), SHARES, seed=2, spread=0.5)
    return robot, cpr.solve_forward(robot, robot.home.q_a + 0.05), PLANAR if plane else SPATIAL


def test_sensitivity_of_all_unknowns(nominal):
    """Π_y and Π_τ against central differences of equilibria, motors held."""
    robot, solved, labels = nominal
    delta = dict.fromkeys(labels, 1.0)
    found = cpr.sensitivity(robot, solved, labels, delta)
    selection = select(robot, labels)

    changed = jax.jit(lambda rho: selection.set(robot, rho))

    def solve(rho):
        again = cpr.solve_forward(changed(rho), solved.q_a, guess=solved)
        return np.concatenate([again.y, again.motor_torques])

    rho = np.asarray(selection.get(robot))
    steps = 2e-3 * np.maximum(np.abs(rho), 0.05)
    expected = differences(lambda x: solve(rho + steps * x), np.zeros(len(rho)), 1.0) / steps
    both = np.concatenate([found.Pi_y, found.Pi_tau])
    size = np.max(np.abs(expected), axis=0)
    assert np.all(size > 1e-4), size
    np.testing.assert_allclose(both / size, expected / size, rtol=0, atol=1e-6)


def test_two_ways_to_the_stiffness_agree(nominal):
    """From the residual, and from the second variation of the energy; both symmetric."""
    robot, solved, labels = nominal
    delta = {labels[0]: 1.0}
    by_rows = np.asarray(cpr.sensitivity(robot, solved, labels[:1], delta).platform_stiffness)
    by_energy = np.asarray(cpr.stability(robot, solved).platform_stiffness)
    size = np.sqrt(np.abs(np.outer(np.diag(by_energy), np.diag(by_energy))))
    np.testing.assert_allclose(by_rows / size, by_energy / size, rtol=0, atol=1e-7)
    np.testing.assert_allclose(by_rows / size, by_rows.T / size, rtol=0, atol=1e-8)


def test_along_a_leg():
    """Π_i(s) at the ends of segments, against differences of an independent integration."""
    robot = stepped(three_rfr(), SHARES, seed=2, spread=0.5)
    solved = cpr.solve_forward(robot, robot.home.q_a + 0.05)
    found = cpr.leg_sensitivity(robot, solved, 3, points=9)
    assert found.columns == ("k_b3_1", "r_c3_1", "k_b3_2", "r_c3_2", "k_b3_3", "r_c3_3")
    assert found.s.shape == (25,) and found.Pi.shape == (25, 6, 6)
    np.testing.assert_allclose(found.s[::8], 0.25 * np.array([0.0, 0.25, 0.75, 1.0]), rtol=1e-14)
    q, wrench = float(solved.q_a[2]), np.asarray(solved.mu[2])
    rod, turn = robot.leg(2).rod, np.array([[np.cos(q), np.sin(q)], [-np.sin(q), np.cos(q)]])

    def ends(rho):
        rods = [
            cosserat.SpatialRod(
                length,
                np.array([1.0, 1.0, 1.0 / rho[2 * j]]),
                np.array([0.0, 0.0, 1.0 / rho[2 * j + 1]]),
                load=np.pad(turn @ force, (0, 1)),
            )
            for j, (length, force) in enumerate(
                zip((0.0625, 0.125, 0.0625), (rod.force, *rod.further.force), strict=True)
            )
        ]
        force = np.pad(turn @ wrench[:2], (0, 1))
        p, R, n, m, *_ = cosserat.integrate_segments(rods, force, np.array([0.0, 0.0, wrench[2]]))
        angle = np.arctan2(R[:, 1, 0], R[:, 0, 0])
        return np.column_stack([p[:, :2] @ turn, angle, n[:, :2] @ turn, m[:, 2]])

    rho = np.asarray(select(robot, found.columns).get(robot))
    for column, value in enumerate(rho):
        unit = 1e-5 * abs(value) * np.eye(6)[column]
        expected = (ends(rho + unit) - ends(rho - unit)) / (2e-5 * abs(value))
        size = np.max(np.abs(expected))
        np.testing.assert_allclose(found.Pi[8::8, :, column] / size, expected / size, atol=1e-7)
    assert cpr.leg_sensitivity(robot, solved, 1, points=9).s.shape == (9,)


def test_labels_name_segments():
    robot = stepped(three_rfr(), SHARES)
    np.testing.assert_allclose(
        select(robot, ("l1", "l2_1", "l2_2", "l3_2")).get(robot),
        0.25 * np.array([1.0, 7 / 12, 5 / 12, 0.5]),
        rtol=1e-14,
    )
    # Segments get longer each by itself, in whichever order.
    for labels in (("l3_1", "l3_3", "l1"), ("l1", "l3_3", "l3_1")):
        selection = select(robot, labels)
        changed = selection.set(robot, selection.get(robot) + 0.01)
        np.testing.assert_allclose(selection.get(changed) - selection.get(robot), 0.01, rtol=1e-12)
        assert float(changed.legs.rod.length[2]) == pytest.approx(0.27, abs=1e-15)
        again = select(robot, ("l3_2",))
        np.testing.assert_allclose(again.get(changed), again.get(robot), rtol=1e-14)
    spatial = stepped(three_rfs(), SHARES)
    labels = ("k_t2_2", "k_22_1", "k_33_3"), ("k_b3_3",)
    stiffnesses = np.concatenate([select(spatial, some).get(spatial) for some in labels])
    first = spatial.legs.rod.curvature_compliance
    further = spatial.legs.rod.further.curvature_compliance
    expected = np.array([further[1, 0, 0], first[1, 1], further[2, 1, 2], further[2, 1, 2]])
    np.testing.assert_allclose(stiffnesses, 1.0 / expected, rtol=1e-15)
    with pytest.raises(InputError, match=r"one of the 2 segments of leg 2, such as 'k_b2_1'"):
        select(robot, "k_b2")
    with pytest.raises(InputError, match=r"one of the 3 segments of leg 3, such as 'f3_1_y'"):
        select(robot, "f3_y")
    for label in ("k_b1_1", "k_b2_3", "k_b2_0", "k_b3_4", "l1_1", "a2_1", "base2_1_y", "k_b4_1"):
        with pytest.raises(InputError, match=r"must name numbers that the robot has"):
            select(robot, label)
    with pytest.raises(InputError, match=r"must name numbers that the robot has"):
        select(three_rfr(), "k_b1_2")
    for labels in (("l2_2", "legs.rod.length[1]"), ("legs.rod.further.length[1,0]", "l2_1")):
        for order in (labels, labels[::-1]):
            with pytest.raises(InputError, match="change each other"):
                select(robot, order)
    select(robot, ("l2_2", "legs.rod.length[0]"))
