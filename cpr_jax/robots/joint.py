"""Joints as data: which relative motions they leave free."""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from ..checks import check_kind, check_vector
from ..errors import check_integer
from ..geometry import AbstractGeometry, Numbers, floats, namespace


class Joint(eqx.Module):
    """The joint between the tip of a leg and the platform.

    Each direction of the joint frame gives one row of the residual: where it is locked, the
    relative position or rotation, which must vanish; where it is free, the component of the
    transmitted wrench, which must vanish too. No joint needs code of its own.

    A joint that leaves two rotations free is a universal joint: the earlier of its two axes
    belongs to the platform, the later one to the leg.

    **Attributes:**

    - `free`: 1 where the relative motion is free, 0 where it is locked; the `d` translations,
        then the `r` rotations along the joint's axes, of which the first is the tangent.
    - `lever`: 1 takes the moment at the joint, `m(l) - R b × n(l)`; 0 takes it at the tip of the
        rod, `m(l)`, as (15) is printed, which is not in equilibrium unless b = 0.
    """

    free: Float[Array, "*batch freedoms"]
    lever: Float[Array, "*batch"]


class BaseJoint(eqx.Module):
    """A passive joint between the motor of a leg and its rigid segment a.

    Its free motions are unknowns: in the place of the components of the base wrench, which they
    leave without a load. Of the two axes of a universal joint the earlier belongs to the motor.

    **Attributes:**

    - `free`: as in `Joint`.
    - `position`, `rotation`: where it sits on what the motor moves, in the axes of that, m and
        rad (a rotation vector): a crank ends here. The leg's tangent is its first axis.
    """

    free: Float[Array, "*batch freedoms"]
    position: Float[Array, "*batch d"]
    rotation: Float[Array, "*batch r"]


def passive(
    geometry: AbstractGeometry,
    joint: Joint,
    position: Numbers | None = None,
    rotation: Numbers | None = None,
) -> BaseJoint:
    """The freedoms of a joint at the base of a leg, see `BaseJoint`.

    **Raises:** `InputError` for shapes that do not fit, and what is not a joint.
    """
    check_kind("joint", joint, Joint, "a joint, such as `pivot(PLANE)` makes")

    def vector(name, value, size):
        if value is None:
            return floats(np.zeros(size))
        check_vector(name, value, size)
        return floats(namespace(value).reshape(floats(value), size))

    place = vector("position", position, geometry.d), vector("rotation", rotation, geometry.r)
    return BaseJoint(joint.free, *place)


def _joint(geometry: AbstractGeometry, translations: list[int], rotations: list[int]) -> Joint:
    free = np.zeros(geometry.freedoms)
    free[translations + [geometry.d + k for k in rotations]] = 1.0
    return Joint(free=floats(free), lever=floats(1.0))


def pivot(geometry: AbstractGeometry) -> Joint:
    """A revolute joint about the last local axis, the normal of a planar robot's plane."""
    return _joint(geometry, [], [geometry.r - 1])


def universal(geometry: AbstractGeometry) -> Joint:
    """A joint that passes on torsion and lets the tangent turn; in the plane a `pivot`."""
    return _joint(geometry, [], list(range(geometry.r))[-2:])


def spherical(geometry: AbstractGeometry) -> Joint:
    """A joint that leaves every rotation free; in the plane the same as `pivot`."""
    return _joint(geometry, [], list(range(geometry.r)))


def clamped(geometry: AbstractGeometry) -> Joint:
    """A rigid connection."""
    return _joint(geometry, [], [])


def swivel(geometry: AbstractGeometry) -> Joint:
    """A rigid connection but for the twist about the tangent; in the plane `clamped`."""
    return _joint(geometry, [], [0] if geometry.r > 1 else [])


def slider(geometry: AbstractGeometry, axis: int = 0) -> Joint:
    """A prismatic joint along a local axis (0: the first axis of the platform's attachment)."""
    check_integer("axis", axis, least=0, most=geometry.d - 1)
    return _joint(geometry, [axis], [])
