"""Robot files to robots, and back to the last bit."""

import dataclasses
import pathlib
import tomllib
import warnings
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.robots import labels
from cpr_jax.robots.catalogue import rfrfr, rfrfr_straight, three_rfr
from cpr_jax.robots.catalogue_space import six_rus, stewart_gough
from cpr_jax.robots.embedding import in_space
from cpr_jax.robots.files import load_robot, robot_from_specification, save_robot
from cpr_jax.robots.joint import Joint, clamped, pivot, slider, spherical
from cpr_jax.robots.leg import make_leg, prismatic_screw
from cpr_jax.robots.reading import parse_specification
from cpr_jax.robots.robot import Robot, make_robot
from cpr_jax.rods.rod import kirchhoff_rod, section_rod
from cpr_jax.rods.section import Material, circle, rectangle

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


def assert_same(actual: Any, expected: Any, tolerance: float = 0.0) -> None:
    """All leaves equal, relative to the largest of each."""
    assert jax.tree.structure(actual) == jax.tree.structure(expected)
    for a, b in zip(jax.tree.leaves(actual), jax.tree.leaves(expected), strict=True):
        scale = np.max(np.abs(b), initial=0.0)
        np.testing.assert_allclose(a, b, rtol=0.0, atol=tolerance * scale)
        assert np.shape(a) == np.shape(b)


