"""Which motor of a robot file moves which legs."""

from ..errors import InputError
from .specification import LegSpecification
from .tables import Entry, Table


def read_motors(file: Table, legs: tuple[LegSpecification, ...]) -> tuple[tuple[int, ...], ...]:
    """The legs that each motor moves, counted from 0; usually one each."""
    driven = [i for i, leg in enumerate(legs) if leg.motor.kind != "none"]
    if not file.has("motors"):
        if not driven:
            raise InputError("Argument `legs` must have at least one motor, but they have none.")
        return tuple((i,) for i in driven)
    motors = tuple(_moved(entry, legs) for entry in file.entry("motors").items())
    for i in driven:
        if not any(i in motor for motor in motors):
            raise InputError(
                f"Argument `motors` must name each leg that has a motor, but leg {i + 1} is in "
                f"none of its lists."
            )
    return motors


def _moved(motor: Entry, legs: tuple[LegSpecification, ...]) -> tuple[int, ...]:
    """The legs of one motor, which the file counts from 1 as labels do."""
    moved: list[int] = []
    for entry in motor.items():
        number = entry.value
        if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= len(legs):
            raise entry.error(f"the number of a leg, from 1 to {len(legs)}")
        leg = number - 1
        if leg in moved:
            raise entry.error("the number of another leg than those before it")
        kind = legs[leg].motor.kind
        if kind == "none":
            raise entry.error(f"a leg that moves, unlike one whose `motor` is {kind!r}")
        if moved and legs[leg].motor.turns != legs[moved[0]].motor.turns:
            raise entry.error(
                "a leg of the same kind as those before it, since a motor cannot both turn and "
                "slide legs"
            )
        moved.append(leg)
    return tuple(moved)
