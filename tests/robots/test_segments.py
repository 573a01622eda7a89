"""Rods of several segments in robot files: read, checked, written."""

import copy
import dataclasses
import pathlib
import re
import tomllib
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select
from cpr_jax.cli.inputs import check
from cpr_jax.cli.parser import build_parser
from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE
from cpr_jax.robots.catalogue import rfrfr, three_rfr
from cpr_jax.robots.catalogue_space import stewart_gough
from cpr_jax.robots.files import load_robot, robot_from_specification, save_robot
from cpr_jax.robots.reading import parse_specification
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import section_rod
from cpr_jax.rods.section import Material, rectangle
from cpr_jax.rods.segments import first_length, segments_of
from tests.statics.segmented import cut, stepped

from .documents import DOCUMENTS, edited
from .test_files import assert_same

DOCS = pathlib.Path(__file__).parents[2] / "docs" / "robot-files.md"
WEIGHT = np.array([0.0, -9.81]) * 1200.0


def robot_of(mapping: dict[str, Any]) -> cpr.Robot:
    return robot_from_specification(parse_specification(mapping))


def test_segments_take_from_their_rod_what_they_do_not_say() -> None:
    robot = robot_of(tomllib.loads(DOCUMENTS["segments"]))
    first, second = (robot.leg(i).rod for i in range(2))
    material = Material(2.7e9, 0.35)
    wide, narrow = (section_rod(PLANE, 0.1, rectangle(w, 0.01), material) for w in (0.002, 0.001))
    parts = segments_of(first)
    np.testing.assert_allclose(parts.length, [0.1, 0.15], rtol=0, atol=1e-16)
    expected = [wide.curvature_compliance, narrow.curvature_compliance]
    np.testing.assert_array_equal(parts.curvature_compliance, expected)
    np.testing.assert_array_equal(parts.precurvature, [[1.0], [-2.0]])
    weights = [2e-5 * WEIGHT, 1e-5 * WEIGHT + np.array([0.1, 0.0])]
    np.testing.assert_allclose(parts.force, weights, rtol=1e-14)
    # The other leg is uniform, as its defaults say, whatever its neighbour has.
    assert float(second.length) == float(first_length(second)) == 0.25
    np.testing.assert_array_equal(second.further.length, [0.0])


def test_defaults_may_have_segments() -> None:
    """A leg takes them all, gives others, or a length instead."""
    mapping = tomllib.loads(DOCUMENTS["segments"])
    segments = mapping["legs"][0]["rod"].pop("segments")
    mapping["defaults"]["leg"]["rod"].pop("length")
    mapping["defaults"]["leg"]["rod"]["segments"] = segments
    mapping["legs"] += [{"base": [0, 0], "rod": {"length": 0.2}}]
    mapping["legs"] += [{"base": [0, 0], "rod": {"segments": [{"length": 0.3}]}}]
    mapping["uncertainty"] = {"l1_2": 1e-3, "k_b2_1": 1e-3, "k_b3": 1e-3, "k_b4": 1e-3}
    robot = robot_of(mapping)
    np.testing.assert_allclose(robot.legs.rod.length, [0.25, 0.25, 0.2, 0.3], rtol=1e-15)
    np.testing.assert_array_equal(robot.legs.rod.further.length[:, 0], [0.15, 0.15, 0.0, 0.0])
    mapping["defaults"]["leg"]["rod"]["segments"] = [{"length": 0.1}, {}]
    with pytest.raises(InputError, match=r"`defaults.leg.rod.segments\[1\].length` must be given"):
        robot_of(mapping)


def test_a_label_without_a_segment_is_refused_with_a_hint() -> None:
    for label, hint in (("k_b1", "'k_b1_1'"), ("f1_z", "'f1_1_z'"), ("l1", "'l1_1'")):
        with pytest.raises(InputError, match="one of the 2 segments of leg 1") as raised:
            parse_specification(edited("segments", f"uncertainty.{label}", 1e-3))
        assert hint in str(raised.value)


def test_suspicions_name_the_segment() -> None:
    mapping = edited("segments", "legs.0.rod.segments.1.bending_stiffness", "1e-2 N*mm^2")
    (warning,) = parse_specification(mapping).warnings
    assert "`legs[0].rod.segments[1].bending_stiffness` implies E = " in warning
    heavy = copy.deepcopy(mapping)
    heavy["legs"][0]["rod"]["segments"][0]["material"] = {"E": "2.7 GPa"}
    weightless, _ = sorted(parse_specification(heavy).warnings, key=len)
    assert "does not act on `legs[0].rod.segments[0]`" in weightless


