"""What robot files mean, in plain numbers. Nothing here imports jax."""

import copy
import pathlib
import re
import subprocess
import sys
import tomllib
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cpr_jax.errors import InputError
from cpr_jax.robots.labels import parameter_dimension, parameter_dimensions
from cpr_jax.robots.reading import parse_specification, read_specification
from cpr_jax.robots.specification import RobotSpecification

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))
RECTANGLE = {"kind": "rectangle", "width": "2 mm", "height": "10 mm"}


def one_leg(**rod: Any) -> dict[str, Any]:
    """A robot file with one leg."""
    return {
        "format": 1,
        "geometry": "plane",
        "platform": {"kind": "point"},
        "legs": [{"base": [0, 0], "rod": {"length": "250 mm", **rod}}],
    }


def documented() -> list[RobotSpecification]:
    """The complete examples of the documentation: in space, planar, with segments."""
    text = (ROOT / "docs" / "robot-files.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```toml\n(.*?)```", text, flags=re.DOTALL)
    complete = [block for block in blocks if re.search(r"^format = 1", block, flags=re.MULTILINE)]
    return [parse_specification(tomllib.loads(block)) for block in complete]


def test_neither_jax_nor_numpy_is_imported() -> None:
    code = "import sys, cpr_jax.robots.reading; print({'jax', 'numpy'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert run.stdout == "set()\n", run.stderr


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_raise_no_suspicion(path: pathlib.Path) -> None:
    assert read_specification(path).warnings == ()


def test_rfrfr_example() -> None:
    robot = read_specification(ROOT / "examples" / "rfrfr.toml")
    assert (robot.name, robot.geometry, robot.platform.kind) == ("RFRFR", "plane", "point")
    assert robot.platform.force == (0.0, 1.0)
    assert (robot.motors, robot.turning) == (((0,), (1,)), (True, True))
    assert [leg.base for leg in robot.legs] == [(-0.1, 0.0), (0.1, 0.0)]
    assert [leg.rod.precurvature for leg in robot.legs] == [(-1.0,), (1.0,)]
    for leg in robot.legs:
        assert (leg.a, leg.b) == ((0.045, 0.0), (0.035, 0.0))
        assert (leg.rod.length, leg.rod.bending_stiffness) == (0.25, (0.0183,))
    assert robot.uncertainty == {"k_b1": 4.73e-3, "r_c1": 0.1, "k_b2": 4.73e-3, "r_c2": 0.1}


def test_documented_example() -> None:
    robot = documented()[1]
    assert robot.warnings == ()
    first, _, third = robot.legs
    assert first.rod.bending_stiffness is None
    assert first.rod.mass_per_length == pytest.approx(0.024)
    assert third.rod.bending_stiffness == (0.0183,)
    assert third.rod.mass_per_length == pytest.approx(0.024)
    assert third.rod.length == 0.245
    assert third.a == first.a == (0.02, 0.0)
    assert (third.motor.kind, third.joint) == ("prismatic", "clamped")
    assert robot.home is not None
    assert robot.home.motors[2] == -0.025


def test_documented_robot_in_space() -> None:
    """It is symmetric about z; its motors turn from outward to upward."""
    robot = documented()[0]
    assert robot.warnings == ()
    assert (robot.platform.kind, robot.platform.mass) == ("body", 0.05)
    for angle, leg in zip((0.0, 120.0, 240.0), robot.legs, strict=True):
        about = Rotation.from_euler("z", angle, degrees=True)
        np.testing.assert_allclose(leg.base, about.apply([0.12, 0, 0]), atol=1e-5)
        np.testing.assert_allclose(leg.attachment, about.apply([0.06, 0, 0]), atol=1e-5)
        axes = Rotation.from_rotvec(leg.base_rotation).apply(np.eye(3))
        outward = about.apply([1, 0, 0])
        np.testing.assert_allclose(axes[:2], [outward, [0, 0, 1]], atol=1e-4)


def test_byte_order_mark_and_windows_line_ends(tmp_path: pathlib.Path) -> None:
    text = (ROOT / "examples" / "rfrfr.toml").read_text(encoding="utf-8")
    path = tmp_path / "robot.toml"
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert read_specification(path) == read_specification(ROOT / "examples" / "rfrfr.toml")


