"""A map of a robot whose platform has an orientation, which is held."""

import dataclasses
import json

import numpy as np
import pytest

from cpr_jax.geometry import PLANE
from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.robots.joint import clamped
from cpr_jax.robots.leg import make_leg, prismatic_screw
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.statics.solve import solve_inverse
from cpr_jax.statics.status import Status
from cpr_jax.studies.workspace import workspace_map

pytestmark = pytest.mark.optimised


def test_a_platform_with_an_orientation_keeps_it():
    robot = three_rfr()
    seed = solve_inverse(robot, robot.home.q_p)
    dataset = workspace_map(robot, seed, spacing=0.02, box=((-0.06, -0.06), (0.06, 0.06)))
    assert dict(dataset.sizes)["motor"] == 3
    (held,) = json.loads(dataset.attrs["held"]).items()
    assert held == ("phi_P_x", float(seed.q_p[2]))
    assert np.sum(dataset["index"].values >= 0) > 20
    assert dataset["Pi_p"].shape[2] == 3
    # One cell beside a solve of its own from the seed.
    cell = dataset.sel(y=0.02, z=-0.02, method="nearest")
    point = (float(cell["y"]), float(cell["z"]), held[1])
    single = solve_inverse(robot, point, guess=seed)
    np.testing.assert_allclose(cell["q_a"], single.q_a, rtol=0, atol=1e-9)
    np.testing.assert_allclose(cell["motor_torque"], single.motor_torques, rtol=0, atol=1e-9)


def sliding():
    """Three rods on sliding motors, which pull them taut at one edge of the workspace."""

    def leg(base, angle, length, k_b, curvature, attachment, **joint):
        rod = kirchhoff_rod(PLANE, length, k_b, curvature)
        along = {"base_rotation": (np.deg2rad(angle),), "screw": prismatic_screw(PLANE)}
        return make_leg(PLANE, base, rod, attachment_position=attachment, **along, **joint)

    down = {"joint": clamped(PLANE), "attachment_rotation": (np.deg2rad(-90.0),)}
    legs = [
        leg((-0.25, -0.15), 30.0, 0.26, 0.0583, 2.0, (-0.03, -0.02)),
        leg((0.25, -0.15), 150.0, 0.265, 0.0643, 2.0, (0.03, -0.02)),
        leg((0.0, 0.29), -90.0, 0.25, 0.05, 1.0, (0.0, 0.04), **down),
    ]
    home = np.array([0.0059, -0.0081, -0.0099]), np.array([0.005, 0.01, 0.05])
    robot = make_robot(PLANE, legs, oriented=True, f_P=(0.2, -0.5), m_P=(0.005,), home=home)
    # Of the structure of another robot of this file, whose programs serve it too.
    other = three_rfr()
    legs = dataclasses.replace(robot.legs, turns=other.legs.turns)
    return dataclasses.replace(robot, legs=legs, name=other.name, uncertainty=other.uncertainty)


def test_what_only_rounding_prevents_is_no_fold():
    """Corrections in taut rods stay where they are and do not converge, but with other steps."""
    box = ((0.0, -0.12), (0.21, 0.03))
    there, *others = (
        workspace_map(sliding(), spacing=0.01, box=box, steps=n)["status"].values
        for n in (10, 12, 14, 20, 40)
    )
    elsewhere = np.any(np.stack(others) == Status.SOLVED, axis=0)
    assert np.count_nonzero((there == Status.BEYOND_FOLD) & elsewhere) == 0
    assert np.count_nonzero((there == Status.NOT_CONVERGED) & elsewhere) > 0
    assert np.count_nonzero(there == Status.SOLVED) > 50
