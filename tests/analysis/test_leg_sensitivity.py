"""Π_i(s) against the variational equations (8), written out and integrated by scipy."""

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cpr_jax as cpr
from cpr_jax.errors import InputError


def variational(k_b, r_c, q, start, mu, s):
    """(8) for (14): analytic ∂f/∂x and ∂f/∂ρ, Π(0) = 0; x = (p_y, p_z, θ, n_y, n_z, m)."""

    def rates(_, z):
        x, Pi = z[:6], z[6:].reshape(6, 2)
        c, sn = np.cos(x[2]), np.sin(x[2])
        n_y, n_z, m = x[3:]
        f = [c, sn, m / k_b + 1 / r_c, 0, 0, n_y * sn - n_z * c]
        A = np.zeros((6, 6))
        A[0, 2], A[1, 2], A[2, 5] = -sn, c, 1 / k_b
        A[5, 2], A[5, 3], A[5, 4] = n_y * c + n_z * sn, sn, -c
        B = np.zeros((6, 2))
        B[2] = -m / k_b**2, -1 / r_c**2
        return np.concatenate([f, (A @ Pi + B).ravel()])

    initial = np.concatenate([start, [q], mu, np.zeros(12)])
    solution = solve_ivp(
        rates, (0, s[-1]), initial, t_eval=s, method="DOP853", rtol=1e-12, atol=1e-13
    )
    return solution.y[6:].T.reshape(-1, 6, 2)


@pytest.mark.parametrize("leg", [1, 2])
def test_along_the_leg(robot, equilibria, leg):
    nominal = equilibria[0.06, 0.15]
    result = cpr.leg_sensitivity(robot, nominal, leg, points=9)
    q = float(nominal.q_a[leg - 1])
    start = [(-0.1, 0.1)[leg - 1] + 0.045 * np.cos(q), 0.045 * np.sin(q)]
    expected = variational(
        0.0183, (-1.0, 1.0)[leg - 1], q, start, np.asarray(nominal.mu[leg - 1]), result.s
    )
    assert result.columns == (f"k_b{leg}", f"r_c{leg}")
    assert result.rows == ("p_y", "p_z", "theta_x", "n_y", "n_z", "m_x")
    np.testing.assert_array_equal(result.Pi[0], 0.0)
    scale = np.max(np.abs(expected), axis=(0, 1))
    np.testing.assert_allclose(result.Pi / scale, expected / scale, atol=1e-7)


def test_points_are_for_looking_and_not_for_accuracy(robot, equilibria):
    nominal = equilibria[0.06, 0.15]
    fine = cpr.leg_sensitivity(robot, nominal, 1, points=41)
    for points in (2, 3, 5):
        few = cpr.leg_sensitivity(robot, nominal, 1, points=points)
        every = 40 // (points - 1)
        np.testing.assert_allclose(few.s, fine.s[::every], rtol=1e-14)
        scale = np.max(np.abs(fine.Pi), axis=(0, 1))
        np.testing.assert_allclose(few.Pi / scale, fine.Pi[::every] / scale, atol=1e-8)
        shape, smooth = (cpr.shape(robot, nominal, k) for k in (points, 41))
        np.testing.assert_allclose(
            shape.rods.position, smooth.rods.position[:, ::every], atol=1e-10
        )
        np.testing.assert_allclose(shape.s, smooth.s[:, ::every], rtol=1e-14)
    for look in (cpr.leg_sensitivity, lambda *args, **points: cpr.shape(*args[:2], **points)):
        with pytest.raises(ValueError, match="`points` must be an integer from 2"):
            look(robot, nominal, 1, points=1)
        with pytest.raises(ValueError, match="it is '5' of type int64, not int"):
            look(robot, nominal, 1, points=np.int64(5))


def test_leg_must_exist(robot, equilibria):
    with pytest.raises(ValueError, match="`leg` must be between 1 and 2"):
        cpr.leg_sensitivity(robot, equilibria[0.0, 0.2], 3)
    for leg in ("1", 1.5, 0):
        with pytest.raises(ValueError, match="`leg` must be a positive integer"):
            cpr.leg_sensitivity(robot, equilibria[0.0, 0.2], leg)


def test_inside_a_transformation_its_parameters_are_named(robot, equilibria):
    with pytest.raises(InputError, match="`parameters` must be given inside"):
        jax.eval_shape(lambda robot: cpr.leg_sensitivity(robot, equilibria[0.0, 0.2], 1).Pi, robot)


def test_nothing_before_the_base_moves_a_rod_that_carries_weight():
    """The base state is held: the load stays as it is in world axes, however the base is turned."""
    steel = cpr.Material(E=200e9, density=7800.0)
    rod = cpr.section_rod(cpr.PLANE, 0.25, cpr.circle(5e-4), steel, gravity=(0.0, -9.81))
    legs = [
        cpr.make_leg(cpr.PLANE, (side * 0.1, 0.0), rod, a=0.045, base_rotation=[0.2])
        for side in (-1.0, 1.0)
    ]
    robot = cpr.make_robot(cpr.PLANE, legs, oriented=False, home=((2.3, 0.5), (0.0, 0.2)))
    nominal = cpr.solve_inverse(robot, (0.0, 0.2))
    names = ("legs.base_rotation[0,0]", "a1", "base1_y", "f1_z")
    Pi = cpr.leg_sensitivity(robot, nominal, 1, parameters=names, points=5).Pi
    np.testing.assert_allclose(Pi[..., :3], 0.0, atol=1e-12)
    assert np.max(np.abs(Pi[..., 3])) > 1e-3


def test_longer_rods_move_each_cross_section_at_its_share_of_the_length():
    """Those of an unloaded rod lie on its circle of precurvature."""
    length, curvature = 0.3, 1.5
    rod = cpr.kirchhoff_rod(cpr.PLANE, length, 0.02, curvature)
    leg = cpr.make_leg(cpr.PLANE, (0.0, 0.0), rod)
    s = np.linspace(0.0, length, 5)
    tip = np.sin(length * curvature) / curvature, (1 - np.cos(length * curvature)) / curvature
    robot = cpr.make_robot(cpr.PLANE, [leg], oriented=False, home=((0.0,), tip))
    found = cpr.leg_sensitivity(robot, cpr.solve_forward(robot, (0.0,)), 1, ["l1"], points=5)
    share = s / length
    along = [share * np.cos(s * curvature), share * np.sin(s * curvature), share * curvature]
    np.testing.assert_allclose(found.Pi[:, :3, 0], np.stack(along, axis=1), rtol=0, atol=1e-9)
