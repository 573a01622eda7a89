"""Mistakes in robot files: each is refused with one line. Nothing here imports jax."""

import copy
import datetime
import math
import pathlib
import tomllib
from typing import Any

import pytest

from cpr_jax.errors import InputError
from cpr_jax.robots.reading import parse_specification, read_specification

DOCUMENTS = {
    "point": """
        format = 1
        geometry = "plane"
        [platform]
        kind = "point"
        [home]
        motors = [2.7, 0.44]
        position = [0, 0.2]
        [[legs]]
        base = [-0.1, 0]
        rod = { length = "250 mm", bending_stiffness = "1.83e-2 N*m^2" }
        [[legs]]
        base = [0.1, 0]
        rod = { length = "250 mm", bending_stiffness = "1.83e-2 N*m^2" }
        [uncertainty]
        k_b1 = "4.73e-3 N*m^2"
        """,
    "body": """
        format = 1
        name = "body"
        geometry = "plane"
        [platform]
        kind = "body"
        force = ["0 N", "1 N"]
        moment = "0 N*m"
        [home]
        motors = ["154 deg", "20 mm"]
        position = ["0 mm", "200 mm"]
        rotation = "0 deg"
        [environment]
        gravity = ["0 m/s^2", "-9.81 m/s^2"]
        [defaults.leg]
        a = "45 mm"
        [defaults.leg.rod]
        length = "250 mm"
        section = { kind = "rectangle", width = "2 mm", height = "10 mm" }
        material = { E = "2.7 GPa", nu = 0.35, density = "1200 kg/m^3" }
        [[legs]]
        base = ["-100 mm", "0 mm"]
        attachment = ["-1 mm", "0 mm"]
        [[legs]]
        base = ["100 mm", "0 mm"]
        base_rotation = "10 deg"
        motor = { kind = "prismatic", axis = [0, 1] }
        joint = { free = [0, 1, 0] }
        attachment_rotation = "10 deg"
        [legs.rod]
        precurvature_radius = "-1 m"
        force = ["0 N/m", "-0.1 N/m"]
        moment = "0 N"
        """,
    "space": """
        format = 1
        geometry = "space"
        [platform]
        kind = "body"
        moment = ["0 N*m", "0 N*m", "0 N*m"]
        [[legs]]
        base = [0, 0, 0]
        base_rotation = ["0 deg", "0 deg", "90 deg"]
        motor = { kind = "revolute", axis = [0, 0, 1] }
        joint = "spherical"
        [legs.rod]
        length = 0.5
        bending_stiffness = [1, 2, 2]
        strain_compliance = [1e-5, 0, 0]
        precurvature = [0, 0, "1/m"]
        """,
}

MISSING = object()

