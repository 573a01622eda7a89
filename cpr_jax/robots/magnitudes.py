"""Sizes in a robot file that do not fit each other: mostly a unit that was left out."""

import math
from collections.abc import Iterator

from .specification import HomeSpecification, LegSpecification, RobotSpecification

_SHORTEST, _LONGEST = 1e-3, 10.0
"""Lengths of rods, m."""

_STOUT = 0.2
"""Width of a rod by its length from which it is no rod."""

_FAR = 20.0
"""Rod lengths from which something else is hardly meant."""

_STRETCH = 1.01
"""How much longer than by its lengths a leg may be: rods stretch."""

_TURN = 2.0 * math.pi * (1.0 + 1e-9)
"""A rotation that is larger is hardly meant, nor is a motor that far from zero."""

_METRES = "a number without a unit is in metres"


def magnitudes(robot: RobotSpecification) -> Iterator[str]:
    """One sentence for each size that looks like a mistake."""
    rods = [
        (f"legs[{i}].rod" + (f".segments[{j}]" if leg.further else ""), rod)
        for i, leg in enumerate(robot.legs)
        for j, rod in enumerate(leg.segments)
    ]
    for field, rod in rods:
        if not _SHORTEST <= rod.length <= _LONGEST:
            yield f"Argument `{field}.length` is {rod.length:g} m: {_METRES}."
            return
    for field, rod in rods:
        if rod.section is not None and max(rod.section.sizes) > _STOUT * rod.length:
            yield (
                f"Argument `{field}.section` is up to {max(rod.section.sizes):g} m across, "
                f"but the rod is {rod.length:g} m long: {_METRES}."
            )
            return
    longest = max(sum(rod.length for rod in leg.segments) for leg in robot.legs)
    for i, leg in enumerate(robot.legs):
        for field, size in _sizes(leg, robot.legs[0]).items():
            if size > _FAR * longest:
                yield (
                    f"Argument `legs[{i}].{field}` is {size:g} m long or far away, but rods are "
                    f"{longest:g} m long: {_METRES}."
                )
                return
    for i, leg in enumerate(robot.legs):
        yield from _of_rotation(f"legs[{i}].base_rotation", leg.base_rotation)
        yield from _of_rotation(f"legs[{i}].attachment_rotation", leg.attachment_rotation)
        if leg.base_joint is not None:
            yield from _of_rotation(f"legs[{i}].base_joint.rotation", leg.base_joint.rotation)
    if robot.home is not None:
        yield from _of_home(robot, robot.home, longest)
    yield from _of_ranges(robot)


def _sizes(leg: LegSpecification, first: LegSpecification) -> dict[str, float]:
    """Distances from the first leg's motor and lengths, m, by their field."""
    apart = math.dist(leg.base, first.base)
    lengths = {"a": leg.a, "b": leg.b, "attachment": leg.attachment}
    return {"base": apart} | {name: math.hypot(*vector) for name, vector in lengths.items()}


def _of_home(robot: RobotSpecification, home: HomeSpecification, longest: float) -> Iterator[str]:
    away = math.dist(home.position, robot.legs[0].base)
    if away > _FAR * longest:
        yield (
            f"Argument `home.position` is {away:g} m from the first motor, but rods are "
            f"{longest:g} m long: {_METRES}."
        )
        return
    yield from _out_of_reach(robot, home)
    for j, (q, turns) in enumerate(zip(home.motors, robot.turning, strict=True)):
        if turns and abs(q) > _TURN:
            yield _in_radians(f"home.motors[{j}]", q)
    yield from _of_rotation("home.rotation", home.rotation)


def _of_rotation(field: str, rotation: tuple[float, ...]) -> Iterator[str]:
    angle = math.hypot(*rotation)
    if angle > _TURN:
        yield _in_radians(field, angle)


def _in_radians(field: str, angle: float) -> str:
    return (
        f"Argument `{field}` is {angle:g} rad, more than a turn: a number without a unit is in "
        "radians."
    )


def _out_of_reach(robot: RobotSpecification, home: HomeSpecification) -> Iterator[str]:
    """A home that a leg would not reach if it were stretched out straight."""
    for i, leg in enumerate(robot.legs):
        if leg.motor.kind not in ("revolute", "none") or leg.base_joint is not None:
            continue
        away = math.dist(home.position, leg.base)
        rigid = sum(math.hypot(*part) for part in (leg.a, leg.b, leg.attachment))
        reach = rigid + sum(rod.length for rod in leg.segments)
        if away > _STRETCH * reach:
            yield (
                f"Argument `home.position` is {away:g} m from the motor of `legs[{i}]`, which "
                f"reaches {reach:g} m when it is straight."
            )
            return


def _of_ranges(robot: RobotSpecification) -> Iterator[str]:
    """Half ranges that are larger than what they are a range of."""
    for i, leg in enumerate(robot.legs, 1):
        rod = leg.rod
        known = {f"l{i}": rod.length if not leg.further else None}
        known[f"a{i}"], known[f"b{i}"] = math.hypot(*leg.a), math.hypot(*leg.b)
        known[f"k_b{i}"] = rod.stiffness if not leg.further else None
        if i == 1:
            known |= {name[:-1]: value for name, value in known.items()}
        for label, value in known.items():
            half_range = robot.uncertainty.get(label, 0.0)
            if value and half_range > value:
                yield (
                    f"Argument `uncertainty.{label}` is {half_range:g} in SI units, more than the "
                    f"parameter itself, {value:g}: check its unit."
                )
