"""A continuum parallel robot: its legs, its platform, its loads."""

import dataclasses
from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import SPACE, AbstractGeometry, Numbers, namespace
from .leg import Leg


class Home(eqx.Module):
    """A configuration that names the branch a robot works on.

    Only a rough one is needed: the robot is assembled there and the equilibrium is polished.

    **Attributes:**

    - `q_a`: motor positions, shape `(n_a,)`.
    - `q_p`: platform coordinates, shape `(n_p,)`.
    """

    q_a: Float[Array, " n_a"]
    q_p: Float[Array, " n_p"]


class PointLoads(eqx.Module):
    """Dead forces at points of a platform that is a body.

    **Attributes:**

    - `position`: in the platform's axes, from `p_P`, m, shape `(k, d)`.
    - `force`: in world axes, N, shape `(k, d)`.
    """

    position: Float[Array, "k d"]
    force: Float[Array, "k d"]


class Robot(eqx.Module):
    """A continuum parallel robot as a pytree: each of its numbers is an array leaf.

    **Attributes:**

    - `geometry`: `PLANE` or `SPACE`.
    - `legs`: a `Leg` whose leaves are stacked along a first axis of length n.
    - `oriented`: whether the platform is a rigid body; otherwise it is a mere point, without an
        orientation among the unknowns and without a moment balance.
    - `f_P`: dead force on the platform at `p_P`, world axes, N, shape `(d,)`.
    - `m_P`: dead moment on the platform, world axes, N·m, shape `(r,)`; unused by a point.
    - `loads`: forces at other points of the platform, such as its weight, or `None`.
    - `transmission`: motion of each leg's actuator per motor, shape `(n, n_a)`; the identity
        where each leg has its motor.
    - `home`: where the robot's branch is known, or `None`.
    - `uncertainty`: half ranges `δρ` (6) of uncertain parameters by their label.
    - `name`: for figures and files.
    """

    geometry: AbstractGeometry = eqx.field(static=True)
    legs: Leg
    oriented: bool = eqx.field(static=True)
    f_P: Float[Array, " d"]
    m_P: Float[Array, " r"]
    transmission: Float[Array, "n n_a"]
    home: Home | None
    uncertainty: dict[str, Float[Array, ""]]
    name: str = eqx.field(static=True)
    loads: PointLoads | None = None

    @property
    def n(self) -> int:
        """Number of legs."""
        return self.transmission.shape[-2]

    @property
    def n_a(self) -> int:
        """Number of motors."""
        return self.transmission.shape[-1]

    @property
    def n_p(self) -> int:
        """Number of platform coordinates: position, then the rotation vector of a body."""
        return self.geometry.d + (self.geometry.r if self.oriented else 0)

    @property
    def n_y(self) -> int:
        """Number of unknowns in `y = (q_a, q_p, μ)`."""
        return self.n_a + self.n_p + self.n * self.geometry.freedoms

    def leg(self, i: int) -> Leg:
        """Leg `i`, counted from 0."""
        return jax.tree.map(lambda leaf: leaf[i], self.legs)


def make_robot(
    geometry: AbstractGeometry,
    legs: Sequence[Leg],
    *,
    oriented: bool,
    f_P: Numbers | None = None,
    m_P: Numbers | None = None,
    loads: Sequence[tuple[Numbers, Numbers]] = (),
    transmission: Numbers | None = None,
    home: tuple[Numbers, Numbers] | None = None,
    uncertainty: dict[str, float] | None = None,
    name: str = "robot",
) -> Robot:
    """Stacks legs, which may differ in every number, into a robot.

    An effect that only some legs have (a distributed load, extensibility, fed length) becomes a
    zero for the others.

    **Arguments:** as the attributes of `Robot`, and

    - `loads`: pairs of a point of the platform and the force there, see `PointLoads`.
    """
    if len(legs) == 0:
        raise ValueError("Argument `legs` must hold at least one leg, but it is empty.")
    if loads and not oriented:
        raise ValueError(
            "Argument `loads` must be left out at a point platform, whose only force is `f_P`, but "
            f"it has {len(loads)} entries."
        )

    def vector(value, size):
        return jnp.asarray(np.zeros(size) if value is None else value, float)

    stacked = _stack(legs)
    known = None
    if home is not None:
        known = Home(jnp.asarray(home[0], float), jnp.asarray(home[1], float))
    return Robot(
        geometry=geometry,
        legs=stacked,
        oriented=oriented,
        f_P=vector(f_P, geometry.d),
        m_P=vector(m_P, geometry.r).reshape(-1),
        transmission=jnp.asarray(np.eye(len(legs)) if transmission is None else transmission),
        home=known,
        uncertainty={k: jnp.asarray(v, float) for k, v in (uncertainty or {}).items()},
        name=name,
        loads=_point_loads(loads) if loads else None,
    )