# Document, path of the edit, value put there, field that the message must name ("" for the path).
MISTAKES: list[tuple[str, str, Any, str]] = [
    # The file as a whole.
    ("point", "format", MISSING, ""),
    ("point", "format", 2, ""),
    ("point", "format", "1", ""),
    ("point", "format", True, ""),
    ("point", "format", 1.0, ""),
    ("point", "name", "", ""),
    ("point", "name", 5, ""),
    ("point", "name", "two\nlines", ""),
    ("point", "name", "\x1b[31m", ""),
    ("point", "geometry", MISSING, ""),
    ("point", "geometry", "planar", ""),
    ("point", "geometry", ["plane"], ""),
    ("point", "geometry", "space", "legs[0].base"),
    ("point", "leg", [], ""),
    ("point", "Legs", [], ""),
    ("point", "gravity", [0, -9.81], ""),
    ("point", "ключ\n", 1, "'ключ\\n'"),
    # The platform.
    ("point", "platform", MISSING, ""),
    ("point", "platform", "point", ""),
    ("point", "platform.kind", MISSING, ""),
    ("point", "platform.kind", "pont", ""),
    ("point", "platform.kind", True, ""),
    ("point", "platform.moment", 0.0, ""),
    ("point", "platform.mass", "1 kg", ""),
    ("body", "platform.force", "1 N", ""),
    ("body", "platform.force", ["0 N"], ""),
    ("body", "platform.force", ["0 N", "0 N", "0 N"], ""),
    ("body", "platform.force", ["0 N", "1 m"], "platform.force[1]"),
    ("body", "platform.force.1", math.nan, "platform.force[1]"),
    ("body", "platform.moment", "1 N", ""),
    ("body", "platform.moment", ["1 N*m"], ""),
    ("space", "platform.moment", 0.0, ""),
    # Home.
    ("point", "home", [0.0], ""),
    ("point", "home", {}, "home.motors"),
    ("point", "home.motors", 2.7, ""),
    ("point", "home.motors", [], ""),
    ("point", "home.motors", [2.7], ""),
    ("point", "home.motors.0", "1 mm", "home.motors[0]"),
    ("body", "home.motors.1", "20 deg", "home.motors[1]"),
    ("point", "home.position", MISSING, ""),
    ("point", "home.position", [0, 0, 0.2], ""),
    ("point", "home.position.1", "0.2 rad", "home.position[1]"),
    ("point", "home.rotation", 0.0, ""),
    ("body", "home.rotation", [0.0], ""),
    ("body", "home.rotation", math.inf, ""),
    ("body", "home.postion", [0, 0], ""),
    # Legs.
    ("point", "legs", MISSING, ""),
    ("point", "legs", [], ""),
    ("point", "legs", {"base": [0, 0]}, ""),
    ("point", "legs.1", 5, "legs[1]"),
    ("point", "legs.1", {}, "legs[1].base"),
    ("point", "legs.1.base", MISSING, "legs[1].base"),
    ("point", "legs.1.base", 0.1, "legs[1].base"),
    ("point", "legs.1.base", [0.1], "legs[1].base"),
    ("point", "legs.1.base.0", "0.1 N", "legs[1].base[0]"),
    ("point", "legs.1.base.0", False, "legs[1].base[0]"),
    ("point", "legs.1.Base", [0, 0], "legs[1].Base"),
    ("point", "legs.1.length", "250 mm", "legs[1].length"),
    ("point", "legs.1.attachment", [0, 0], "legs[1].attachment"),
    ("point", "legs.1.attachment_rotation", 0.0, "legs[1].attachment_rotation"),
    ("point", "legs.1.joint", "clamped", "legs[1].joint"),
    ("body", "legs.1.base_rotation", "10 mm", "legs[1].base_rotation"),
    ("body", "legs.1.base_rotation", [0, 0, 0], "legs[1].base_rotation"),
    ("body", "legs.1.attachment", "1 mm", "legs[1].attachment"),
    ("body", "legs.1.attachment_rotation", "1 mm", "legs[1].attachment_rotation"),
    ("body", "legs.1.a", "-45 mm", "legs[1].a"),
    ("body", "legs.1.a", "45 deg", "legs[1].a"),
    ("body", "legs.1.b", [0.1, 0, 0], "legs[1].b"),
    ("body", "legs.1.moment_row", "tip", "legs[1].moment_row"),
    # Motors and joints.
    ("body", "legs.1.motor", "linear", "legs[1].motor"),
    ("body", "legs.1.motor", 1, "legs[1].motor"),
    ("body", "legs.1.motor.kind", MISSING, "legs[1].motor.kind"),
    ("body", "legs.1.motor.kind", "revolute", "legs[1].motor.axis"),
    ("body", "legs.1.motor.axis", [0, 0], "legs[1].motor.axis"),
    ("body", "legs.1.motor.axis", [0, 1, 0], "legs[1].motor.axis"),
    ("body", "legs.1.motor.axis.0", "1 mm", "legs[1].motor.axis[0]"),
    ("body", "legs.1.motor.ratio", 2, "legs[1].motor.ratio"),
    ("body", "legs.1.joint", "pivoted", "legs[1].joint"),
    ("body", "legs.1.joint", 3, "legs[1].joint"),
    ("body", "legs.1.joint", {}, "legs[1].joint.free"),
    ("body", "legs.1.joint.free", [1, 1, 1], "legs[1].joint.free"),
    ("body", "legs.1.joint.free", [0, 1], "legs[1].joint.free"),
    ("body", "legs.1.joint.free", [0, 0.5, 0], "legs[1].joint.free"),
    ("body", "legs.1.joint.free", [0, "y", 0], "legs[1].joint.free"),
    ("space", "legs.0.joint", MISSING, "legs[0].joint"),
    ("space", "legs.0.joint", "universal", "legs[0].joint"),
    ("space", "legs.0.motor.axis", [0, 0], "legs[0].motor.axis"),
    # Rods.
    ("point", "legs.0.rod", MISSING, "legs[0].rod"),
    ("point", "legs.0.rod", "250 mm", "legs[0].rod"),
    ("point", "legs.0.rod.length", MISSING, "legs[0].rod.length"),
    ("point", "legs.0.rod.length", "25 N", "legs[0].rod.length"),
    ("point", "legs.0.rod.length", 0, "legs[0].rod.length"),
    ("point", "legs.0.rod.length", "-250 mm", "legs[0].rod.length"),
    ("point", "legs.0.rod.length", datetime.date(2020, 1, 1), "legs[0].rod.length"),
    ("point", "legs.0.rod.lenght", 0.25, "legs[0].rod.lenght"),
    ("point", "legs.0.rod.joint", "pivot", "legs[0].rod.joint"),
    ("point", "legs.0.rod.bending_stiffness", MISSING, "legs[0].rod.bending_stiffness"),
    ("point", "legs.0.rod.bending_stiffness", 0.0, "legs[0].rod.bending_stiffness"),
    ("point", "legs.0.rod.bending_stiffness", -0.0183, "legs[0].rod.bending_stiffness"),
    ("point", "legs.0.rod.bending_stiffness", math.nan, "legs[0].rod.bending_stiffness"),
    ("point", "legs.0.rod.bending_stiffness", "1 N*m", "legs[0].rod.bending_stiffness"),
    ("point", "legs.0.rod.bending_stiffness", [1, 1, 1], "legs[0].rod.bending_stiffness"),
    ("point", "legs.0.rod.curvature_compliance", 50, "legs[0].rod.bending_stiffness"),
    ("point", "legs.0.rod.section", {"kind": "tube"}, "legs[0].rod.section.kind"),
    ("point", "legs.0.rod.section", {"radius": 1}, "legs[0].rod.section.kind"),
    ("point", "legs.0.rod.section", {"kind": "circle"}, "legs[0].rod.section.radius"),
    ("point", "legs.0.rod.section", {"kind": "circle", "width": 1}, "legs[0].rod.section.width"),
    ("point", "legs.0.rod.extensible", True, "legs[0].rod.extensible"),
    ("body", "defaults.leg.rod.extensible", "yes", ""),
    ("body", "defaults.leg.rod.section.width", 0, ""),
    ("body", "defaults.leg.rod.section.height", "10 mm^2", ""),
    ("body", "defaults.leg.rod.section.height", MISSING, ""),
    ("body", "defaults.leg.rod.section", MISSING, "legs[0].rod.bending_stiffness"),
    ("body", "defaults.leg.rod.material", "steel", ""),
    ("body", "defaults.leg.rod.material.E", "2.7 GN", ""),
    ("body", "defaults.leg.rod.material.E", -1, ""),
    ("body", "defaults.leg.rod.material.E", MISSING, "legs[0].rod.bending_stiffness"),
    ("body", "defaults.leg.rod.material.nu", 0.6, ""),
    ("body", "defaults.leg.rod.material.nu", -1, ""),
    ("body", "defaults.leg.rod.material.density", "0 kg/m^3", ""),
    ("body", "defaults.leg.rod.material.rho", 1200, ""),
    ("body", "defaults.leg.rod.length", MISSING, "legs[0].rod.length"),
    ("body", "defaults.leg.a", "45 N", ""),
    ("body", "defaults.leg.colour", "red", ""),
    ("body", "defaults.rod", {}, ""),
    ("body", "defaults", {}, "defaults.leg"),
    ("body", "legs.1.rod.precurvature_radius", 0, "legs[1].rod.precurvature_radius"),
    ("body", "legs.1.rod.precurvature_radius", "1 rad/m", "legs[1].rod.precurvature_radius"),
    ("body", "legs.1.rod.precurvature", -1, "legs[1].rod.precurvature"),
    ("body", "legs.1.rod.force", "0.1 N/m", "legs[1].rod.force"),
    ("body", "legs.1.rod.force.1", "0.1 N", "legs[1].rod.force[1]"),
    ("body", "legs.1.rod.moment", "0.1 N*m", "legs[1].rod.moment"),
    ("body", "legs.1.rod.strain_compliance", [-1, 0], "legs[1].rod.strain_compliance[0]"),
    ("space", "legs.0.rod.bending_stiffness", [1, 1], "legs[0].rod.bending_stiffness"),
    ("space", "legs.0.rod.bending_stiffness.1", 0, "legs[0].rod.bending_stiffness[1]"),
    ("space", "legs.0.rod.strain_compliance", [0, 0], "legs[0].rod.strain_compliance"),
    ("space", "legs.0.rod.precurvature", [0, 0], "legs[0].rod.precurvature"),
    ("space", "legs.0.rod.precurvature.2", "1 m", "legs[0].rod.precurvature[2]"),
    # Environment and uncertainty.
    ("body", "environment", 9.81, ""),
    ("body", "environment", {}, "environment.gravity"),
    ("body", "environment.gravity", -9.81, ""),
    ("body", "environment.gravity.1", "-9.81 m/s", "environment.gravity[1]"),
    ("body", "environment.wind", 1, ""),
    ("point", "uncertainty", [1], ""),
    ("point", "uncertainty.k_b1", 0, ""),
    ("point", "uncertainty.k_b1", "-1e-3 N*m^2", ""),
    ("point", "uncertainty.k_b1", "1 N*mm", ""),
    ("point", "uncertainty.k_b1", True, ""),
    ("point", "uncertainty.k_b0", 1e-3, ""),
    ("point", "uncertainty.k_b3", 1e-3, ""),
    ("point", "uncertainty.k_t1", 1e-3, ""),
    ("point", "uncertainty.kb1", 1e-3, ""),
    ("point", "uncertainty.base1_x", 1e-3, ""),
    ("point", "uncertainty.f_P_x", 1e-3, ""),
]


