"""Mistakes in robot files: each is refused with one line. Nothing here imports jax."""

import datetime
import math
import pathlib
import tomllib
from typing import Any

import pytest

from cpr_jax.errors import InputError
from cpr_jax.robots.reading import parse_specification, read_specification

from .documents import DOCUMENTS, MISSING, edited

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
    # Segments.
    ("segments", "legs.0.rod.segments", [], "legs[0].rod.segments"),
    ("segments", "legs.0.rod.segments", {"length": 0.1}, "legs[0].rod.segments"),
    ("segments", "legs.0.rod.segments.1", "150 mm", "legs[0].rod.segments[1]"),
    ("segments", "legs.0.rod.length", "250 mm", "legs[0].rod.length"),
    ("segments", "legs.0.rod.segments.1.length", MISSING, "legs[0].rod.segments[1].length"),
    ("segments", "legs.0.rod.segments.1.length", 0, "legs[0].rod.segments[1].length"),
    ("segments", "legs.0.rod.segments.1.lenght", 1, "legs[0].rod.segments[1].lenght"),
    ("segments", "legs.0.rod.segments.1.segments", [], "legs[0].rod.segments[1].segments"),
    ("segments", "legs.0.rod.segments.1.force.1", "1 N", "legs[0].rod.segments[1].force[1]"),
    ("segments", "legs.0.rod.segments.1.precurvature", 1, "legs[0].rod.segments[1].precurvature"),
    ("segments", "uncertainty.l1", "1 mm", ""),
    ("segments", "uncertainty.k_b1", 1e-3, ""),
    ("segments", "uncertainty.k_b1_3", 1e-3, ""),
    ("segments", "uncertainty.k_b1_0", 1e-3, ""),
    ("segments", "uncertainty.k_b2_1", 1e-3, ""),
    # Motors and joints.
    ("body", "legs.1.motor", "linear", "legs[1].motor"),
    ("body", "legs.1.motor", 1, "legs[1].motor"),
    ("body", "legs.1.motor.kind", MISSING, "legs[1].motor.kind"),
    ("body", "legs.1.motor.kind", "revolute", "legs[1].motor.axis"),
    ("body", "legs.1.motor.axis", [0, 0], "legs[1].motor.axis"),
    ("body", "legs.1.motor.axis", [0, 1, 0], "legs[1].motor.axis"),
    ("body", "legs.1.motor.axis.0", "1 mm", "legs[1].motor.axis[0]"),
    ("body", "legs.1.motor.gear", 2, "legs[1].motor.gear"),
    ("body", "legs.1.motor.ratio", 0, "legs[1].motor.ratio"),
    ("body", "legs.1.motor.ratio", "2 mm", "legs[1].motor.ratio"),
    ("body", "legs.1.joint", "pivoted", "legs[1].joint"),
    ("body", "legs.1.joint", 3, "legs[1].joint"),
    ("body", "legs.1.joint", {}, "legs[1].joint.free"),
    ("body", "legs.1.joint.free", [1, 1, 1], "legs[1].joint.free"),
    ("body", "legs.1.joint.free", [0, 1], "legs[1].joint.free"),
    ("body", "legs.1.joint.free", [0, 0.5, 0], "legs[1].joint.free"),
    ("body", "legs.1.joint.free", [0, "y", 0], "legs[1].joint.free"),
    ("space", "legs.0.joint", MISSING, "legs[0].joint"),
    ("space", "legs.0.joint", "cardan", "legs[0].joint"),
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
    # The platform's weight and other loads.
    ("motors", "platform.mass", "100 N", ""),
    ("motors", "platform.mass", 0, ""),
    ("motors", "environment", MISSING, "platform.mass"),
    ("motors", "platform.mass", MISSING, "platform.center_of_mass"),
    ("motors", "platform.center_of_mass", "10 mm", ""),
    ("motors", "platform.center_of_mass.2", "10 N", "platform.center_of_mass[2]"),
    ("motors", "platform.loads", [], ""),
    ("motors", "platform.loads", {"position": [0, 0, 0], "force": [0, 0, 1]}, ""),
    ("motors", "platform.loads.0", 1, "platform.loads[0]"),
    ("motors", "platform.loads.0.position", MISSING, "platform.loads[0].position"),
    ("motors", "platform.loads.0.position", [0, 0], "platform.loads[0].position"),
    ("motors", "platform.loads.0.force", MISSING, "platform.loads[0].force"),
    ("motors", "platform.loads.0.force.2", "1 kg", "platform.loads[0].force[2]"),
    ("motors", "platform.loads.0.moment", [0, 0, 0], "platform.loads[0].moment"),
    ("point", "platform.loads", [{"position": [0, 0], "force": [0, 1]}], ""),
    ("point", "platform.center_of_mass", [0, 0], ""),
    # Motors that move several legs.
    ("motors", "motors", 2, ""),
    ("motors", "motors", [], ""),
    ("motors", "motors", [1, 2], "motors[0]"),
    ("motors", "motors.0", [], "motors[0]"),
    ("motors", "motors.0.1", 0, "motors[0][1]"),
    ("motors", "motors.0.1", 6, "motors[0][1]"),
    ("motors", "motors.0.1", True, "motors[0][1]"),
    ("motors", "motors.0.1", 2.0, "motors[0][1]"),
    ("motors", "motors.0.1", "2", "motors[0][1]"),
    ("motors", "motors.0.1", 1, "motors[0][1]"),
    ("motors", "motors.0.1", 4, "motors[0][1]"),
    ("motors", "motors.0.1", 3, "motors[0][1]"),
    ("motors", "motors.1.1", 2, "motors[1][1]"),
    ("motors", "motors.1", [3], "motors"),
    ("motors", "motors", MISSING, "home.motors"),
    ("motors", "home.motors", [0, 0, 0, 0, 0], ""),
    ("motors", "home.motors.0", "10 mm", "home.motors[0]"),
    ("motors", "home.motors.1", "10 deg", "home.motors[1]"),
    ("body", "motors", [[1, 2]], "motors[0][1]"),
    ("space", "legs.0.motor", "none", "legs"),
    # Motors of each kind.
    ("motors", "legs.0.motor.ratio", 0, "legs[0].motor.ratio"),
    ("motors", "legs.0.motor.axis", [0, 0, 0], "legs[0].motor.axis"),
    ("motors", "legs.4.motor.axis", [1, 0, 0], "legs[4].motor.axis"),
    ("motors", "legs.2.motor", {"kind": "feed", "axis": [1, 0, 0]}, "legs[2].motor.axis"),
    ("motors", "legs.3.motor", {"kind": "none", "ratio": 1}, "legs[3].motor.ratio"),
    ("motors", "legs.3.motor", "fixed", "legs[3].motor"),
    # Passive joints at the base.
    ("motors", "legs.0.base_joint", "cardan", "legs[0].base_joint"),
    ("motors", "legs.0.base_joint", 1, "legs[0].base_joint"),
    ("motors", "legs.0.base_joint.joint", MISSING, "legs[0].base_joint.joint"),
    ("motors", "legs.0.base_joint.joint", {"free": [0] * 6}, "legs[0].base_joint.joint"),
    ("motors", "legs.0.base_joint.free", [0] * 6, "legs[0].base_joint.joint"),
    ("motors", "legs.0.base_joint.lever", 1, "legs[0].base_joint.lever"),
    ("motors", "legs.0.base_joint.position", "50 mm", "legs[0].base_joint.position"),
    ("motors", "legs.0.base_joint.position.0", "50 N", "legs[0].base_joint.position[0]"),
    ("motors", "legs.0.base_joint.rotation", "90 deg", "legs[0].base_joint.rotation"),
    ("motors", "legs.1.base_joint.free", [1] * 6, "legs[1].base_joint.free"),
    ("motors", "legs.1.base_joint.free", [0, 1, 0], "legs[1].base_joint.free"),
    (
        "body",
        "legs.1.base_joint",
        {"joint": "pivot", "position": [0, 0, 0]},
        "legs[1].base_joint.position",
    ),
    # Orientations in space.
    ("motors", "legs.0.base_rotation", "90 deg", "legs[0].base_rotation"),
    ("motors", "legs.0.base_rotation", "upright", "legs[0].base_rotation"),
    ("motors", "legs.0.base_rotation", [0, 0], "legs[0].base_rotation"),
    ("motors", "legs.0.base_rotation", {}, "legs[0].base_rotation.tangent"),
    ("motors", "legs.0.base_rotation.tangent", MISSING, "legs[0].base_rotation.tangent"),
    ("motors", "legs.0.base_rotation.tangent", [0, 0, 0], "legs[0].base_rotation.tangent"),
    ("motors", "legs.0.base_rotation.tangent", [0, 1], "legs[0].base_rotation.tangent"),
    ("motors", "legs.0.base_rotation.tangent.2", "1 mm", "legs[0].base_rotation.tangent[2]"),
    ("motors", "legs.0.base_rotation.third", [0, 0, -2], "legs[0].base_rotation.third"),
    ("motors", "legs.0.base_rotation.third", "x", "legs[0].base_rotation.third"),
    ("motors", "legs.0.base_rotation.angle", 1, "legs[0].base_rotation.angle"),
    ("motors", "legs.0.base_rotation.axis", [0, 0, 1], "legs[0].base_rotation.tangent"),
    ("motors", "legs.0.base_rotation.second", [0, 1, 0], "legs[0].base_rotation.second"),
    ("motors", "legs.2.attachment_rotation.tangent", 1, "legs[2].attachment_rotation.tangent"),
    ("motors", "home.rotation.axis", MISSING, "home.rotation.tangent"),
    ("motors", "home.rotation.axis", [0, 0, 0], ""),
    ("motors", "home.rotation.angle", MISSING, ""),
    ("motors", "home.rotation.angle", "30 mm", ""),
    ("motors", "home.rotation.third", [1, 0, 0], ""),
    ("body", "home.rotation", {"axis": [0, 0, 1], "angle": 1}, ""),
    ("body", "legs.1.base_rotation", {"tangent": [0, 1]}, "legs[1].base_rotation"),
    # Sections.
    ("motors", "defaults.leg.rod.section.shear_factor", 0, ""),
    ("motors", "defaults.leg.rod.section.shear_factor", "1 mm", ""),
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
    ("point", "uncertainty.r_c1", 1e-3, ""),
    ("point", "uncertainty.r_c", 1e-3, ""),
    ("point", "uncertainty.f1_y", 1e-3, ""),
    ("point", "uncertainty.m_P_x", 1e-3, ""),
    ("point", "uncertainty.k_b0", 1e-3, ""),
    ("point", "uncertainty.k_b3", 1e-3, ""),
    ("point", "uncertainty.k_t1", 1e-3, ""),
    ("point", "uncertainty.kb1", 1e-3, ""),
    ("point", "uncertainty.base1_x", 1e-3, ""),
    ("point", "uncertainty.f_P_x", 1e-3, ""),
]


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
        ("point", "legs.0.rod.joint", "pivot", "it belongs to `legs` or `base_joint`."),
        ("point", "motor", [[1], [2]], "did you mean `motors`?"),
        ("motors", "legs.0.base_joint", "univeral", "did you mean 'universal'?"),
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
