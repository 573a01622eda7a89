"""The text of a robot file, in SI units, from a robot."""

import dataclasses
import functools
import json
import math
import operator
from collections.abc import Iterator, Sequence
from typing import SupportsFloat, TypeAlias

import jax
import numpy as np
from jaxtyping import Array

from ..geometry import AbstractGeometry
from ..rods.rod import Rod
from ..rods.segments import segments_of
from .joint import BaseJoint, clamped, pivot, slider, spherical, swivel, universal
from .leg import Leg, prismatic_screw, revolute_screw
from .reading import FORMAT
from .robot import Robot

JOINTS = {
    "pivot": pivot,
    "universal": universal,
    "spherical": spherical,
    "clamped": clamped,
    "swivel": swivel,
    "slider": slider,
}
"""The joints that have a name in robot files."""

_Values: TypeAlias = Sequence[float] | np.ndarray | Array


def robot_text(robot: Robot) -> str:
    """The robot file of a robot; what such a file cannot express is left out or misstated.

    **Raises:**

    - `ValueError`: if the robot is a batch or its motors move legs by different shares.
    """
    if robot.transmission.ndim != 2:
        raise inexpressible("it is a batch of robots")
    if not np.all(np.isin(robot.transmission, (0.0, 1.0))):
        raise inexpressible("its transmission has other entries than 0 and 1")
    return "\n".join(_lines(robot)) + "\n"


def inexpressible(reason: str) -> ValueError:
    """The error that a robot file cannot express a robot."""
    return ValueError(f"Argument `robot` must be one that a robot file can express, but {reason}.")


def _lines(robot: Robot) -> Iterator[str]:
    geometry = robot.geometry
    yield "# A robot of cpr_jax in SI units: m, rad, N, N*m, N*m^2."
    yield f"format = {FORMAT}"
    yield f"name = {json.dumps(robot.name, ensure_ascii=False)}"
    yield f'geometry = "{geometry.name}"'
    yield from _motors(robot)
    yield from ("", "[platform]", f'kind = "{"body" if robot.oriented else "point"}"')
    yield f"force = {_vector(robot.f_P)}"
    if robot.oriented:
        yield f"moment = {_rotational(robot.m_P)}"
    if robot.loads is not None:
        for place, force in zip(robot.loads.position, robot.loads.force, strict=True):
            yield from ("", "[[platform.loads]]", f"position = {_vector(place)}")
            yield f"force = {_vector(force)}"
    if robot.home is not None:
        position, rotation = np.split(robot.home.q_p, [geometry.d])
        yield from ("", "[home]", f"motors = {_vector(robot.home.q_a)}")
        yield f"position = {_vector(position)}"
        if robot.oriented:
            yield f"rotation = {_rotational(rotation)}"
    for i in range(robot.n):
        yield from ("", "[[legs]]", *_leg(geometry, robot.leg(i), robot.oriented))
    if robot.uncertainty:
        yield from ("", "[uncertainty]")
        for label, half_range in robot.uncertainty.items():
            bare = label.isascii() and label.isidentifier()
            yield f"{label if bare else json.dumps(label)} = {_number(half_range)}"


def _motors(robot: Robot) -> Iterator[str]:
    """Which legs each motor moves, unless there is one motor for each leg that moves."""
    usual = [i for i in range(robot.n) if _motor(robot.geometry, robot.leg(i)) != '"none"']
    if not np.array_equal(robot.transmission, np.eye(robot.n)[:, usual]):
        moved = (np.flatnonzero(column) + 1 for column in np.asarray(robot.transmission).T)
        yield f"motors = [{', '.join(str(legs.tolist()) for legs in moved)}]"


def _leg(geometry: AbstractGeometry, leg: Leg, oriented: bool) -> Iterator[str]:
    yield f"base = {_vector(leg.base_position)}"
    if np.any(leg.base_rotation):
        yield f"base_rotation = {_rotational(leg.base_rotation)}"
    yield f"motor = {_motor(geometry, leg)}"
    if leg.base_joint is not None:
        yield from _base_joint(geometry, leg.base_joint)
    yield f"a = {_segment(leg.a)}"
    yield f"b = {_segment(leg.b)}"
    yield f"joint = {_joint(geometry, leg.joint.free)}"
    if leg.joint.lever == 0.0:
        yield 'moment_row = "printed"'
    if oriented:
        yield f"attachment = {_vector(leg.attachment_position)}"
        if np.any(leg.attachment_rotation):
            yield f"attachment_rotation = {_rotational(leg.attachment_rotation)}"
    segments = _segments(leg.rod)
    if len(segments) == 1:
        yield from ("", "[legs.rod]", *_rod(leg.rod))
    else:
        for segment in segments:
            yield from ("", "[[legs.rod.segments]]", *_rod(segment))


def _motor(geometry: AbstractGeometry, leg: Leg) -> str:
    """The kind that comes nearest: what else a motor does is what a file cannot express."""
    slide, turn = np.split(np.asarray(leg.screw), [geometry.d])
    if np.any(turn):
        _, usual = np.split(np.asarray(revolute_screw(geometry)), [geometry.d])
        return _geared("revolute", *_gear(turn, usual))
    if np.any(slide):
        usual, _ = np.split(np.asarray(prismatic_screw(geometry)), [geometry.d])
        return _geared("prismatic", *_gear(slide, usual))
    for kind, motion in (("feed", leg.feed), ("telescopic", leg.stroke)):
        if motion is not None and np.any(motion):
            return _geared(kind, np.ravel(motion)[0])
    return '"none"'


