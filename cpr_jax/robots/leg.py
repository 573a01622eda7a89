"""A leg: actuator, passive joint, segment a, rod, segment b, joint, place on the platform."""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from ..checks import check_kind, check_shape, check_vector
from ..errors import InputError, check_integer
from ..geometry import AbstractGeometry, Numbers, floats, namespace
from ..rods.rod import Rod
from .joint import BaseJoint, Joint, pivot


class Leg(eqx.Module):
    """One leg; in a robot, all legs stacked along a first axis.

    **Attributes** (lengths in m, angles in rad):

    - `base_position`: of the motor in world axes, shape `(d,)`.
    - `base_rotation`: orientation of the motor at `q = 0` as a rotation vector, shape `(r,)`.
    - `screw`: motion of the motor per unit of `q` in its own axes: `d` translations, `r`
        rotations. A revolute motor has a 1 in its last place.
    - `feed`: rod length fed per unit of `q`, or `None` where no leg feeds any.
    - `stroke`: by what `a` grows per unit of `q`, shape `(d,)`, or `None`: a motor beyond the
        passive joint, such as that of a telescopic leg.
    - `base_joint`: a passive joint that the motor carries, or `None`.
    - `a`, `b`: rigid segments before and after the rod, in the axes of the rod's ends, `(d,)`.
    - `rod`, `joint`: see `Rod` and `Joint`.
    - `attachment_position`, `attachment_rotation`: joint frame on the platform, in its axes.
    - `turns`: whether any motor may turn its leg. Where none does, no rotation in `screw` counts,
        and programs are spared the derivatives of the rods by how gravity lies to them.
    """

    base_position: Float[Array, "*batch d"]
    base_rotation: Float[Array, "*batch r"]
    screw: Float[Array, "*batch freedoms"]
    a: Float[Array, "*batch d"]
    rod: Rod
    b: Float[Array, "*batch d"]
    joint: Joint
    attachment_position: Float[Array, "*batch d"]
    attachment_rotation: Float[Array, "*batch r"]
    feed: Float[Array, "*batch"] | None = None
    stroke: Float[Array, "*batch d"] | None = None
    base_joint: BaseJoint | None = None
    turns: bool = eqx.field(static=True, default=True)


def revolute_screw(geometry: AbstractGeometry) -> Float[Array, " freedoms"]:
    """A motor that turns about the last local axis."""
    return floats(np.eye(geometry.freedoms)[-1])


def prismatic_screw(geometry: AbstractGeometry, axis: int = 0) -> Float[Array, " freedoms"]:
    """A motor that slides along a local axis, counted from 0."""
    check_integer("axis", axis, least=0, most=geometry.d - 1)
    return floats(np.eye(geometry.freedoms)[axis])


def make_leg(
    geometry: AbstractGeometry,
    base_position: Numbers,
    rod: Rod,
    *,
    a: Numbers = 0.0,
    b: Numbers = 0.0,
    base_rotation: Numbers | None = None,
    screw: Numbers | None = None,
    feed: Numbers | None = None,
    stroke: Numbers | None = None,
    base_joint: BaseJoint | None = None,
    joint: Joint | None = None,
    attachment_position: Numbers | None = None,
    attachment_rotation: Numbers | None = None,
) -> Leg:
    """A leg with the usual defaults: a revolute motor, a pivot, no rigid segments.

    `a`, `b` and `stroke` are vectors in the axes of the rod's ends, or lengths along its tangent.
    A motor that feeds rod or has a stroke does nothing else unless `screw` is given.

    **Raises:** `InputError` for shapes that do not fit, and parts of the other geometry.
    """
    check_kind("geometry", geometry, AbstractGeometry, "PLANE or SPACE")
    check_kind("rod", rod, Rod, "a rod, such as `kirchhoff_rod` makes")
    if joint is not None:
        check_kind("joint", joint, Joint, "a joint, such as `pivot(PLANE)` makes")
    if base_joint is not None:
        check_kind("base_joint", base_joint, BaseJoint, "a joint that `passive` makes")
    d, r = geometry.d, geometry.r

    def along_tangent(name, segment):
        check_shape(name, segment, (), (d,))
        xp = namespace(segment)
        segment = xp.asarray(segment, float)
        rest = np.zeros(geometry.d - 1)
        return floats(segment if segment.ndim else xp.append(segment, rest))

    def vector(name, value, size):
        if value is None:
            return floats(np.zeros(size))
        check_vector(name, value, size)
        xp = namespace(value)
        return floats(xp.asarray(value, float).reshape(size))

    def number(name, value):
        check_shape(name, value, ())
        return floats(value)

    parts = {
        "rod": (rod.precurvature, r),
        "joint": (None if joint is None else joint.free, geometry.freedoms),
        "base_joint": (None if base_joint is None else base_joint.free, geometry.freedoms),
    }
    for name, (numbers, size) in parts.items():
        if numbers is not None and np.shape(numbers)[-1] != size:
            raise InputError(
                f"Argument `{name}` must be made for the geometry of the leg, {geometry!r}, but it "
                "is for another."
            )
    if screw is None:
        alone = feed is None and stroke is None
        screw = revolute_screw(geometry) if alone else np.zeros(geometry.freedoms)
    return Leg(
        base_position=vector("base_position", base_position, d),
        base_rotation=vector("base_rotation", base_rotation, r),
        screw=vector("screw", screw, geometry.freedoms),
        a=along_tangent("a", a),
        rod=rod,
        b=along_tangent("b", b),
        joint=pivot(geometry) if joint is None else joint,
        attachment_position=vector("attachment_position", attachment_position, d),
        attachment_rotation=vector("attachment_rotation", attachment_rotation, r),
        feed=None if feed is None else number("feed", feed),
        stroke=None if stroke is None else along_tangent("stroke", stroke),
        base_joint=base_joint,
    )