SHARES = [(0.3, 0.45, 0.25), (1.0,), (0.123456, 0.876544)]
ROBOTS = {
    "plane": lambda: stepped(three_rfr(), SHARES),
    "space": lambda: stepped(stewart_gough(), SHARES * 2),
    "in space": lambda: cpr.in_space(stepped(three_rfr(), SHARES)),
    "one": lambda: cut(rfrfr(), [(0.1, 0.2, 0.3, 0.4), (1.0,)]),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_round_trip(name: str, tmp_path: pathlib.Path) -> None:
    robot = ROBOTS[name]()
    robot = dataclasses.replace(robot, uncertainty={"k_b1_2": jnp.asarray(1e-3)})
    save_robot(robot, tmp_path / "robot.toml")
    assert_same(load_robot(tmp_path / "robot.toml"), robot)


def test_round_trip_of_random_numbers(tmp_path: pathlib.Path) -> None:
    """Among random lengths are those whose differences and sums round."""
    random = np.random.default_rng(0)
    for _ in range(30):
        shares = [(*random.uniform(0.05, 1.0, count),) for count in (5, 3, 2)]
        robot = stepped(three_rfr(), shares, int(random.integers(1000)))
        save_robot(robot, tmp_path / "robot.toml")
        assert_same(load_robot(tmp_path / "robot.toml"), robot)


def test_what_is_changed_is_saved_too(tmp_path: pathlib.Path) -> None:
    """Legs with fewer segments than others have nothing beyond their tips that could differ."""
    robot = stepped(three_rfr(), SHARES)
    selection = select(robot, ("k_b3_2", "l3_1", "k_b2"))
    robot = selection.set(robot, 1.1 * selection.get(robot))
    save_robot(robot, tmp_path / "robot.toml")
    assert_same(load_robot(tmp_path / "robot.toml"), robot)
    uniform = make_robot(PLANE, [robot.leg(1)], oriented=True)
    save_robot(uniform, tmp_path / "robot.toml")
    assert load_robot(tmp_path / "robot.toml").legs.rod.further is None


def test_saved_segments_are_readable_by_people(tmp_path: pathlib.Path) -> None:
    save_robot(cut(rfrfr(), [(0.5, 0.5), (1.0,)]), tmp_path / "robot.toml")
    document = tomllib.loads((tmp_path / "robot.toml").read_text(encoding="utf-8"))
    half = {"length": 0.125, "bending_stiffness": 0.0183, "precurvature": -1.0}
    assert document["legs"][0]["rod"] == {"segments": [half, half]}
    assert document["legs"][1]["rod"]["length"] == 0.25
    save_robot(cut(rfrfr(), [(0.32, 0.68), (1.0,)]), tmp_path / "robot.toml")
    document = tomllib.loads((tmp_path / "robot.toml").read_text(encoding="utf-8"))
    assert [part["length"] for part in document["legs"][0]["rod"]["segments"]] == [0.08, 0.17]


def documented(name: str):
    blocks = re.findall(r"```toml\n(.*?)```", DOCS.read_text(encoding="utf-8"), flags=re.DOTALL)
    (block,) = (block for block in blocks if name in block)
    return parse_specification(tomllib.loads(block))


def test_the_documented_robot_is_solved() -> None:
    specification = documented("two stepped rods")
    assert specification.warnings == ()
    assert [len(leg.segments) for leg in specification.legs] == [2, 3]
    robot = robot_from_specification(specification)
    solved = cpr.solve_inverse(robot, (0.0, 0.2))
    found = cpr.sensitivity(robot, solved)
    assert found.columns == ("l1_1", "l1_2", "r_c2_3")
    assert np.all(np.max(np.abs(found.Pi_p), axis=0) > 1e-3)
    assert jax.tree.all(jax.tree.map(lambda x: bool(jnp.all(jnp.isfinite(x))), found.Pi_y))


def test_the_documented_body_works_around_its_home() -> None:
    robot = robot_from_specification(documented("three legs"))
    assert robot.home is not None
    at_home = cpr.solve_forward(robot, robot.home.q_a)
    np.testing.assert_allclose(at_home.q_p, robot.home.q_p, atol=0.01)
    for pose in ((0.0, 0.0, 0.0), (0.0, 0.0, 0.1), (0.005, 0.0, 0.0), (0.01, 0.01, -0.17)):
        assert int(cpr.stability(robot, cpr.solve_inverse(robot, pose)).index) == 0


def test_command_line_knows_segments(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(DOCUMENTS["segments"], encoding="utf-8")

    def request(label: str):
        argv = ["sensitivity", str(path), "--motors", "1", "1", "--parameters", label]
        return check(build_parser().parse_args(argv))

    assert request("k_b1_2").parameters == ("k_b1_2",)
    with pytest.raises(InputError, match=r"`--parameters` must name one of the 2 segments"):
        request("k_b1")