def edited(document: str, path: str, value: Any) -> dict[str, Any]:
    """A document with one value put in, or taken out where the value is `MISSING`."""
    root = tomllib.loads(DOCUMENTS[document])
    *parents, last = [int(key) if key.isdigit() else key for key in path.split(".")]
    place: Any = root
    for key in parents:
        place = place[key]
    if value is MISSING:
        del place[last]
    else:
        place[last] = copy.deepcopy(value)
    return root


@pytest.mark.parametrize("document", DOCUMENTS)
def test_the_documents_are_good(document: str) -> None:
    assert parse_specification(tomllib.loads(DOCUMENTS[document])).warnings == ()


@pytest.mark.parametrize(("document", "path", "value", "field"), MISTAKES)
def test_mistake(document: str, path: str, value: Any, field: str) -> None:
    with pytest.raises(InputError) as raised:
        parse_specification(edited(document, path, value), "robot.toml")
    message = str(raised.value)
    assert message.startswith(f"robot.toml: Argument `{field or path}` must ")
    assert ", but " in message
    assert message.isprintable()


@pytest.mark.parametrize(
    ("document", "path", "value", "hint"),
    [
        ("point", "legs.0.rod.lenght", 0.25, "did you mean `length`?"),
        ("point", "legs.0.rod.joint", "pivot", "it belongs to `legs`."),
        ("point", "leg", [], "did you mean `legs`?"),
        ("point", "legs.0.joint", "pivto", "did you mean 'pivot'?"),
        ("point", "uncertainty.kb1", 1e-3, "did you mean 'k_b1'?"),
    ],
)
def test_suggestion(document: str, path: str, value: Any, hint: str) -> None:
    with pytest.raises(InputError) as raised:
        parse_specification(edited(document, path, value))
    assert hint in str(raised.value)


