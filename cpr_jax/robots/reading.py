"""Robot files and their mappings, read and checked; the format is in docs/robot-files.md."""

import os
import tomllib
from collections.abc import Iterator, Mapping

from ..errors import InputError, shown
from .labels import AXES, ROTATION_AXES, parameter_dimension
from .reading_legs import Frame, read_leg
from .specification import (
    HomeSpecification,
    LegSpecification,
    RobotSpecification,
    RodSpecification,
)
from .tables import Table
from .units import ACCELERATION, ANGLE, FORCE, LENGTH, MOMENT, Sign

FORMAT = 1
"""The version of the format that this release reads."""

_LARGEST = 10_000_000
_SOFTEST, _STIFFEST = 1e4, 1e12


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
    geometry = file.entry("geometry").choice("plane", "space")
    frame = Frame(geometry, AXES[geometry], ROTATION_AXES[geometry])
    platform = file.table("platform", "platform")
    kind = platform.entry("kind").choice("point", "body")
    if kind == "point":
        platform.refuse("moment", "a point has no moment balance")
    force = platform.entry("force", frame.zeros).vector(FORCE, frame.axes)
    moment = frame.rotational(platform.entry("moment", frame.no_turn), MOMENT)

    defaults = None
    if file.has("defaults"):
        defaults = file.table("defaults", "defaults").table("leg", "legs")
    legs = tuple(
        read_leg(frame, kind, Table(entry.value, entry.field, "legs", defaults))
        for entry in file.entry("legs").items()
    )
    home = None
    if file.has("home"):
        home = _home(frame, kind, legs, file.table("home", "home"))
    gravity = None
    if file.has("environment"):
        entry = file.table("environment", "environment").entry("gravity")
        gravity = entry.vector(ACCELERATION, frame.axes)
    uncertainty = {}
    if file.has("uncertainty"):
        table = file.entry("uncertainty").table(None)
        for label in table.keys():  # noqa: SIM118, a method of Table
            entry = table.entry(label)
            dimension = parameter_dimension(label, geometry, len(legs), entry.field)
            uncertainty[label] = entry.quantity(dimension, Sign.POSITIVE)
    return RobotSpecification(
        name=name,
        geometry=geometry,
        platform=kind,
        force=force,
        moment=moment,
        legs=legs,
        home=home,
        gravity=gravity,
        uncertainty=uncertainty,
        warnings=tuple(_warnings(legs, gravity)),
    )


def _home(
    frame: Frame, platform: str, legs: tuple[LegSpecification, ...], home: Table
) -> HomeSpecification:
    motors = home.entry("motors")
    if not motors.is_list or len(motors.items()) != len(legs):
        raise motors.error(f"a list with one entry for each of the {len(legs)} legs")
    if platform == "point":
        home.refuse("rotation", "a point has no rotation")
    return HomeSpecification(
        motors=tuple(
            entry.quantity(ANGLE if leg.motor == "revolute" else LENGTH)
            for entry, leg in zip(motors.items(), legs, strict=True)
        ),
        position=home.entry("position").vector(LENGTH, frame.axes),
        rotation=()
        if platform == "point"
        else frame.rotational(home.entry("rotation", frame.no_turn), ANGLE),
    )


def _warnings(
    legs: tuple[LegSpecification, ...], gravity: tuple[float, ...] | None
) -> Iterator[str]:
    """What is allowed and yet looks like a mistake; once for legs with the same rod."""
    rods: dict[RodSpecification, str] = {}
    for i, leg in enumerate(legs):
        rods.setdefault(leg.rod, f"legs[{i}].rod")
    for rod, field in rods.items():
        key, moduli = _implied_moduli(rod)
        for E in moduli:
            if not _SOFTEST <= E <= _STIFFEST:
                yield (
                    f"Argument `{field}.{key}` implies E = {_pascals(E)}, but materials of rods "
                    f"have between {_pascals(_SOFTEST)} and {_pascals(_STIFFEST)}: check its unit."
                )
            elif rod.material and rod.material.E and not 0.5 <= E / rod.material.E <= 2.0:
                yield (
                    f"Argument `{field}.{key}` implies E = {_pascals(E)} for this section, "
                    f"but `{field}.material.E` is {_pascals(rod.material.E)}."
                )
        if gravity is not None and rod.mass_per_length is None:
            yield (
                f"Argument `environment.gravity` does not act on `{field}`, "
                f"which lacks a section or a material with a density."
            )


def _implied_moduli(rod: RodSpecification) -> tuple[str, list[float]]:
    """The key that says how stiff a rod is, and Young's moduli that follow for its section."""
    if rod.section is None:
        return "", []
    if rod.bending_stiffness is not None:
        key, stiffness = "bending_stiffness", rod.bending_stiffness
    elif rod.curvature_compliance is not None:
        key, stiffness = "curvature_compliance", tuple(1.0 / c for c in rod.curvature_compliance)
    else:
        return "material.E", [rod.material.E] if rod.material and rod.material.E else []
    # From the last axis, about which a planar rod bends, as far as both go; torsion implies none.
    moments = rod.section.second_moments
    pairs = zip(reversed(stiffness), reversed(moments), strict=False)
    return key, list(dict.fromkeys(k / moment for k, moment in pairs))


def _pascals(modulus: float) -> str:
    for prefix, scale in (("T", 1e12), ("G", 1e9), ("M", 1e6), ("k", 1e3)):
        if modulus >= scale:
            return f"{modulus / scale:.3g} {prefix}Pa"
    return f"{modulus:.3g} Pa"
