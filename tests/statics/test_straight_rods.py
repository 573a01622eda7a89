"""Straight rods at rest, which have no way to go before they are bent."""

import dataclasses

import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.geometry import PLANE
from cpr_jax.statics.status import SolveError, Status


@pytest.fixture(scope="module")
def robot():
    """A body between three rods on sliding motors; at home all of them are about as long as the
    way between their ends."""

    def leg(base, angle, length, k_b, attachment, **joint):
        return cpr.make_leg(
            PLANE,
            base,
            cpr.kirchhoff_rod(PLANE, length, k_b),
            base_rotation=(np.deg2rad(angle),),
            screw=cpr.prismatic_screw(PLANE),
            attachment_position=attachment,
            **joint,
        )

    down = {"joint": cpr.clamped(PLANE), "attachment_rotation": (np.deg2rad(-90.0),)}
    legs = [
        leg((-0.25, -0.15), 30.0, 0.26, 0.0583, (-0.03, -0.02)),
        leg((0.25, -0.15), 150.0, 0.265, 0.0643, (0.03, -0.02)),
        leg((0.0, 0.29), -90.0, 0.25, 0.05, (0.0, 0.04), **down),
    ]
    return cpr.make_robot(
        PLANE,
        legs,
        oriented=True,
        f_P=(0.2, -0.5),
        m_P=(0.005,),
        home=(np.zeros(3), np.zeros(3)),
    )


@pytest.mark.parametrize("turn", [-0.02, 0.02, 0.05])
def test_a_home_of_straight_rods_is_assembled(robot, turn):
    """It leads to the equilibrium of least energy that a systematic search finds, which is a saddle
    where the load turns the other way."""
    pose = (0.005, 0.01, turn)
    solved = cpr.solve_inverse(robot, pose)
    assert solved.branch == "home"
    np.testing.assert_allclose(solved.q_p, pose, atol=1e-12)
    assert np.max(np.abs(solved.q_a)) < 0.02
    searched = cpr.solve_inverse(dataclasses.replace(robot, home=None), pose)
    np.testing.assert_allclose(solved.y, searched.y, atol=1e-8)
    assert int(cpr.stability(robot, solved).index) == (turn < 0.0)


def test_what_it_cannot_reach_is_lost_rather_than_not_assembled(robot):
    with pytest.raises(SolveError) as caught:
        cpr.solve_forward(robot, (-0.3, -0.3, -0.3))
    assert caught.value.status is Status.LOST
