"""From a label to the number of a robot that it names."""

import re
from operator import attrgetter

import jax
import numpy as np

from ..robots.labels import path_of, segment_missing
from ..robots.robot import Robot
from .entries import LENGTH, BendingStiffness, Common, Entry, SegmentLength

_COMPLIANCE = "legs.rod.curvature_compliance"

# Name: (path, index behind the leg's, reciprocal, unit). `i` is a leg, `axis` a world axis.
_LEG = {
    "k_b": (_COMPLIANCE, (-1,), True, "N m^2"),
    "r_c": ("legs.rod.precurvature", (-1,), True, "m"),
    "kappa": ("legs.rod.precurvature", (-1,), False, "1/m"),
    "l": (LENGTH, (), False, "m"),
    "a": ("legs.a", (0,), False, "m"),
    "b": ("legs.b", (0,), False, "m"),
}
_AXIS = {
    "base": ("legs.base_position", "m"),
    "f": ("legs.rod.force", "N/m"),
}
_LEG_LABEL = re.compile(r"(k_b|k_t|k_2|k_3|r_c|kappa|l|a|b)(\d*)(?:_(\d+))?")
_AXIS_LABEL = re.compile(r"(base|f)(\d+)(?:_(\d+))?_([xyz])")
_LOAD_LABEL = re.compile(r"(f_P|m_P)_([xyz])")


def named(robot: Robot, label: str, field: str) -> Entry | None:
    axes = robot.geometry.axes
    about = enumerate(robot.geometry.stiffnesses)
    of_legs = _LEG | {name: (_COMPLIANCE, (k,), True, "N m^2") for k, name in about}
    if label in of_legs:
        path, rest, reciprocal, unit = of_legs[label]
        ends = (1, 2) if label == "k_b" and len(robot.geometry.stiffnesses) == 3 else rest
        # Counted from the front, as where one number is named from two sides.
        size = attrgetter(path)(robot).shape[-1]
        return Common(label, path, tuple(k % size for k in ends), reciprocal, unit)
    if (match := _LEG_LABEL.fullmatch(label)) and match[2] and match[1] in of_legs:
        path, rest, reciprocal, unit = of_legs[match[1]]
        kind = SegmentLength if path == LENGTH and match[3] else Entry
        if match[1] == "k_b" and len(robot.geometry.stiffnesses) == 3:
            kind = BendingStiffness
        path, index = _place(robot, label, path, _index(match[2]), match[3], field)
        return kind(label, path, (*index, *rest), reciprocal, unit)
    if (match := _AXIS_LABEL.fullmatch(label)) and match[4] in axes:
        path, unit = _AXIS[match[1]]
        path, index = _place(robot, label, path, _index(match[2]), match[3], field)
        return Entry(label, path, (*index, axes.index(match[4])), False, unit)
    if match := _LOAD_LABEL.fullmatch(label):
        force = match[1] == "f_P"
        among = axes if force else robot.geometry.rotation_axes
        if match[2] in among:
            unit = "N" if force else "N m"
            return Entry(label, match[1], (among.index(match[2]),), False, unit)
    return None


def segment_count(robot: Robot, leg: int) -> int | None:
    """How many segments the rod of leg `leg`, counted from 0, has; `None` while it is traced."""
    further = robot.legs.rod.further
    if further is None:
        return 1
    if isinstance(further.length, jax.core.Tracer):
        return None
    return 1 + int(np.count_nonzero(np.asarray(further.length)[leg]))


def _place(robot: Robot, label: str, path: str, leg: int, segment: str | None, field: str):
    """Where a number of a leg, or of a segment of its rod, is: path and first indices."""
    if not path.startswith("legs.rod.") or leg >= robot.n:
        return path, (_NOWHERE if segment else leg,)
    count = segment_count(robot, leg)
    if segment is None and count is not None and count > 1:
        raise segment_missing(label, leg + 1, count, field)
    if segment is None:
        return path, (leg,)
    # A uniform rod has no segments that one could name.
    k = _index(segment)
    if count is not None and (count == 1 or k >= count):
        k = _NOWHERE
    if k == 0:
        return path, (leg,)
    return path.replace("rod.", "rod.further."), (leg, k - 1)


_NOWHERE = 10**6
"""Legs and segments with the number 0 do not exist; an index out of range says so."""


def _index(number: str) -> int:
    return int(number) - 1 if int(number) > 0 else _NOWHERE


def by_path(label: str) -> Entry | None:
    place = path_of(label)
    return None if place is None else Entry(label, *place, False, "SI")
