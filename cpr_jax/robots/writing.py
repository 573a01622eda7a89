"""The text of a robot file, in SI units, from a robot."""

import json
import math
from collections.abc import Iterator, Sequence
from typing import SupportsFloat, TypeAlias

import numpy as np
from jaxtyping import Array

from ..geometry import AbstractGeometry
from ..rods.rod import Rod
from .joint import clamped, pivot, slider, spherical
from .leg import Leg, prismatic_screw, revolute_screw
from .reading import FORMAT
from .robot import Robot

JOINTS = {"pivot": pivot, "spherical": spherical, "clamped": clamped, "slider": slider}
"""The joints that have a name in robot files."""

_Values: TypeAlias = Sequence[float] | np.ndarray | Array


def robot_text(robot: Robot) -> str:
    """The robot file of a robot; what such a file cannot express is left out or misstated.

    **Raises:**

    - `ValueError`: if the robot is a batch or its motors are not those of its legs.
    """
    if robot.transmission.ndim != 2:
        raise inexpressible("it is a batch of robots")
    if not np.array_equal(robot.transmission, np.eye(robot.n)):
        raise inexpressible("its transmission is not the identity, one motor for each leg")
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
    yield from ("", "[platform]", f'kind = "{"body" if robot.oriented else "point"}"')
    yield f"force = {_vector(robot.f_P)}"
    if robot.oriented:
        yield f"moment = {_rotational(robot.m_P)}"
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


def _leg(geometry: AbstractGeometry, leg: Leg, oriented: bool) -> Iterator[str]:
    yield f"base = {_vector(leg.base_position)}"
    if np.any(leg.base_rotation):
        yield f"base_rotation = {_rotational(leg.base_rotation)}"
    yield f"motor = {_motor(geometry, leg.screw)}"
    yield f"a = {_segment(leg.a)}"
    yield f"b = {_segment(leg.b)}"
    yield f"joint = {_joint(geometry, leg.joint.free)}"
    if leg.joint.lever == 0.0:
        yield 'moment_row = "printed"'
    if oriented:
        yield f"attachment = {_vector(leg.attachment_position)}"
        if np.any(leg.attachment_rotation):
            yield f"attachment_rotation = {_rotational(leg.attachment_rotation)}"
    yield from ("", "[legs.rod]", *_rod(leg.rod))


def _motor(geometry: AbstractGeometry, screw: _Values) -> str:
    for kind, usual in (("revolute", revolute_screw), ("prismatic", prismatic_screw)):
        if np.array_equal(screw, usual(geometry)):
            return f'"{kind}"'
    slide, turn = np.split(screw, [geometry.d])
    if not np.any(turn):
        return f'{{ kind = "prismatic", axis = {_vector(slide)} }}'
    # Its translation, if it is a screw, is what the file cannot express.
    axis = "" if geometry.r == 1 else f", axis = {_vector(turn)}"
    return f'{{ kind = "revolute"{axis} }}'


def _joint(geometry: AbstractGeometry, free: _Values) -> str:
    for name, joint in JOINTS.items():
        if np.array_equal(free, joint(geometry).free):
            return f'"{name}"'
    return f"{{ free = {_vector(free)} }}"


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
