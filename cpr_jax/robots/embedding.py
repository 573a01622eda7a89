"""A planar robot as one of space."""

import dataclasses
from operator import attrgetter

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ..errors import InputError
from ..geometry import SPACE
from ..rods.rod import Rod, Segments
from .joint import BaseJoint, Joint
from .labels import path_of
from .leg import Leg
from .robot import Home, PointLoads, Robot


def in_space(robot: Robot) -> Robot:
    """A planar robot embedded in the yz-plane of space.

    The rods get the same stiffness about all three axes. Joints of a point platform become
    spherical; those of a body, and passive joints at the base, keep to the normal of the plane.
    Half ranges keep to their parameters.

    **Raises:** `InputError` for a robot in space, and for a half range of a number in the place of
    which there are several.
    """
    if robot.geometry.d != 2:
        raise InputError("Argument `robot` must be planar, but it is in space already.")
    plain = dataclasses.replace(robot, uncertainty={})
    spatial = _embedded(plain)
    moved = {_label(plain, spatial, label): size for label, size in robot.uncertainty.items()}
    return dataclasses.replace(spatial, uncertainty=moved)


def _label(robot: Robot, spatial: Robot, label: str) -> str:
    """What a parameter is called in space, where the arrays that paths lead to are larger."""
    place = path_of(label)
    if place is None:
        return label
    path, index = place
    leaf = attrgetter(path)
    changed = eqx.tree_at(leaf, robot, leaf(robot).at[index].add(1.0))
    places = np.argwhere(np.asarray(leaf(_embedded(changed)) != leaf(spatial)))
    if len(places) != 1:
        raise InputError(
            f"Argument `robot` must leave out the half range of {label!r}, in the place of which "
            f"space has {len(places)} numbers."
        )
    return f"{path}[{','.join(map(str, places[0]))}]"


def _embedded(robot: Robot) -> Robot:
    # Local axes (tangent, normal in the plane, x): the cyclic rotation of the world's axes.
    to_plane = jnp.full((robot.n, 3), 2.0 * jnp.pi / 3.0 / jnp.sqrt(3.0))

    def padded(values, before, after, mode="constant"):
        if values is None:
            return None
        return jnp.pad(values, ((0, 0),) * (values.ndim - 1) + ((before, after),), mode)

    def local(vectors):
        return padded(vectors, 0, 1)

    def world(vectors):
        return padded(vectors, 1, 0)

    def about_third(angles):
        return padded(angles, 2, 0)

    def about_x(angles):
        return padded(angles, 0, 2)

    def turned(angles):
        def one(angle, v):
            return SPACE.log(SPACE.compose(SPACE.exp(angle), SPACE.exp(v)))

        return jax.vmap(one)(about_x(angles), to_plane)

    def twist(values):
        return jnp.concatenate([local(values[:, :2]), about_third(values[:, 2:])], axis=-1)

    def elastic(part):
        """What a rod and its further segments have alike."""
        return {
            "length": part.length,
            "curvature_compliance": jnp.repeat(part.curvature_compliance, 3, axis=-1),
            "precurvature": about_third(part.precurvature),
            "strain_compliance": padded(part.strain_compliance, 0, 1, "edge"),
            "force": world(part.force),
            "moment": about_x(part.moment),
        }

    legs, rod = robot.legs, robot.legs.rod
    free, attachment_rotation = twist(legs.joint.free), turned(legs.attachment_rotation)
    if not robot.oriented:
        free = free.at[:, 3:].set(1.0)
        attachment_rotation = jnp.zeros((robot.n, 3))
    passive, further = legs.base_joint, rod.further
    if passive is not None:
        passive = BaseJoint(
            twist(passive.free), local(passive.position), about_third(passive.rotation)
        )
    spatial = Leg(
        base_position=world(legs.base_position),
        base_rotation=turned(legs.base_rotation),
        screw=twist(legs.screw),
        a=local(legs.a),
        rod=Rod(**elastic(rod), further=None if further is None else Segments(**elastic(further))),
        b=local(legs.b),
        joint=Joint(free, legs.joint.lever),
        attachment_position=world(legs.attachment_position),
        attachment_rotation=attachment_rotation,
        feed=legs.feed,
        stroke=local(legs.stroke),
        base_joint=passive,
        turns=legs.turns,
    )
    home, loads = robot.home, robot.loads
    if home is not None:
        position, angle = home.q_p[:2], home.q_p[2:]
        pose = jnp.concatenate([jnp.pad(position, (1, 0)), jnp.pad(angle, (0, 2 * len(angle)))])
        home = Home(home.q_a, pose)
    return Robot(
        geometry=SPACE,
        legs=spatial,
        oriented=robot.oriented,
        f_P=jnp.pad(robot.f_P, (1, 0)),
        m_P=jnp.pad(robot.m_P, (0, 2)),
        transmission=robot.transmission,
        home=home,
        uncertainty={},
        name=f"{robot.name} in space",
        loads=None if loads is None else PointLoads(world(loads.position), world(loads.force)),
    )