def loaded(**entries: Any) -> Robot:
    """The robot of a mapping, which must not be suspicious."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return robot_from_specification(parse_specification({"format": 1, **entries}))


def various_plane() -> Robot:
    """A planar robot with everything that legs can differ in."""
    material = Material(2.7e9, 0.35, 1200.0)
    section = rectangle(0.002, 0.01)
    gravity = (0.0, -9.81)
    oblique = Joint(free=jnp.array([0.0, 1.0, 0.0]), lever=jnp.asarray(0.0))
    rod = kirchhoff_rod(PLANE, 0.3, 1.0 / 3.0, -1.0 / 3.0, force=(0.1, -0.0), moment=0.2)
    legs = [
        make_leg(
            PLANE, (0.1, -0.2), section_rod(PLANE, 0.2, section, material, 0.3, True, gravity)
        ),
        make_leg(
            PLANE,
            (1.0 / 3.0, 5e-324),
            dataclasses.replace(rod, moment=jnp.array([0.2])),
            a=(0.1, 0.2),
            b=(-0.1, 0.0),
            base_rotation=(0.7,),
            screw=(0.6, 0.8, 0.0),
            joint=oblique,
            attachment_position=(0.1, 0.2),
            attachment_rotation=(-0.3,),
        ),
        make_leg(PLANE, (0, 0), rod, screw=prismatic_screw(PLANE), joint=clamped(PLANE)),
        make_leg(PLANE, (0, 0), kirchhoff_rod(PLANE, 1, 1), joint=slider(PLANE)),
    ]
    legs[2] = eqx.tree_at(lambda leg: leg.rod.moment, legs[2], jnp.array([0.2]))
    return make_robot(
        PLANE,
        legs,
        oriented=True,
        f_P=(1e-17, 1.0 / 3.0),
        m_P=(0.1,),
        home=((0.1, 0.2, 0.3, 0.4), (0.0, 0.2, 1.0)),
        uncertainty={"k_b1": 0.1, "base2_y": 1e-3, "m_P_x": 0.3},
        name='quoted "é" \\ name',
    )


def various_space() -> Robot:
    """A spatial robot with everything that legs can differ in."""
    rod = section_rod(SPACE, 0.2, circle(0.001), Material(2e11, 0.3), (0.1, 0.2, 0.3), True)
    legs = [
        make_leg(SPACE, (0.1, 0.2, 0.3), rod, joint=spherical(SPACE), screw=(0, 0, 0, 0.6, 0, 0.8)),
        make_leg(
            SPACE,
            (0, 0, 0),
            kirchhoff_rod(SPACE, 0.2, (0.3, 0.7, 1.1), force=(0, 0, -1), moment=(1, 0, 0)),
            joint=Joint(free=jnp.array([0, 0, 0, 0, 1.0, 1.0]), lever=jnp.asarray(1.0)),
            base_rotation=(0.1, 0.2, 0.3),
        ),
    ]
    return make_robot(SPACE, legs, oriented=True, m_P=(1, 2, 3), uncertainty={"k_t1": 0.1})


ROBOTS = {
    "rfrfr": rfrfr,
    "rfrfr_printed": lambda: rfrfr(printed_moment_row=True),
    "rfrfr_straight": rfrfr_straight,
    "three_rfr": three_rfr,
    "rfrfr_in_space": lambda: in_space(rfrfr()),
    "three_rfr_in_space": lambda: in_space(three_rfr()),
    "various_plane": various_plane,
    "various_space": various_space,
}


def test_axes_are_those_of_the_geometries() -> None:
    for geometry in (PLANE, SPACE):
        assert labels.AXES[geometry.name] == geometry.axes
        assert labels.ROTATION_AXES[geometry.name] == geometry.rotation_axes


CATALOGUE = {
    "rfrfr": rfrfr,
    "three_rfr": three_rfr,
    "stewart-gough": stewart_gough,
    "six-rus": six_rus,
}


@pytest.mark.parametrize("name", CATALOGUE)
def test_examples_are_the_catalogue(name: str) -> None:
    assert {path.stem for path in EXAMPLES.glob("*.toml")} == set(CATALOGUE)
    robot = load_robot(EXAMPLES / f"{name}.toml")
    assert_same(robot, CATALOGUE[name](), 4e-15)
    assert robot.name == CATALOGUE[name]().name


@pytest.mark.parametrize("name", ROBOTS)
def test_round_trip(name: str, tmp_path: pathlib.Path) -> None:
    robot = ROBOTS[name]()
    save_robot(robot, tmp_path / "robot.toml")
    again = load_robot(tmp_path / "robot.toml")
    assert_same(again, robot)
    assert list(again.uncertainty) == list(robot.uncertainty)
    assert [path.name for path in tmp_path.iterdir()] == ["robot.toml"]


@pytest.mark.filterwarnings("ignore:Argument:UserWarning")
def test_round_trip_of_random_numbers(tmp_path: pathlib.Path) -> None:
    """Among random compliances are those that are the inverse of no float."""
    random = np.random.default_rng(0)
    robot = three_rfr()
    for _ in range(20):
        robot = jax.tree.map(
            lambda leaf: leaf if leaf.ndim < 1 else leaf * random.uniform(0.5, 2.0, leaf.shape),
            robot,
        )
        robot = eqx.tree_at(
            lambda robot: (robot.transmission, robot.legs.screw, robot.legs.joint),
            robot,
            (jnp.eye(3), three_rfr().legs.screw, three_rfr().legs.joint),
        )
        save_robot(robot, tmp_path / "robot.toml")
        assert_same(load_robot(tmp_path / "robot.toml"), robot)


def test_saved_file_is_readable_by_people(tmp_path: pathlib.Path) -> None:
    save_robot(rfrfr(), tmp_path / "robot.toml")
    document = tomllib.loads((tmp_path / "robot.toml").read_text(encoding="utf-8"))
    assert document["legs"][0] == {
        "base": [-0.1, 0.0],
        "motor": "revolute",
        "a": 0.045,
        "b": 0.035,
        "joint": "pivot",
        "rod": {"length": 0.25, "bending_stiffness": 0.0183, "precurvature": -1.0},
    }


def _changed(where: Any, value: Any) -> Robot:
    return eqx.tree_at(where, three_rfr(), value, is_leaf=lambda leaf: leaf is None)


@pytest.mark.parametrize(
    ("robot", "text"),
    [
        (lambda: _changed(lambda r: r.transmission, jnp.full((3, 3), 0.5)), "transmission"),
        (lambda: _changed(lambda r: r.legs.feed, jnp.array([0.0, 0.1, 0.0])), "legs.feed"),
        (lambda: _changed(lambda r: r.legs.screw, jnp.ones((3, 3))), "legs.screw"),
        (lambda: _changed(lambda r: r.legs.joint.lever, jnp.full(3, 0.5)), "joint.lever"),
        (lambda: _changed(lambda r: r.legs.joint.free, jnp.full((3, 3), 0.5)), "joint.free"),
        (lambda: _changed(lambda r: r.legs.rod.length, jnp.array([1, 1, -1.0])), "rod.length"),
        (lambda: _changed(lambda r: r.legs.a, jnp.full((3, 2), jnp.nan)), "legs[0].a"),
        (lambda: _changed(lambda r: r.uncertainty, {"mass": jnp.array(1.0)}), "uncertainty.mass"),
        (lambda: _changed(lambda r: r.home.q_a, jnp.zeros(2)), "home.motors"),
        (lambda: jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), rfrfr()), "batch"),
        (lambda: dataclasses.replace(rfrfr(), name="two\nlines"), "name"),
        (lambda: dataclasses.replace(rfrfr(), m_P=jnp.ones(1)), "m_P"),
    ],
)
def test_what_no_file_can_express(robot: Any, text: str, tmp_path: pathlib.Path) -> None:
    with pytest.raises(ValueError) as raised:
        save_robot(robot(), tmp_path / "robot.toml")
    assert text in str(raised.value)
    assert " must " in str(raised.value)
    assert list(tmp_path.iterdir()) == []


def test_fed_length_of_zero_is_none(tmp_path: pathlib.Path) -> None:
    save_robot(_changed(lambda r: r.legs.feed, jnp.zeros(3)), tmp_path / "robot.toml")
    assert_same(load_robot(tmp_path / "robot.toml"), three_rfr())


def test_failing_write_keeps_the_old_file(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "robot.toml"
    save_robot(rfrfr(), path)
    before = path.read_bytes()

    def full_disk(descriptor: int) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr("os.fsync", full_disk)
    with pytest.raises(OSError, match="No space"):
        save_robot(three_rfr(), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


MATERIAL = {"E": "2.7 GPa", "nu": 0.4, "density": "1200 kg/m^3"}


@pytest.mark.parametrize(
    ("geometry", "section", "made", "gravity"),
    [
        (
            PLANE,
            {"kind": "rectangle", "width": "2 mm", "height": "10 mm"},
            rectangle(0.002, 0.01),
            [0, -9.81],
        ),
        (SPACE, {"kind": "circle", "radius": "2 mm"}, circle(0.002), [0, 0, -9.81]),
    ],
)
def test_section_and_material(geometry: Any, section: Any, made: Any, gravity: Any) -> None:
    rod = {
        "length": "250 mm",
        "section": section,
        "material": MATERIAL,
        "precurvature": 2.0,
        "extensible": True,
    }
    robot = loaded(
        geometry=geometry.name,
        platform={"kind": "body"},
        environment={"gravity": gravity},
        legs=[{"base": [0.0] * geometry.d, "joint": "pivot", "rod": rod}],
    )
    expected = section_rod(geometry, 0.25, made, Material(2.7e9, 0.4, 1200.0), 2.0, True, gravity)
    assert_same(robot.leg(0).rod, expected, 1e-15)


def test_weight_adds_to_the_load_of_a_measured_rod() -> None:
    rod = {
        "length": 1.0,
        "bending_stiffness": 0.5,
        "section": {"kind": "circle", "radius": "5 mm"},
        "material": {"density": 1000.0},
        "force": [1.0, 2.0],
    }
    legs = [{"base": [0, 0], "rod": rod}]
    gravity = {"gravity": [0, -10.0]}
    robot = loaded(geometry="plane", platform={"kind": "point"}, environment=gravity, legs=legs)
    np.testing.assert_allclose(
        robot.legs.rod.force, [[1.0, 2.0 - 1e4 * np.pi * 0.005**2]], rtol=1e-15
    )
    np.testing.assert_array_equal(robot.legs.rod.curvature_compliance, [[2.0]])


def test_motors_and_joints_are_those_of_the_package() -> None:
    rod = {"length": 1.0, "bending_stiffness": 1.0}
    for geometry in (PLANE, SPACE):
        zero = [0.0] * geometry.d
        for name, joint in [
            ("pivot", pivot), ("spherical", spherical), ("clamped", clamped), ("slider", slider),
        ]:  # fmt: skip
            leg = {"base": zero, "motor": "prismatic", "joint": name, "rod": rod}
            robot = loaded(geometry=geometry.name, platform={"kind": "body"}, legs=[leg])
            assert_same(robot.leg(0).joint, joint(geometry))
            assert_same(robot.leg(0).screw, prismatic_screw(geometry))


def test_axis_of_any_length() -> None:
    leg = {
        "base": [0, 0],
        "motor": {"kind": "prismatic", "axis": [3, 4]},
        "rod": {"length": 1, "bending_stiffness": 1},
    }
    robot = loaded(geometry="plane", platform={"kind": "point"}, legs=[leg])
    np.testing.assert_array_equal(robot.legs.screw, [[0.6, 0.8, 0.0]])


def test_suspicions_become_warnings() -> None:
    rod = {
        "length": 1,
        "bending_stiffness": "1.83e-2 N*mm^2",
        "section": {"kind": "rectangle", "width": "2 mm", "height": "10 mm"},
    }
    with pytest.warns(UserWarning, match=r"legs\[0\]\.rod\.bending_stiffness` implies E = 2\.7"):
        robot_from_specification(
            parse_specification(
                {
                    "format": 1,
                    "geometry": "plane",
                    "platform": {"kind": "point"},
                    "legs": [{"base": [0, 0], "rod": rod}],
                }
            )
        )
