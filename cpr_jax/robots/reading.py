"""Robot files and their mappings, read and checked; the format is in docs/robot-files.md."""

import dataclasses
import itertools
import os
import tomllib
from collections.abc import Mapping

from ..errors import InputError, shown
from .frame import Frame
from .labels import AXES, ROTATION_AXES, is_part_of, parameter_dimension
from .magnitudes import magnitudes
from .missing import missing
from .reading_legs import read_leg
from .reading_motors import read_motors
from .reading_platform import read_platform
from .specification import HomeSpecification, RobotSpecification
from .suspicions import suspicions
from .tables import CHOICES, Table
from .units import ACCELERATION, ANGLE, LENGTH, Sign

FORMAT = 1
"""The version of the format that this release reads."""

_LARGEST = 10_000_000


def read_specification(path: str | os.PathLike[str]) -> RobotSpecification:
    """Reads a robot file.

    **Raises:**

    - `InputError`: if the file cannot be read or does not describe a robot.
    """
    name = os.fsdecode(path)
    try:
        with open(name, "rb") as file:
            content = file.read(_LARGEST + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise _unreadable(name, f"cannot be opened: {reason}") from error
    if len(content) > _LARGEST:
        raise _unreadable(name, f"is longer than {_LARGEST} bytes")
    try:
        # Some editors start a file with a byte order mark.
        mapping = tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise _unreadable(name, f"is not UTF-8 at byte {error.start}") from error
    except (ValueError, RecursionError) as error:
        raise _unreadable(name, f"is not TOML: {' '.join(str(error).split())}") from error
    return parse_specification(mapping, name)


def _unreadable(name: str, reason: str) -> InputError:
    return InputError(f"Argument `path` must be a robot file in TOML, but {shown(name)} {reason}.")


def parse_specification(mapping: Mapping[str, object], source: str = "") -> RobotSpecification:
    """Checks a robot given as nested mappings and lists, and converts it to SI units.

    **Arguments:**

    - `mapping`: what TOML (or JSON) makes of a robot file.
    - `source`: where it comes from; starts the message of an error.

    **Raises:**

    - `InputError`: with the first mistake found.
    """
    try:
        _check_format(mapping)
        return _robot(Table(mapping, "", "file"))
    except InputError as error:
        if not source:
            raise
        place = source if source.isprintable() else shown(source)
        raise InputError(f"{place}: {error}") from None


def _check_format(mapping: object) -> None:
    # Before the keys: a newer format may have others, which are no typing errors.
    entry = Table(mapping, "", None).entry("format")
    if isinstance(entry.value, bool) or not isinstance(entry.value, int) or entry.value != FORMAT:
        raise entry.error(f"{FORMAT}, the version of the format that this release reads")


def _robot(file: Table) -> RobotSpecification:
    name = file.entry("name", "robot").line()
    geometry = file.entry("geometry").choice(*CHOICES["geometry"])
    frame = Frame(geometry, AXES[geometry], ROTATION_AXES[geometry])
    weighs = file.has("environment")
    platform = read_platform(frame, file.table("platform", "platform"), weighs)

    defaults = None
    if file.has("defaults"):
        defaults = file.table("defaults", "defaults").table("leg", "legs")
    legs = tuple(
        read_leg(frame, platform.kind, Table(entry.value, entry.field, "legs", defaults))
        for entry in file.entry("legs").items()
    )
    gravity = None
    if weighs:
        entry = file.table("environment", "environment").entry("gravity")
        gravity = entry.vector(ACCELERATION, frame.axes)
    uncertainty = {}
    if file.has("uncertainty"):
        table = file.entry("uncertainty").table(None)
        for label in table.keys():  # noqa: SIM118, a method of Table
            entry = table.entry(label)
            segments = [len(leg.segments) for leg in legs]
            dimension = parameter_dimension(label, geometry, segments, entry.field)
            uncertainty[label] = entry.quantity(dimension, Sign.POSITIVE)
            if reason := missing(label, platform.kind, legs, gravity):
                raise InputError(
                    f"Argument `{entry.field}` must vary a number that the robot has, but {reason}."
                )
        for one, other in itertools.permutations(uncertainty, 2):
            if is_part_of(other, one):
                raise table.entry(other).error(
                    f"left out beside `{one}`, which stands for all legs"
                )
    robot = RobotSpecification(
        name=name,
        geometry=geometry,
        platform=platform,
        legs=legs,
        motors=read_motors(file, legs),
        home=None,
        gravity=gravity,
        uncertainty=uncertainty,
        warnings=tuple(suspicions(legs, gravity)),
    )
    if file.has("home"):
        robot = dataclasses.replace(robot, home=_home(frame, robot, file.table("home", "home")))
    return dataclasses.replace(robot, warnings=(*robot.warnings, *magnitudes(robot)))


def _home(frame: Frame, robot: RobotSpecification, home: Table) -> HomeSpecification:
    motors, turning = home.entry("motors"), robot.turning
    if not motors.is_list or len(motors.items()) != len(turning):
        raise motors.error(f"a list with one entry for each of the {len(turning)} motors")
    oriented = robot.platform.kind == "body"
    if not oriented:
        home.refuse("rotation", "a point has no rotation")
    return HomeSpecification(
        motors=tuple(
            entry.quantity(ANGLE if turns else LENGTH)
            for entry, turns in zip(motors.items(), turning, strict=True)
        ),
        position=home.entry("position").vector(LENGTH, frame.axes),
        rotation=frame.rotation(home.entry("rotation", frame.no_turn)) if oriented else (),
    )
