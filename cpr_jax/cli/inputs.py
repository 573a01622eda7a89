"""What the user asked for, checked; no module of numbers is imported here."""

import argparse
import dataclasses
import os
from collections.abc import Sequence

from ..errors import InputError
from ..robots.labels import parameter_dimension
from ..robots.names import CATALOGUE, CatalogueEntry
from ..robots.reading import read_specification
from ..robots.specification import RobotSpecification
from ..robots.units import Dimension, Sign, parse_quantity
from .coordinates import Coordinates, coordinates_of


@dataclasses.dataclass(frozen=True)
class Request:
    """A checked command: SI numbers, and a robot that exists.

    **Attributes:**

    - `robot`: an entry of the catalogue, or what a robot file says.
    - `point`, `motors`: one of them, SI units.
    - `imposed`: names of the coordinates of `point`, or `None` for all of the platform's.
    - `parameters`, `delta`: labels and half ranges, or `None`.
    - `steps`: integration steps along each rod, or `None`.
    """

    robot: CatalogueEntry | RobotSpecification
    point: tuple[float, ...] | None
    motors: tuple[float, ...] | None
    imposed: tuple[str, ...] | None
    parameters: tuple[str, ...] | None
    delta: dict[str, float] | None
    steps: int | None


def check(arguments: argparse.Namespace) -> Request:
    """Checks the arguments that name a robot, a configuration and parameters."""
    robot = _robot(arguments.robot)
    coordinates = coordinates_of(robot)
    geometry, segments = coordinates.geometry, coordinates.segments
    imposed = _imposed(arguments, coordinates)
    names = getattr(arguments, "parameters", None)
    for label in names or ():
        if "[" not in label:
            parameter_dimension(label, geometry, segments, "--parameters")
    if getattr(arguments, "hold", None) == "platform" and not coordinates.square:
        raise InputError(
            f"Argument `--hold` must be motors, since {len(coordinates.motors)} motors cannot "
            f"hold {len(coordinates.platform)} platform coordinates, but it is platform."
        )
    point = coordinates.dimensions(imposed or tuple(coordinates.platform))
    motors = list(coordinates.motors.values())
    return Request(
        robot=robot,
        point=_numbers_of(arguments, "point", point),
        motors=_numbers_of(arguments, "motors", motors),
        imposed=imposed,
        parameters=None if names is None else tuple(names),
        delta=_half_ranges(getattr(arguments, "delta", None), geometry, segments),
        steps=None if arguments.steps is None else positive_integer("--steps", arguments.steps),
    )


def _imposed(arguments: argparse.Namespace, coordinates: Coordinates) -> tuple[str, ...] | None:
    """What the motors impose: everywhere on a map or a path, otherwise with `--point` only."""
    if arguments.command in ("workspace", "trajectory") or arguments.point is not None:
        return coordinates.imposed(arguments.imposed)
    if arguments.imposed is not None:
        raise InputError("Argument `--imposed` must come with `--point`, but there is none.")
    return None


def _numbers_of(
    arguments: argparse.Namespace, name: str, dimensions: list[Dimension]
) -> tuple[float, ...] | None:
    """Those of an option that a command has and that is given."""
    texts = getattr(arguments, name, None)
    return None if texts is None else numbers(f"--{name}", texts, dimensions)


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


def figure_file(name: str, text: str) -> str:
    """The name of a file for a figure."""
    if not text.endswith((".png", ".pdf")):
        raise InputError(f"Argument `{name}` must be FILE.png or FILE.pdf, but it is {text!r}.")
    return text


def _robot(name: str) -> CatalogueEntry | RobotSpecification:
    if name in CATALOGUE:
        return CATALOGUE[name]
    if name.endswith(".toml") or os.sep in name or os.path.exists(name):
        return read_specification(name)
    raise InputError(
        f"Argument `ROBOT` must be one of {', '.join(CATALOGUE)}, or the path of a robot file, "
        f"but it is {name!r}."
    )


def numbers(
    name: str, texts: list[str], dimensions: list[Dimension], sign: Sign = Sign.ANY
) -> tuple[float, ...]:
    """As many quantities as there are dimensions, in SI units."""
    if len(texts) != len(dimensions):
        nouns = ", ".join(dimension.noun for dimension in dimensions)
        count = "1 number" if len(dimensions) == 1 else f"{len(dimensions)} numbers"
        raise InputError(
            f"Argument `{name}` must be {count} ({nouns}), but there are {len(texts)}."
        )
    return tuple(
        quantity(name, text, dimension, sign)
        for text, dimension in zip(texts, dimensions, strict=True)
    )


def quantity(name: str, text: str, dimension: Dimension, sign: Sign = Sign.ANY) -> float:
    """A quantity in SI units; a bare number is in them already."""
    try:
        value: float | str = float(text)
    except ValueError:
        value = text.strip()
    return parse_quantity(value, dimension, name, sign)


def _half_ranges(
    texts: list[str] | None, geometry: str, segments: Sequence[int]
) -> dict[str, float] | None:
    if texts is None:
        return None
    delta = {}
    for text in texts:
        label, equals, value = text.strip().partition("=")
        if not equals:
            raise InputError(
                f"Argument `--delta` must be LABEL=VALUE such as k_b1=4.73e-3, but it is {text!r}."
            )
        if label in delta:
            raise InputError(
                f"Argument `--delta` must give one half range for each parameter, but {label!r} "
                "has two."
            )
        field = f"--delta {label}"
        if "[" in label:
            dimension = Dimension("number", ("1",), "0.1")
        else:
            dimension = parameter_dimension(label, geometry, segments, "--delta")
        delta[label] = quantity(field, value, dimension, Sign.POSITIVE)
    return delta
