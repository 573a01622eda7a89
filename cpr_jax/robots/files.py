"""Robot files: TOML with units to robots, and back."""

import dataclasses
import os
import tomllib
import warnings

import jax
import numpy as np
from jaxtyping import Array, Float

from ..atomic import write_atomically
from ..geometry import PLANE, SPACE, AbstractGeometry, floats
from ..rods.rod import Rod, kirchhoff_rod, section_rod
from ..rods.section import Material, circle, rectangle
from ..rods.segments import segmented_rod
from .joint import BaseJoint, Joint, passive
from .leg import Leg, make_leg, prismatic_screw, revolute_screw
from .reading import parse_specification, read_specification
from .robot import Robot, make_robot
from .specification import (
    BaseJointSpecification,
    LegSpecification,
    MotorSpecification,
    RobotSpecification,
    RodSpecification,
)
from .writing import JOINTS, inexpressible, robot_text

_GEOMETRIES = {"plane": PLANE, "space": SPACE}


def load_robot(path: str | os.PathLike[str]) -> Robot:
    """Reads a robot file; its format is in `docs/robot-files.md`.

    **Raises:**

    - `InputError`: if the file cannot be read or does not describe a robot.
    """
    return robot_from_specification(read_specification(path))


def robot_from_specification(specification: RobotSpecification) -> Robot:
    """The robot that a file describes; the file's suspicious places become Python warnings."""
    for message in specification.warnings:
        warnings.warn(message, UserWarning, stacklevel=2)
    geometry = _GEOMETRIES[specification.geometry]
    home, platform = specification.home, specification.platform
    force = np.asarray(platform.force, float)
    loads = [(floats(load.position), floats(load.force)) for load in platform.loads]
    if platform.mass is not None and specification.gravity is not None:
        weight = platform.mass * np.asarray(specification.gravity, float)
        if platform.kind == "point":
            force = force + weight
        else:
            loads.insert(0, (floats(platform.center_of_mass), floats(weight)))
    transmission = np.zeros((len(specification.legs), len(specification.motors)))
    for motor, moved in enumerate(specification.motors):
        transmission[list(moved), motor] = 1.0
    return make_robot(
        geometry,
        [_leg(geometry, leg, specification.gravity) for leg in specification.legs],
        oriented=platform.kind == "body",
        f_P=floats(force),
        m_P=floats(platform.moment) if platform.kind == "body" else None,
        loads=loads,
        transmission=transmission,
        home=None if home is None else (floats(home.motors), floats(home.position + home.rotation)),
        uncertainty=specification.uncertainty,
        name=specification.name,
    )


def _leg(
    geometry: AbstractGeometry, leg: LegSpecification, gravity: tuple[float, ...] | None
) -> Leg:
    joint = _joint(geometry, leg.joint)
    if leg.moment_row == "printed":
        joint = dataclasses.replace(joint, lever=floats(0.0))
    motor = leg.motor
    return make_leg(
        geometry,
        floats(leg.base),
        segmented_rod([_rod(geometry, segment, gravity) for segment in leg.segments]),
        a=floats(leg.a),
        b=floats(leg.b),
        base_rotation=floats(leg.base_rotation),
        screw=_screw(geometry, motor),
        feed=motor.ratio if motor.kind == "feed" else None,
        stroke=motor.ratio if motor.kind == "telescopic" else None,
        base_joint=None if leg.base_joint is None else _base_joint(geometry, leg.base_joint),
        joint=joint,
        attachment_position=floats(leg.attachment),
        attachment_rotation=floats(leg.attachment_rotation),
    )


def _joint(geometry: AbstractGeometry, joint: str | tuple[float, ...]) -> Joint:
    if isinstance(joint, str):
        return JOINTS[joint](geometry)
    return Joint(free=floats(joint), lever=floats(1.0))


def _base_joint(geometry: AbstractGeometry, joint: BaseJointSpecification) -> BaseJoint:
    return passive(geometry, _joint(geometry, joint.joint), joint.position, joint.rotation)


def _screw(geometry: AbstractGeometry, motor: MotorSpecification) -> Float[Array, " freedoms"]:
    still = (0.0,) * geometry.freedoms
    if motor.kind not in ("revolute", "prismatic"):
        return floats(still)
    if motor.axis is None:
        usual = revolute_screw if motor.kind == "revolute" else prismatic_screw
        return floats(motor.ratio * np.asarray(usual(geometry)))
    axis = tuple(motor.ratio * c for c in motor.axis)
    if motor.kind == "revolute":
        return floats((*still[: geometry.d], *axis))
    return floats((*axis, *still[geometry.d :]))


def _rod(
    geometry: AbstractGeometry, rod: RodSpecification, gravity: tuple[float, ...] | None
) -> Rod:
    rest = floats(rod.precurvature)
    elastic = strain = None
    if rod.section is not None and rod.material is not None and rod.material.E is not None:
        shape = rectangle if rod.section.kind == "rectangle" else circle
        section = shape(*rod.section.sizes)
        if rod.section.shear_factor is not None:
            section = dataclasses.replace(section, shear_factor=rod.section.shear_factor)
        elastic = section, Material(rod.material.E, rod.material.nu)
    if rod.bending_stiffness is not None:
        built = kirchhoff_rod(geometry, rod.length, floats(rod.bending_stiffness), rest)
    elif rod.curvature_compliance is not None:
        built = kirchhoff_rod(geometry, rod.length, 1.0, rest)
        compliance = floats(rod.curvature_compliance)
        built = dataclasses.replace(built, curvature_compliance=compliance)
    elif elastic is not None:
        built = section_rod(geometry, rod.length, *elastic, rest)
    else:
        raise ValueError("Argument `rod` must have a stiffness, but it has none.")
    if rod.extensible and elastic is not None:
        _, strain = elastic[0].compliances(geometry, elastic[1])
    elif rod.strain_compliance is not None:
        strain = floats(rod.strain_compliance)
    force = None if rod.force is None else np.asarray(rod.force, float)
    if gravity is not None and rod.mass_per_length is not None:
        weight = rod.mass_per_length * np.asarray(gravity, float)
        force = weight if force is None else force + weight
    return dataclasses.replace(
        built,
        strain_compliance=strain,
        force=None if force is None else floats(force),
        moment=None if rod.moment is None else floats(rod.moment),
    )


def save_robot(robot: Robot, path: str | os.PathLike[str]) -> None:
    """Writes a robot to a file, in SI units, such that loading it gives back every last bit.

    A file that exists is replaced at once: a reader never sees a part of it.

    **Raises:**

    - `ValueError`: if a file cannot express the robot: a motor that turns and slides at once, or
        moves its legs by different shares, several robots in one.
    """
    text = robot_text(robot)
    specification = parse_specification(tomllib.loads(text), "robot")
    # Suspicions are for those who write files by hand.
    loaded = robot_from_specification(dataclasses.replace(specification, warnings=()))
    before, after = _numbers(robot), _numbers(loaded)
    for place in before | after:
        # What one of the two lacks is an effect that is left out, the same as zero.
        if not np.all(before.get(place, 0.0) == after.get(place, 0.0)):
            raise inexpressible(f"its `{place.lstrip('.')}` is out of the ordinary")
    content = text.encode()
    write_atomically(os.fsdecode(path), lambda file: file.write_bytes(content))


def _numbers(robot: Robot) -> dict[str, np.ndarray]:
    leaves, _ = jax.tree_util.tree_flatten_with_path(robot)
    return {jax.tree_util.keystr(path): np.asarray(leaf) for path, leaf in leaves}