def _geared(kind: str, ratio: float, axis: _Values | None = None) -> str:
    if ratio == 1.0 and axis is None:
        return f'"{kind}"'
    along = "" if axis is None else f", axis = {_vector(axis)}"
    geared = "" if ratio == 1.0 else f", ratio = {_number(ratio)}"
    return f'{{ kind = "{kind}"{along}{geared} }}'


def _gear(motion: np.ndarray, usual: np.ndarray) -> tuple[float, np.ndarray | None]:
    """A ratio and a direction whose product is a motion, to the last bit if that can be.

    The direction is `None` where it is the usual one.
    """
    length = ratio = float(np.linalg.norm(motion))
    if np.array_equal(motion, (motion @ usual) * usual):
        return motion @ usual, None
    if abs(length - 1.0) < 1e-12:
        return 1.0, motion
    # Not every number is a multiple of a given one; among neighbours of the length there soon is
    # one of which all components are. The reader takes the axis as it is if its length is near 1.
    for _ in range(1000):
        near = motion / ratio
        beside = np.stack([near, np.nextafter(near, -np.inf), np.nextafter(near, np.inf)])
        fits = ratio * beside == motion
        if np.all(np.any(fits, axis=0)):
            return ratio, beside[np.argmax(fits, axis=0), np.arange(len(motion))]
        ratio = math.nextafter(ratio, math.inf)
    return length, motion / length


def _base_joint(geometry: AbstractGeometry, joint: BaseJoint) -> Iterator[str]:
    """Nothing where it is locked and without extent, as it is in legs that have none."""
    name = _joint(geometry, joint.free)
    placed = np.any(joint.position) or np.any(joint.rotation)
    if not placed and np.any(joint.free):
        yield f"base_joint = {name}"
    elif placed:
        freedoms = f"joint = {name}" if name.startswith('"') else name.strip("{ }")
        place = f"position = {_vector(joint.position)}, rotation = {_rotational(joint.rotation)}"
        yield f"base_joint = {{ {freedoms}, {place} }}"


def _joint(geometry: AbstractGeometry, free: _Values) -> str:
    for name, joint in JOINTS.items():
        if np.array_equal(free, joint(geometry).free):
            return f'"{name}"'
    return f"{{ free = {_vector(free)} }}"


def _segments(rod: Rod) -> list[Rod]:
    """The segments that are there, with lengths that add up to that of the rod, to the last bit."""
    stacked = jax.tree.map(np.asarray, segments_of(rod))
    parts = [jax.tree.map(lambda leaf, j=j: leaf[j], stacked) for j in range(len(stacked.length))]
    first, rest = parts[0], [part for part in parts[1:] if part.length != 0.0]
    if not rest:
        return [first]
    beyond = functools.reduce(operator.add, (part.length for part in rest))
    whole = np.asarray(rod.length)[()]
    near = whole - beyond
    # The difference has digits that nobody wrote.
    shorter = [type(near)(f"{near:.{digits}g}") for digits in range(1, 18)]
    neighbours = np.nextafter(near, 0.0), np.nextafter(near, np.inf)
    fits = (length for length in (*shorter, *neighbours) if length + beyond == whole)
    return [dataclasses.replace(first, length=next(fits, near)), *rest]


def _rod(rod: Rod) -> Iterator[str]:
    yield f"length = {_number(rod.length)}"
    compliances = [float(c) for c in rod.curvature_compliance]
    stiffnesses = [k for k in map(_inverse, compliances) if k is not None]
    if len(stiffnesses) == len(compliances):
        yield f"bending_stiffness = {_rotational(stiffnesses)}"
    else:
        yield f"curvature_compliance = {_rotational(compliances)}"
    if np.any(rod.precurvature):
        yield f"precurvature = {_rotational(rod.precurvature)}"
    for key, loads in (("strain_compliance", rod.strain_compliance), ("force", rod.force)):
        if loads is not None:
            yield f"{key} = {_vector(loads)}"
    if rod.moment is not None:
        yield f"moment = {_rotational(rod.moment)}"


def _inverse(compliance: float) -> float | None:
    """The stiffness whose inverse is a compliance to the last bit, if there is one."""
    if compliance == 0.0:
        return None
    near = 1.0 / compliance
    for stiffness in (near, math.nextafter(near, 0.0), math.nextafter(near, math.inf)):
        if 1.0 / stiffness == compliance:
            return stiffness
    return None


def _number(value: SupportsFloat) -> str:
    return repr(float(value))


def _vector(values: _Values) -> str:
    return f"[{', '.join(_number(value) for value in values)}]"


def _rotational(values: _Values) -> str:
    """One number in the plane, a vector in space."""
    return _number(values[0]) if len(values) == 1 else _vector(values)


def _segment(values: _Values) -> str:
    """A length along the tangent where it is one, otherwise a vector."""
    along = values[0] >= 0.0 and not np.any(values[1:])
    return _number(values[0]) if along else _vector(values)