def _point_loads(loads: Sequence[tuple[Numbers, Numbers]]) -> PointLoads:
    places, forces = zip(*loads, strict=True)
    xp = namespace(places, forces)
    position, force = (
        jnp.asarray(xp.stack([xp.asarray(v, float) for v in vectors]))
        for vectors in (places, forces)
    )
    return PointLoads(position, force)


def _stack(legs: Sequence[Leg]) -> Leg:
    def none(leaf):
        return leaf is None

    def stack(*leaves):
        present = [leaf for leaf in leaves if leaf is not None]
        if not present:
            return None
        xp = namespace(*present)
        zero = np.zeros(present[0].shape)
        return jnp.asarray(xp.stack([zero if leaf is None else leaf for leaf in leaves]))

    joints = [leg.base_joint for leg in legs if leg.base_joint is not None]
    if joints:
        locked = jax.tree.map(lambda leaf: jnp.asarray(np.zeros(leaf.shape)), joints[0])
        legs = [
            dataclasses.replace(leg, base_joint=locked) if leg.base_joint is None else leg
            for leg in legs
        ]
    return jax.tree.map(stack, *legs, is_leaf=none)


def in_space(robot: Robot) -> Robot:
    """A planar robot embedded in the yz-plane of space.

    The rods get the same stiffness about all three axes. Joints of a point platform become
    spherical; those of a body stay pivots about the normal of the plane.
    """
    # Local axes (tangent, normal in the plane, x): the cyclic rotation of the world's axes.
    third = 2.0 * jnp.pi / 3.0 / jnp.sqrt(3.0)
    to_plane = jnp.full((robot.n, 3), third)

    def local(vectors):
        return jnp.concatenate([vectors, jnp.zeros((*vectors.shape[:-1], 1))], axis=-1)

    def world(vectors):
        return jnp.concatenate([jnp.zeros((*vectors.shape[:-1], 1)), vectors], axis=-1)

    def turned(angles):
        geometry = SPACE
        return jax.vmap(
            lambda angle, v: jnp.stack(
                geometry.log(geometry.compose(geometry.exp((angle[0], 0.0, 0.0)), geometry.exp(v)))
            )
        )(angles, to_plane)

    def twist(values):
        d, r = jnp.split(values, [2], axis=-1)
        zeros = jnp.zeros((*d.shape[:-1], 1))
        return jnp.concatenate([d, zeros, zeros, zeros, r], axis=-1)

    legs, rod = robot.legs, robot.legs.rod
    free = twist(legs.joint.free)
    if not robot.oriented:
        free = free.at[:, 3:].set(1.0)
        attachment_rotation = jnp.zeros((robot.n, 3))
    else:
        attachment_rotation = turned(legs.attachment_rotation)
    strain = rod.strain_compliance
    spatial = Leg(
        base_position=world(legs.base_position),
        base_rotation=turned(legs.base_rotation),
        screw=twist(legs.screw),
        a=local(legs.a),
        rod=eqx.tree_at(
            lambda r: (
                r.curvature_compliance,
                r.precurvature,
                r.strain_compliance,
                r.force,
                r.moment,
            ),
            rod,
            (
                jnp.repeat(rod.curvature_compliance, 3, axis=-1),
                jnp.pad(rod.precurvature, ((0, 0), (2, 0))),
                None if strain is None else jnp.concatenate([strain, strain[:, 1:]], axis=-1),
                None if rod.force is None else world(rod.force),
                None if rod.moment is None else jnp.pad(rod.moment, ((0, 0), (0, 2))),
            ),
            is_leaf=lambda leaf: leaf is None,
        ),
        b=local(legs.b),
        joint=eqx.tree_at(lambda joint: joint.free, legs.joint, free),
        attachment_position=world(legs.attachment_position),
        attachment_rotation=attachment_rotation,
        feed=legs.feed,
    )
    home = robot.home
    if home is not None:
        position, angle = home.q_p[:2], home.q_p[2:]
        pose = jnp.concatenate([world(position), jnp.pad(angle, (0, 2 * len(angle)))])
        home = Home(home.q_a, pose)
    return Robot(
        geometry=SPACE,
        legs=spatial,
        oriented=robot.oriented,
        f_P=world(robot.f_P),
        m_P=jnp.pad(robot.m_P, (0, 2)),
        transmission=robot.transmission,
        home=home,
        uncertainty=robot.uncertainty,
        name=f"{robot.name} in space",
    )
