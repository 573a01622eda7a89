"""Motors, passive joints and loads of a robot, saved and loaded to the last bit."""

import pathlib
import warnings
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.robots import catalogue, catalogue_space
from cpr_jax.robots.files import load_robot, save_robot
from cpr_jax.robots.joint import Joint, passive, spherical, swivel, universal
from cpr_jax.robots.leg import make_leg, prismatic_screw
from cpr_jax.robots.robot import Robot, make_robot
from cpr_jax.rods.rod import kirchhoff_rod

from .test_files import assert_same

SPATIAL = {
    name: getattr(catalogue_space, name)
    for name in (
        "stewart_gough", "stewart_gough_clamped", "stewart_gough_sliding", "six_rus", "three_rfs"
    )
}  # fmt: skip


@pytest.mark.parametrize("name", SPATIAL)
def test_round_trip_of_the_spatial_catalogue(name: str, tmp_path: pathlib.Path) -> None:
    robot = SPATIAL[name]()
    save_robot(robot, tmp_path / "robot.toml")
    assert_same(load_robot(tmp_path / "robot.toml"), robot)


def various() -> Robot:
    """A robot with motors, joints and loads of all kinds, with numbers of all digits."""
    random = np.random.default_rng(0)

    def numbers(n: int = 3) -> np.ndarray:
        return random.normal(size=n)

    some = Joint(free=jnp.array([0, 1.0, 0, 1.0, 1.0, 0]), lever=jnp.asarray(1.0))
    legs = [
        make_leg(SPACE, numbers(), kirchhoff_rod(SPACE, 1.0, 1.0), **entries)
        for entries in (
            {"screw": [0, 0, 0, *numbers()], "joint": universal(SPACE)},
            {"screw": [*numbers(), 0, 0, 0], "joint": swivel(SPACE)},
            {"screw": -numbers(1)[0] * prismatic_screw(SPACE), "base_joint": passive(SPACE, some)},
            {"screw": np.zeros(6), "feed": numbers(1)[0]},
            {"screw": np.zeros(6), "stroke": numbers(1)[0], "a": numbers()},
            {
                "screw": [0, 0, 0, 0.6, 0, 0.8],
                "base_joint": passive(SPACE, universal(SPACE), numbers(), numbers()),
            },
            {"screw": np.zeros(6), "base_joint": passive(SPACE, some, numbers(), numbers())},
        )
    ]
    transmission = np.zeros((7, 3))
    for leg, motor in ((0, 0), (1, 1), (2, 1), (3, 2), (4, 1), (5, 0)):
        transmission[leg, motor] = 1.0
    return make_robot(
        SPACE,
        legs,
        oriented=True,
        loads=[(numbers(), numbers()), (numbers(), numbers())],
        transmission=transmission,
        home=(numbers(), numbers(6)),
    )


def test_round_trip_of_all_kinds(tmp_path: pathlib.Path) -> None:
    save_robot(various(), tmp_path / "robot.toml")
    assert_same(load_robot(tmp_path / "robot.toml"), various())


def test_round_trip_of_random_gears(tmp_path: pathlib.Path) -> None:
    """Few products of an axis with a ratio hit a screw to the last bit; they are found."""
    random = np.random.default_rng(1)
    for geometry, screw in (
        (PLANE, (1, 1, 0)),
        (SPACE, (1, 1, 1, 0, 0, 0)),
        (SPACE, [0] * 3 + [1] * 3),
    ):
        for _ in range(50):
            leg = make_leg(
                geometry,
                np.zeros(geometry.d),
                kirchhoff_rod(geometry, 1.0, 1.0),
                screw=screw * np.exp(random.normal(size=geometry.freedoms, scale=3.0)),
            )
            robot = make_robot(geometry, [leg], oriented=True)
            save_robot(robot, tmp_path / "robot.toml")
            assert_same(load_robot(tmp_path / "robot.toml"), robot)


def test_saving_raises_no_suspicion(tmp_path: pathlib.Path) -> None:
    ends = {"joint": spherical(SPACE), "base_joint": passive(SPACE, spherical(SPACE))}
    leg = make_leg(SPACE, np.zeros(3), kirchhoff_rod(SPACE, 1.0, 1.0), **ends)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        save_robot(make_robot(SPACE, [leg], oriented=True), tmp_path / "robot.toml")
    with pytest.warns(UserWarning, match="free to turn about itself"):
        load_robot(tmp_path / "robot.toml")


def test_round_trip_of_shared_and_geared_motors(tmp_path: pathlib.Path) -> None:
    robot = catalogue.three_rfr()
    robot = eqx.tree_at(
        lambda r: (r.transmission, r.legs.screw, r.home.q_a),
        robot,
        (jnp.ones((3, 1)), -3.0 * robot.legs.screw, jnp.zeros(1)),
    )
    save_robot(robot, tmp_path / "robot.toml")
    assert "motors = [[1, 2, 3]]\n" in (tmp_path / "robot.toml").read_text(encoding="utf-8")
    assert_same(load_robot(tmp_path / "robot.toml"), robot)


def test_saved_motors_are_readable_by_people(tmp_path: pathlib.Path) -> None:
    save_robot(catalogue_space.six_rus(), tmp_path / "robot.toml")
    text = (tmp_path / "robot.toml").read_text(encoding="utf-8")
    assert 'motor = "revolute"\n' in text
    assert 'base_joint = { joint = "universal", position = [0.05, 0.0, 0.0], rotation = ' in text
    assert "[[platform.loads]]\nposition = [0.0, 0.0, 0.01]\n" in text
    save_robot(catalogue_space.stewart_gough(), tmp_path / "robot.toml")
    text = (tmp_path / "robot.toml").read_text(encoding="utf-8")
    assert 'motor = "feed"\n' in text and 'joint = "swivel"\n' in text
    assert "motors = [0.01," in text and "motors = [[" not in text


@pytest.mark.parametrize(
    ("where", "change", "text"),
    [
        (lambda r: r.transmission, lambda t: 2.0 * t, "transmission"),
        (lambda r: r.transmission, lambda t: t.at[0].set(0.0), "motors"),
        (lambda r: r.legs.screw, lambda s: s.at[0, 0].set(0.1), "legs.screw"),
        (lambda r: r.legs.screw, lambda s: s.at[3, 5].set(0.1), "legs.feed"),
        (lambda r: r.legs.stroke, lambda s: s.at[3, 0].set(0.1), "legs.stroke"),
        (lambda r: r.legs.stroke, lambda s: s.at[4, 1].set(0.1), "legs.stroke"),
        (lambda r: r.legs.base_joint.free, lambda f: f.at[2, 0].set(0.5), "base_joint.free"),
        (lambda r: r.loads.force, lambda f: f.at[0, 0].set(jnp.inf), "loads[0].force[0]"),
    ],
)
def test_what_no_file_can_express(where: Any, change: Any, text: str, tmp_path: Any) -> None:
    robot = eqx.tree_at(where, various(), replace_fn=change)
    with pytest.raises(ValueError, match=" must ") as raised:
        save_robot(robot, tmp_path / "robot.toml")
    assert text in str(raised.value)
    assert list(tmp_path.iterdir()) == []
