"""The commands that compute nothing: `cpr-jax robots` and `cpr-jax validate`."""

import dataclasses
import json
from collections.abc import Sequence

from ..errors import InputError
from ..robots.names import CATALOGUE
from ..robots.reading import read_specification
from ..robots.schema import schema_text
from ..robots.specification import RobotSpecification


def robots(as_json: bool) -> int:
    """Prints the catalogue, robots of the plane before those of space."""
    if as_json:
        print(json.dumps({name: dataclasses.asdict(entry) for name, entry in CATALOGUE.items()}))
        return 0
    width = max(map(len, CATALOGUE))
    for geometry in ("plane", "space"):
        print(f"{geometry}:")
        for entry in CATALOGUE.values():
            if entry.geometry == geometry:
                motors = f"{len(entry.motors)} {entry.motors[0]} motors"
                print(f"  {entry.name:{width}}  {entry.title}")
                print(f"  {'':{width}}  {motors}, {entry.platform} platform; {entry.source}")
    return 0


def schema() -> int:
    """Prints the JSON Schema of robot files."""
    print(schema_text(), end="")
    return 0


def validate(files: Sequence[str], as_json: bool) -> list[str]:
    """Prints what each robot file describes and its warnings; returns the mistakes."""
    answers: list[dict] = []
    mistakes = []
    for file in files:
        try:
            robot = read_specification(file)
        except InputError as error:
            mistakes.append(str(error))
            answers.append({"file": file, "ok": False, "error": str(error)})
            continue
        answers.append({"file": file, "ok": True, **_described(robot)})
        if not as_json:
            _print_robot(file, robot)
    if as_json:
        print(json.dumps(answers))
    return mistakes


def _described(robot: RobotSpecification) -> dict:
    return {
        "name": robot.name,
        "geometry": robot.geometry,
        "legs": len(robot.legs),
        "motors": len(robot.motors),
        "platform": robot.platform.kind,
        "warnings": list(robot.warnings),
    }


def _print_robot(file: str, robot: RobotSpecification) -> None:
    kind = "planar" if robot.geometry == "plane" else "spatial"
    legs, motors = (
        f"{count} {noun}{'' if count == 1 else 's'}"
        for count, noun in ((len(robot.legs), "leg"), (len(robot.motors), "motor"))
    )
    print(f"{file}: ok, {kind}, {legs}, {motors}, {robot.platform.kind} platform")
    for warning in robot.warnings:
        print(f"{file}: warning: {warning}")