@pytest.mark.parametrize("root", [None, [], "format = 1", 1])
def test_no_mapping(root: Any) -> None:
    with pytest.raises(InputError, match="must be a table of keys and values"):
        parse_specification(root)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "`format` must be given"),
        (b"format = ", "is not TOML"),
        (b"format = 1\nformat = 1", "is not TOML"),
        (b"\x00\xff", "is not UTF-8"),
        ("name = 'é'".encode("latin-1"), "is not UTF-8"),
        ("format = 1".encode("utf-16"), "is not UTF-8"),
        (b"x = " + b"[" * 100_000, "is not TOML"),
        (b"x = " + b"1" * 5000, "is not TOML"),
        (b"PK\x03\x04", "is not TOML"),
        (b"#" * 10_000_001, "is longer than"),
    ],
)
def test_unreadable_content(tmp_path: pathlib.Path, content: bytes, reason: str) -> None:
    path = tmp_path / "robot.toml"
    path.write_bytes(content)
    with pytest.raises(InputError) as raised:
        read_specification(path)
    assert reason in str(raised.value)
    assert " must be " in str(raised.value)
    assert str(path) in str(raised.value) or "…" in str(raised.value)
    assert str(raised.value).isprintable()


@pytest.mark.parametrize("name", ["missing.toml", ".", "", "a\0b", "file/robot.toml", "x" * 300])
def test_unreadable_path(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"^Argument `path` must be .*, but .* cannot be opened"):
        read_specification(name)
