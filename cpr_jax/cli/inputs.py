"""What the user asked for, checked; no module of numbers is imported here."""

import argparse
import dataclasses
import os

from ..errors import InputError
from ..robots.labels import AXES, ROTATION_AXES, parameter_dimension
from ..robots.names import CATALOGUE, CatalogueEntry
from ..robots.reading import read_specification
from ..robots.specification import RobotSpecification
from ..robots.units import ANGLE, LENGTH, MOMENT, Dimension, Sign, parse_quantity


@dataclasses.dataclass(frozen=True)
class Request:
    """A checked command: SI numbers, and a robot that exists.

    **Attributes:**

    - `robot`: an entry of the catalogue, or what a robot file says.
    - `point`, `motors`: one of them, SI units.
    - `parameters`, `delta`: labels and half ranges, or `None`.
    """

    robot: CatalogueEntry | RobotSpecification
    point: tuple[float, ...] | None
    motors: tuple[float, ...] | None
    parameters: tuple[str, ...] | None
    delta: dict[str, float] | None


def check(arguments: argparse.Namespace) -> Request:
    """Checks the arguments that name a robot, a configuration and parameters."""
    robot = _robot(arguments.robot)
    geometry, platform, motors = _freedoms(robot)
    legs = len(robot.legs) if isinstance(robot, RobotSpecification) else len(motors)
    coordinates = [LENGTH] * len(AXES[geometry])
    if platform == "body":
        coordinates += [ANGLE] * len(ROTATION_AXES[geometry])
    names = getattr(arguments, "parameters", None)
    for label in names or ():
        if "[" not in label:
            parameter_dimension(label, geometry, legs, "--parameters")
    return Request(
        robot=robot,
        point=_numbers("--point", arguments.point, coordinates),
        motors=_numbers("--motors", arguments.motors, motors),
        parameters=None if names is None else tuple(names),
        delta=_half_ranges(getattr(arguments, "delta", None), geometry, legs),
    )


@dataclasses.dataclass(frozen=True)
class MapRequest:
    """The options of a workspace map, SI units."""

    out: str
    spacing: float | None
    refine: int
    box: tuple[tuple[float, float], tuple[float, float]] | None
    max_torque: float | None
    max_moment: float | None
    resume: bool


def check_map(arguments: argparse.Namespace) -> MapRequest:
    """Checks the arguments of a workspace map."""

    def quantity(name: str, text: str | None, dimension: Dimension) -> float | None:
        if text is None:
            return None
        return parse_quantity(_number_or_text(text), dimension, name, Sign.POSITIVE)

    box = None
    if arguments.box is not None:
        a, b, c, d = (
            parse_quantity(_number_or_text(text), LENGTH, "--box") for text in arguments.box
        )
        box = ((a, b), (c, d))
    return MapRequest(
        out=arguments.out,
        spacing=quantity("--spacing", arguments.spacing, LENGTH),
        box=box,
        refine=positive_integer("--refine", arguments.refine, least=0),
        max_torque=quantity("--max-torque", arguments.max_torque, MOMENT),
        max_moment=quantity("--max-moment", arguments.max_moment, MOMENT),
        resume=arguments.resume,
    )


def positive_integer(name: str, text: str, least: int = 1) -> int:
    """An integer of at least `least`; `1e6` is one."""
    try:
        number = float(text)
        if number != int(number) or number < least or number > 1e12:
            raise ValueError
    except (ValueError, OverflowError):
        raise InputError(
            f"Argument `{name}` must be an integer from {least} on, but it is {text.strip()!r}."
        ) from None
    return int(number)


def _robot(name: str) -> CatalogueEntry | RobotSpecification:
    if name in CATALOGUE:
        return CATALOGUE[name]
    if name.endswith(".toml") or os.sep in name or os.path.exists(name):
        return read_specification(name)
    raise InputError(
        f"Argument `ROBOT` must be one of {', '.join(CATALOGUE)}, or the path of a robot file, "
        f"but it is {name!r}."
    )


def _freedoms(robot: CatalogueEntry | RobotSpecification) -> tuple[str, str, list[Dimension]]:
    if isinstance(robot, CatalogueEntry):
        return "plane", robot.platform, [ANGLE] * robot.motors
    motors = [ANGLE if turns else LENGTH for turns in robot.turning]
    return robot.geometry, robot.platform.kind, motors


def _numbers(
    name: str, texts: list[str] | None, dimensions: list[Dimension]
) -> tuple[float, ...] | None:
    if texts is None:
        return None
    if len(texts) != len(dimensions):
        nouns = ", ".join(dimension.noun for dimension in dimensions)
        raise InputError(
            f"Argument `{name}` must be {len(dimensions)} numbers ({nouns}), but there are "
            f"{len(texts)}."
        )
    return tuple(
        parse_quantity(_number_or_text(text), dimension, name)
        for text, dimension in zip(texts, dimensions, strict=True)
    )


def _half_ranges(texts: list[str] | None, geometry: str, legs: int) -> dict[str, float] | None:
    if texts is None:
        return None
    delta = {}
    for text in texts:
        label, equals, value = text.strip().partition("=")
        if not equals:
            raise InputError(
                f"Argument `--delta` must be LABEL=VALUE such as k_b1=4.73e-3, but it is {text!r}."
            )
        field = f"--delta {label}"
        if "[" in label:
            dimension = Dimension("number", ("1",), "0.1")
        else:
            dimension = parameter_dimension(label, geometry, legs, "--delta")
        delta[label] = parse_quantity(_number_or_text(value), dimension, field, Sign.POSITIVE)
    return delta


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text.strip()
