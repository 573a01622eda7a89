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
