"""What the labels of a rod's stiffnesses stand for."""

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
