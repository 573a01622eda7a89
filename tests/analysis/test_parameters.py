"""What the labels of a rod's stiffnesses stand for."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select

K_T, K_2, K_3 = 0.4, 0.9, 0.3


@pytest.fixture(scope="module")
def robot():
    """Two legs in space, the second of two segments, of rods that are stiffer about one axis."""
    rod = cpr.kirchhoff_rod(cpr.SPACE, 0.3, (K_T, K_2, K_3), 0.5)
    both = cpr.segmented_rod([rod, cpr.kirchhoff_rod(cpr.SPACE, 0.2, (K_T, K_2, K_3))])
    legs = [
        cpr.make_leg(cpr.SPACE, (0.1 * k, 0.0, 0.0), rod, joint=cpr.clamped(cpr.SPACE))
        for k, rod in enumerate((rod, both))
    ]
    return cpr.make_robot(cpr.SPACE, legs, oriented=True)


def stiffnesses(robot, leg, segment=0):
    rod = robot.legs.rod
    compliance = rod.further.curvature_compliance[leg, segment - 1] if segment else None
    return 1.0 / np.asarray(rod.curvature_compliance[leg] if compliance is None else compliance)


def test_k_b_in_space_bends_about_both_axes(robot):
    """A stiffer material is stiffer about both; torsion has a modulus of its own."""
    for label, leg, segment in (("k_b1", 0, 0), ("k_b2_1", 1, 0), ("k_b2_2", 1, 1)):
        selection = select(robot, label)
        np.testing.assert_allclose(selection.get(robot), [K_3])
        varied = selection.set(robot, jnp.array([2.0 * K_3]))
        np.testing.assert_allclose(selection.get(varied), [2.0 * K_3])
        np.testing.assert_allclose(stiffnesses(varied, leg, segment), [K_T, 2 * K_2, 2 * K_3])
        others = [(0, 0), (1, 0), (1, 1)]
        others.remove((leg, segment))
        for other in others:
            np.testing.assert_allclose(stiffnesses(varied, *other), [K_T, K_2, K_3])


def test_one_axis_has_a_name_of_its_own(robot):
    for label, k in (("k_t1", 0), ("k_21", 1), ("k_31", 2)):
        expected = np.array([K_T, K_2, K_3])
        expected[k] = 7.0
        varied = select(robot, label).set(robot, jnp.array([7.0]))
        np.testing.assert_allclose(stiffnesses(varied, 0), expected)


@pytest.mark.parametrize(
    "labels",
    [
        ("k_b1", "k_21"),
        ("k_31", "k_b1"),
        ("k_b2_2", "k_22_2"),
        ("kappa1", "r_c1"),
        ("legs.rod.curvature_compliance[0, 1]", "k_21"),
        ("f_P_x", "f_P_x"),
    ],
    ids=", ".join,
)
def test_one_number_under_two_names_is_refused(robot, labels):
    with pytest.raises(cpr.InputError, match=r"`parameters` must name each number once"):
        select(robot, labels)
    assert select(robot, ("k_21", "k_31", "k_t1", "k_b2_1")).labels[0] == "k_21"


def test_a_half_range_of_what_no_robot_has_is_named_as_one(robot):
    declared = dataclasses.replace(robot, uncertainty={"k_bx": jnp.asarray(0.1)})
    with pytest.raises(cpr.InputError, match=r"`uncertainty` must name numbers of the robot.*k_bx"):
        select(declared)


def test_all_legs_at_once_keep_their_ratios(robot):
    """Both legs and all segments, about both axes of bending, but not in torsion."""
    selection = select(robot, ("k_b", "l", "k_t"))
    np.testing.assert_allclose(selection.get(robot), [K_3, 0.3, K_T])
    varied = selection.set(robot, jnp.array([2.0 * K_3, 0.6, K_T]))
    for leg, segment in ((0, 0), (1, 0), (1, 1)):
        np.testing.assert_allclose(stiffnesses(varied, leg, segment), [K_T, 2 * K_2, 2 * K_3])
    np.testing.assert_allclose(varied.legs.rod.length, [0.6, 1.0])
    np.testing.assert_allclose(selection.get(varied), [2.0 * K_3, 0.6, K_T])
    assert select(robot, ("k_2", "k_3", "r_c1")).units == ("N m^2", "N m^2", "m")


@pytest.mark.parametrize("other", ["k_b1", "k_22_2", "k_31", "k_2"])
def test_all_legs_at_once_are_each_of_them(robot, other):
    with pytest.raises(cpr.InputError, match=r"`parameters` must name each number once"):
        select(robot, ("k_b", other))


def test_of_what_the_first_leg_has_not_there_is_no_ratio(robot):
    with pytest.raises(cpr.InputError, match="'a' of the first leg is zero: name those of single"):
        select(robot, "a")
    with pytest.raises(cpr.InputError, match="'r_c' of the first leg is infinite"):
        select(cpr.rfrfr_straight(), "r_c")


def test_sensitivity_to_all_legs_is_the_sum_over_them_by_their_ratios():
    """And uncertainties of legs that vary together do not cancel like those of single ones."""
    robot = cpr.rfrfr(k_b=(0.018, 0.024), r_c=(-1.0, 1.5))
    here = cpr.solve_inverse(robot, (0.03, 0.2))
    single = cpr.sensitivity(robot, here, ("k_b1", "k_b2", "r_c1", "r_c2"))
    common = cpr.sensitivity(robot, here, ("k_b", "r_c"), {"k_b": 1e-3, "r_c": 0.1})
    ratios = np.array([[1.0, 0.0], [4.0 / 3.0, 0.0], [0.0, 1.0], [0.0, -1.5]])
    np.testing.assert_allclose(common.Pi_y, single.Pi_y @ ratios, rtol=1e-9, atol=1e-10)
