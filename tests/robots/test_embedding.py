"""Planar robots in space: whatever a leg or a platform has is embedded with it."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.analysis.parameters import select
from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.robots.embedding import in_space
from cpr_jax.robots.joint import clamped, passive, pivot, slider
from cpr_jax.robots.leg import make_leg, prismatic_screw
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.statics.energy import potential_energy
from cpr_jax.statics.measures import motor_torques
from cpr_jax.statics.residual import residual
from cpr_jax.statics.unknowns import unravel

STEPS = 20


def planar_robot():
    """A crank with a passive pivot, a slide on a sliding motor, a telescopic leg; point loads."""
    rod = kirchhoff_rod(PLANE, 0.3, 0.02, 1.5)
    heavy = kirchhoff_rod(PLANE, 0.25, 0.03, -1.0, force=(0.1, -0.4), moment=(0.02,))
    crank = make_leg(
        PLANE,
        (-0.2, 0.01),
        rod,
        base_rotation=(0.4,),
        base_joint=passive(PLANE, pivot(PLANE), (0.05, 0.02), (0.3,)),
        attachment_position=(-0.05, 0.01),
        attachment_rotation=(0.7,),
    )
    slide = make_leg(
        PLANE,
        (0.2, 0.0),
        rod,
        base_rotation=(2.0,),
        screw=prismatic_screw(PLANE, 1),
        base_joint=passive(PLANE, slider(PLANE, 1), (0.01, -0.02), (-0.5,)),
        b=(0.02, 0.01),
        attachment_position=(0.05, 0.0),
    )
    telescopic = make_leg(
        PLANE,
        (0.0, -0.1),
        heavy,
        base_rotation=(1.2,),
        screw=np.zeros(3),
        stroke=(1.0, 0.2),
        a=(0.04, 0.01),
        attachment_position=(0.0, -0.04),
    )
    return make_robot(
        PLANE,
        [crank, slide, telescopic],
        oriented=True,
        f_P=(0.2, -0.3),
        m_P=(0.01,),
        loads=[((0.03, 0.02), (0.1, -0.6)), ((-0.04, 0.0), (0.0, 0.5))],
        home=((0.1, 0.02, 0.03), (0.01, 0.2, 0.1)),
    )


def unknowns_in_space(y):
    """Each leg has a passive joint: its unknowns are along and about local axes."""
    q_a, q_p, mu = y[:3], y[3:6], y[6:].reshape(3, 3)
    legs = np.concatenate([mu[:, :2], np.zeros((3, 3)), mu[:, 2:]], axis=1)
    return np.concatenate([q_a, [0.0], q_p, [0.0, 0.0], legs.ravel()])


@pytest.fixture(scope="module")
def pair():
    robot = planar_robot()
    return robot, in_space(robot)


def numbers(robot, y):
    """Residual, torques and energy at unknowns, as one program."""

    def compute(y):
        rows = residual(robot, unravel(robot, y), STEPS)
        return rows, motor_torques(robot, y), potential_energy(robot, y, STEPS)

    return jax.jit(compute)(jnp.asarray(y))


def test_rows_torques_and_energy_agree_off_equilibrium(pair):
    """In the plane every row is the same number; out of the plane nothing happens."""
    robot, spatial = pair
    random = np.random.default_rng(3)
    y = np.concatenate([[0.3, 0.02, 0.03], [0.02, 0.21, 0.2], 0.3 * random.normal(size=9)])
    rows, torques, energy = numbers(robot, y)
    rows_3d, torques_3d, energy_3d = numbers(spatial, unknowns_in_space(y))
    assert np.min(np.abs(rows)) > 1e-3
    # The balance is in world axes (y, z, about x), the joints are in local ones.
    expected = [np.pad(rows[:3], (1, 2))]
    expected += [[*row[:2], 0.0, 0.0, 0.0, row[2]] for row in rows[3:].reshape(3, 3)]
    np.testing.assert_allclose(rows_3d, np.concatenate(expected), rtol=0, atol=1e-12)
    assert np.min(np.abs(torques)) > 1e-3
    np.testing.assert_allclose(torques_3d, torques, rtol=0, atol=1e-12)
    # A dead moment has a potential in the plane only.
    without = float(energy) + float(robot.m_P[0]) * y[5]
    assert float(energy_3d) == pytest.approx(without, abs=1e-12)


def test_what_is_embedded(pair):
    robot, spatial = pair
    assert spatial.geometry == SPACE
    joint, flat = spatial.legs.base_joint, robot.legs.base_joint
    np.testing.assert_array_equal(joint.free[:, [0, 1, 5]], flat.free)
    np.testing.assert_array_equal(joint.free[:, 2:5], 0.0)
    np.testing.assert_array_equal(joint.rotation[:, 2], flat.rotation[:, 0])
    np.testing.assert_array_equal(spatial.legs.stroke, [[0, 0, 0], [0, 0, 0], [1.0, 0.2, 0.0]])
    np.testing.assert_array_equal(spatial.loads.position[:, 1:], robot.loads.position)
    np.testing.assert_array_equal(spatial.loads.force[:, 0], 0.0)
    np.testing.assert_array_equal(spatial.home.q_p, [0.0, 0.01, 0.2, 0.1, 0.0, 0.0])


def test_half_ranges_keep_to_their_parameters(pair):
    """What a path leads to has another place in space, and the same influence."""
    robot, _ = pair
    names = {
        "l1": "l1",
        "f_P_y": "f_P_y",
        "legs.attachment_position[0,0]": "legs.attachment_position[0,1]",
        "legs.rod.precurvature[1,0]": "legs.rod.precurvature[1,2]",
        "legs.b[0,1]": "legs.b[0,1]",
    }
    ranges = {name: 1e-3 * (k + 1) for k, name in enumerate(names)}
    spatial = in_space(dataclasses.replace(robot, uncertainty=ranges))
    moved = {name: float(size) for name, size in spatial.uncertainty.items()}
    assert moved == {names[name]: size for name, size in ranges.items()}
    for flat, name in names.items():
        in_plane, there = (select(r, [n]).get(r) for r, n in ((robot, flat), (spatial, name)))
        np.testing.assert_array_equal(in_plane, there)
    doubtful = dataclasses.replace(robot, uncertainty={"legs.rod.curvature_compliance[0,0]": 1.0})
    with pytest.raises(InputError, match="space has 3 numbers"):
        in_space(doubtful)


def test_what_a_robot_lacks_it_lacks_in_space():
    leg = make_leg(PLANE, (0.1, 0.0), kirchhoff_rod(PLANE, 0.2, 0.02), joint=clamped(PLANE))
    spatial = in_space(make_robot(PLANE, [leg], oriented=True))
    lacking = (spatial.legs.stroke, spatial.legs.base_joint, spatial.loads, spatial.home)
    assert lacking == (None,) * 4