def test_own_choice_replaces_a_default_of_another_kind() -> None:
    mapping = one_leg(precurvature_radius="2 m", curvature_compliance=50)
    mapping["defaults"] = {"leg": {"rod": {"precurvature": 3, "bending_stiffness": 1}}}
    rod = parse_specification(mapping).legs[0].rod
    assert rod.precurvature == (0.5,)
    assert (rod.bending_stiffness, rod.curvature_compliance) == (None, (50.0,))


def test_tables_with_a_kind_are_replaced_as_a_whole() -> None:
    mapping = one_leg(section={"kind": "circle", "radius": "1 mm"})
    mapping["defaults"] = {"leg": {"rod": {"section": RECTANGLE, "material": {"E": "2 GPa"}}}}
    section = parse_specification(mapping).legs[0].rod.section
    assert section is not None
    assert (section.kind, section.sizes) == ("circle", (0.001,))


def test_parsing_leaves_its_input_alone() -> None:
    mapping = one_leg(bending_stiffness="1 N*m^2")
    before = copy.deepcopy(mapping)
    parse_specification(mapping)
    assert mapping == before


@pytest.mark.parametrize(
    ("rod", "texts"),
    [
        # Table 1 of the paper, taken literally.
        (
            {"bending_stiffness": "1.83e-2 N*mm^2", "section": RECTANGLE},
            ["`legs[0].rod.bending_stiffness`", "2.7", " kPa"],
        ),
        (
            {"curvature_compliance": "1e-9 1/(N*mm^2)", "section": RECTANGLE},
            ["`legs[0].rod.curvature_compliance`", "150 TPa"],
        ),
        (
            {"section": RECTANGLE, "material": {"E": "2700 mPa"}},
            ["`legs[0].rod.material.E`", "2.7 Pa"],
        ),
        (
            {
                "bending_stiffness": "1.83e-2 N*m^2",
                "section": RECTANGLE,
                "material": {"E": "200 GPa"},
            },
            ["`legs[0].rod.bending_stiffness`", "2.7", "200 GPa"],
        ),
    ],
)
def test_suspicious_stiffness(rod: dict[str, Any], texts: list[str]) -> None:
    (warning,) = parse_specification(one_leg(**rod)).warnings
    for text in texts:
        assert text in warning
    assert warning.isprintable()


def test_legs_with_the_same_rod_warn_once() -> None:
    mapping = one_leg(bending_stiffness="1.83e-2 N*mm^2", section=RECTANGLE)
    mapping["legs"] *= 3
    assert len(parse_specification(mapping).warnings) == 1


def test_weightless_rod_under_gravity() -> None:
    mapping = one_leg(bending_stiffness=1) | {"environment": {"gravity": [0, -9.81]}}
    (warning,) = parse_specification(mapping).warnings
    assert "`environment.gravity`" in warning
    assert "`legs[0].rod`" in warning


@pytest.mark.parametrize(
    ("joint", "base_joint", "spins"),
    [
        ("spherical", "spherical", True),
        ("swivel", {"free": [0, 0, 0, 1, 0, 0]}, True),
        ("spherical", "universal", False),
        ("clamped", "swivel", False),
        ("spherical", None, False),
    ],
)
def test_leg_that_turns_about_itself(joint: Any, base_joint: Any, spins: bool) -> None:
    mapping = one_leg(bending_stiffness=1) | {"geometry": "space", "platform": {"kind": "body"}}
    mapping["legs"][0] |= {"base": [0, 0, 0], "joint": joint}
    if base_joint is not None:
        mapping["legs"][0]["base_joint"] = base_joint
    warnings = parse_specification(mapping).warnings
    assert len(warnings) == spins
    if spins:
        assert "`legs[0].base_joint` leaves the leg free to turn about itself" in warnings[0]


def test_parameter_dimensions() -> None:
    assert parameter_dimension("k_b2", "plane", [1, 1]).unit == "N*m^2"
    assert parameter_dimension("kappa1", "plane", [1]).unit == "rad/m"
    assert parameter_dimension("m_P_x", "plane", [1]).unit == "N*m"
    assert parameter_dimension("base1_x", "space", [1]).unit == "m"
    assert "k_t1" in parameter_dimensions("space", [1])
    for label, geometry in [
        ("k_b3", "plane"),
        ("k_t1", "plane"),
        ("base1_x", "plane"),
        ("", "space"),
    ]:
        with pytest.raises(InputError, match=r"^Argument `label` must be named after a parameter"):
            parameter_dimension(label, geometry, [1, 1])
