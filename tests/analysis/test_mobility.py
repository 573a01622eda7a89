"""What a platform gives way to, beside the linear theory of a straight rod."""

import numpy as np
import pytest

import cpr_jax as cpr

LENGTH, STIFFNESS = 0.3, 0.02


def test_a_straight_rod_is_rigid_along_itself():
    """Its stiffness there is no number, and its end gives `L³ / (3 EI)` across."""
    leg = cpr.make_leg(cpr.PLANE, (0.0, 0.0), cpr.kirchhoff_rod(cpr.PLANE, LENGTH, STIFFNESS))
    home = ((np.pi / 2.0,), (0.0, LENGTH))
    robot = cpr.make_robot(cpr.PLANE, [leg], oriented=False, f_P=(0.0, 0.0), home=home)
    upright = cpr.solve_forward(robot, (np.pi / 2.0,))
    found = cpr.mobility(robot, upright)
    across = LENGTH**3 / (3.0 * STIFFNESS)
    np.testing.assert_allclose(found.compliance, [[across, 0.0], [0.0, 0.0]], rtol=0, atol=1e-9)
    assert np.all(np.isnan(found.stiffness))
    slopes = cpr.sensitivity(robot, upright, ["l1"], {"l1": 1e-3})
    assert np.all(np.isnan(slopes.platform_stiffness))
    np.testing.assert_allclose(slopes.Pi_p[:, 0], [0.0, 1.0], rtol=0, atol=1e-9)


def test_an_equilibrium_of_another_robot_is_refused(robot, equilibria):
    """As a design has after it was changed and not solved again."""
    nominal = equilibria[0.06, 0.15]
    stiffer = cpr.rfrfr(k_b=0.05)
    for look in (cpr.mobility, cpr.stability, cpr.sensitivity):
        look(robot, nominal)
        with pytest.raises(cpr.InputError, match="`equilibrium` must be one of RFRFR as it is now"):
            look(stiffer, nominal)


def test_motors_that_move_nothing_move_the_platform_in_no_direction():
    def leg(side):
        rod = cpr.kirchhoff_rod(cpr.PLANE, 0.2, STIFFNESS, -2.0 * side)
        turned = [np.pi / 2 + 0.3 * side]
        at = (0.1 * side, 0.0)
        return cpr.make_leg(cpr.PLANE, at, rod, base_rotation=turned, screw=np.zeros(3))

    home = ((0.0, 0.0), (0.0, 0.17))
    idle = [leg(-1.0), leg(1.0)]
    robot = cpr.make_robot(cpr.PLANE, idle, oriented=False, f_P=(0.1, 0.0), home=home)
    found = cpr.mobility(robot, cpr.solve_forward(robot, (0.0, 0.0)))
    assert (float(found.manipulability), float(found.condition)) == (0.0, 0.0)
