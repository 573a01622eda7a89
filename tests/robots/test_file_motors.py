"""Motors, passive joints and loads in robot files, as numbers of the robot."""

from typing import Any

import numpy as np
import pytest

from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.robots.joint import passive, pivot, slider, spherical, swivel, universal
from cpr_jax.robots.robot import Robot

from .test_files import assert_same, loaded

ROD = {"length": 1.0, "bending_stiffness": 1.0}
HEAVY = {
    "length": 1,
    "section": {"kind": "circle", "radius": "1 mm"},
    "material": {"E": "200 GPa", "density": "8 g/cm^3"},
}


def of_legs(*legs: dict[str, Any], geometry: str = "space", **entries: Any) -> Robot:
    """A robot with a body, whose legs have what is given."""
    zero = [0.0] * (3 if geometry == "space" else 2)
    tables = [{"base": zero, "joint": "pivot", "rod": ROD, **leg} for leg in legs]
    platform = {"kind": "body"}
    return loaded(**{"geometry": geometry, "platform": platform, "legs": tables, **entries})


@pytest.mark.parametrize(
    ("motor", "screw", "feed", "stroke"),
    [
        ("revolute", (0, 0, 0, 0, 0, 1), None, None),
        ({"kind": "revolute", "ratio": -0.5}, (0, 0, 0, 0, 0, -0.5), None, None),
        ({"kind": "revolute", "axis": [0, 3, 4], "ratio": 5}, (0, 0, 0, 0, 3, 4), None, None),
        ({"kind": "prismatic", "ratio": "1e-2"}, (0.01, 0, 0, 0, 0, 0), None, None),
        ({"kind": "prismatic", "axis": [0, 0, -2], "ratio": 3}, (0, 0, -3, 0, 0, 0), None, None),
        ("feed", np.zeros(6), 1.0, None),
        ({"kind": "feed", "ratio": 2}, np.zeros(6), 2.0, None),
        ("telescopic", np.zeros(6), None, (1, 0, 0)),
        ({"kind": "telescopic", "ratio": -2}, np.zeros(6), None, (-2, 0, 0)),
    ],
)
def test_motor(motor: Any, screw: Any, feed: Any, stroke: Any) -> None:
    leg = of_legs({"motor": motor}).leg(0)
    np.testing.assert_allclose(leg.screw, screw, rtol=1e-15, atol=0.0)
    assert (leg.feed is None) == (feed is None)
    assert (leg.stroke is None) == (stroke is None)
    if feed is not None:
        assert leg.feed == feed
    if stroke is not None:
        np.testing.assert_array_equal(leg.stroke, stroke)


def test_legs_without_a_motor_have_no_column() -> None:
    robot = of_legs({"motor": "none"}, {}, {"motor": "feed"}, {"motor": "none"}, geometry="plane")
    np.testing.assert_array_equal(robot.transmission, [[0, 0], [1, 0], [0, 1], [0, 0]])
    np.testing.assert_array_equal(robot.legs.screw[0], np.zeros(3))


def test_motors_move_several_legs() -> None:
    legs = [{}, {"motor": "prismatic"}, {"motor": {"kind": "revolute", "ratio": -1}}, {}]
    home = {"motors": ["90 deg", "20 mm", 1.0], "position": [0, 0], "rotation": 0}
    robot = of_legs(*legs, geometry="plane", motors=[[3, 1], [2], [1, 4]], home=home)
    np.testing.assert_array_equal(robot.transmission, [[1, 0, 1], [0, 1, 0], [1, 0, 0], [0, 0, 1]])
    assert robot.home is not None
    np.testing.assert_array_equal(robot.home.q_a, [np.pi / 2.0, 0.02, 1.0])


@pytest.mark.parametrize("geometry", [PLANE, SPACE])
def test_base_joints_by_name(geometry: Any) -> None:
    joints = {
        "pivot": pivot, "universal": universal, "spherical": spherical, "swivel": swivel,
        "slider": slider,
    }  # fmt: skip
    for name, joint in joints.items():
        robot = of_legs({"base_joint": name}, geometry=geometry.name)
        assert_same(robot.leg(0).base_joint, passive(geometry, joint(geometry)))


def test_base_joint_at_the_end_of_a_crank() -> None:
    joint = {
        "free": [0, 1, 0, 0, 1, 0],
        "position": ["50 mm", 0, "1 mm"],
        "rotation": {"axis": [0, 0, 2], "angle": "90 deg"},
    }
    found = of_legs({"base_joint": joint}).leg(0).base_joint
    assert found is not None
    np.testing.assert_array_equal(found.free, joint["free"])
    np.testing.assert_array_equal(found.position, [0.05, 0.0, 0.001])
    np.testing.assert_array_equal(found.rotation, [0.0, 0.0, np.pi / 2.0])
    planar = {"joint": "pivot", "position": ["50 mm", 0], "rotation": "90 deg"}
    found = of_legs({"base_joint": planar}, geometry="plane").leg(0).base_joint
    assert found is not None
    np.testing.assert_array_equal(found.rotation, [np.pi / 2.0])


def test_joints_at_the_platform() -> None:
    for name, joint in (("universal", universal), ("swivel", swivel)):
        for geometry in (PLANE, SPACE):
            robot = of_legs({"joint": name}, geometry=geometry.name)
            assert_same(robot.leg(0).joint, joint(geometry))


def test_weight_of_a_body_acts_at_its_centre_of_mass() -> None:
    robot = of_legs(
        {"rod": HEAVY},
        platform={
            "kind": "body",
            "force": [1, 2, 3],
            "mass": "200 g",
            "center_of_mass": ["10 mm", 0, 0],
            "loads": [{"position": [0, "1 m", 0], "force": ["1 kN", 0, 0]}],
        },
        environment={"gravity": [0, 0, -10]},
    )
    assert robot.loads is not None
    np.testing.assert_array_equal(robot.loads.position, [[0.01, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(robot.loads.force, [[0, 0, -2], [1000, 0, 0]])
    np.testing.assert_array_equal(robot.f_P, [1, 2, 3])


def test_weight_of_a_point_is_a_force() -> None:
    platform = {"kind": "point", "force": [1, 2], "mass": "200 g"}
    gravity = {"gravity": [0, -10]}
    robot = of_legs({"rod": HEAVY}, geometry="plane", platform=platform, environment=gravity)
    np.testing.assert_array_equal(robot.f_P, [1, 0])
    assert robot.loads is None


def test_shear_factor() -> None:
    """Of the shear stiffness, G A = 1 Pa / 2 * 1 m², with nu = 0."""
    for section, factor in (
        ({"kind": "rectangle", "width": 1, "height": 1}, 0.25),
        ({"kind": "circle", "radius": 1.0 / np.sqrt(np.pi)}, 0.5),
    ):
        rod = {
            "length": 9,
            "section": {**section, "shear_factor": factor},
            "material": {"E": "10 kPa", "nu": 0},
            "extensible": True,
        }
        compliance = of_legs({"rod": rod}).leg(0).rod.strain_compliance
        np.testing.assert_allclose(compliance, [1e-4, *[2e-4 / factor] * 2], rtol=1e-15)
