"""Stability: how many directions lower the potential energy with the motors held."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..geometry import AbstractGeometry
from ..robots.leg import Leg
from ..robots.robot import Robot
from ..rods.equations import RodState
from ..rods.integration import DEFAULT_STEPS, rod_shape
from ..statics.equilibrium import Equilibrium
from ..statics.linear import inverse_with_sign, negative_eigenvalues
from ..statics.residual import leg_base, to_world
from ..statics.unknowns import scales, unravel

_SOFTENING = 1e-11
"""Flexibility added in units of `scales(robot)`: a straight rod has none along its axis."""


class Stability(eqx.Module):
    """The second variation of the total potential energy at an equilibrium, motors held.

    **Attributes:**

    - `index`: number of independent motions that lower the energy; 0 where it is stable.
    - `leg_indices`: of each leg with its joint where it is, shape `(n,)`.
    - `platform_stiffness`: `∂(Σ n_i)/∂p_P` and for a body the moments and rotations too, in
        world axes, N/m, N, N·m, shape `(n_p, n_p)`.
    - `stable`: whether the index is 0.
    """

    index: Int[Array, ""]
    leg_indices: Int[Array, " n"]
    platform_stiffness: Float[Array, "n_p n_p"]

    @property
    def stable(self) -> Bool[Array, ""]:
        return self.index == 0


def stability(robot: Robot, equilibrium: Equilibrium, steps: int = DEFAULT_STEPS) -> Stability:
    """Counts the negative directions of the energy at an equilibrium.

    By Haynsworth's additivity the index is the sum of those of the rods with both ends clamped,
    of what the joints leave free, and of the platform. That of a clamped rod is the number of
    its conjugate points; here it is taken from the wrenches, as the number of sign changes of
    `det ∂(n, m)(s)/∂(n, m)(0)` along the rod (the index with a free end), less the negative
    eigenvalues of the flexibility `∂(p, φ)(l)/∂(n, m)(l)` of its tip. Unlike conjugate points
    themselves this is well-behaved near the base, and for straight rods.

    NaN-valued equilibria give an index of -1. Rods under distributed moments, which have no
    energy, are judged by the symmetric part of their flexibility.
    """
    return _stability(robot, equilibrium.y, steps)


@eqx.filter_jit
def _stability(robot: Robot, y: Float[Array, " n_y"], steps: int) -> Stability:
    return count_unstable(robot, y, steps)


def count_unstable(robot: Robot, y: Float[Array, " n_y"], steps: int) -> Stability:
    """`stability` at the unknowns `y`, for one configuration; not compiled by itself."""
    robot, y = jax.lax.stop_gradient((robot, y))
    geometry = robot.geometry
    d = geometry.d
    state = unravel(robot, y)
    units = scales(robot)
    pose, wrench = units.pose(robot), units.wrench(robot)
    orientation = geometry.exp(state.q_p[d:]) if robot.oriented else geometry.identity

    def one(leg: Leg, q, mu):
        U, V, tip = _leg_tangents(geometry, leg, q, mu, steps)
        U, V = U / pose[:, None] * wrench, V / wrench[:, None] * wrench
        inverses, signs = jax.vmap(inverse_with_sign)(V)
        free_end = jnp.sum(signs[1:] != signs[:-1])
        flexibility = U @ inverses[-1]
        flexibility = 0.5 * (flexibility + flexibility.T)
        clamped = free_end - negative_eigenvalues(flexibility)

        softened = flexibility + _SOFTENING * jnp.eye(mu.size)
        K = inverse_with_sign(softened)[0] * wrench[:, None] / pose
        b = jnp.stack(geometry.rotate(tip.rotation, leg.b))
        A = jnp.eye(mu.size).at[:d, d:].set(-_spin(geometry, b))
        K = (A.T @ K @ A).at[d:, d:].add(_lever(geometry, b, tip.force))

        arm = jnp.stack(geometry.rotate(orientation, leg.attachment_position))
        follows = jnp.eye(mu.size, robot.n_p)
        if robot.oriented:
            follows = follows.at[:d, d:].set(_spin(geometry, arm))
        Q = _axes(geometry, geometry.compose(orientation, geometry.exp(leg.attachment_rotation)))
        # In the joint's axes and free of units; what is locked gets a stiffness of one.
        K_joint = (Q.T @ K @ Q) / wrench[:, None] * pose
        moves = Q.T @ follows / pose[:, None] * pose[: robot.n_p]
        free = leg.joint.free
        inner = free[:, None] * K_joint * free + jnp.diag(1.0 - free)
        cross = free[:, None] * (K_joint @ moves)
        seen = moves.T @ K_joint @ moves - cross.T @ inverse_with_sign(inner)[0] @ cross
        if robot.oriented:
            turned = _lever(geometry, arm, tip.force) / (units.force * units.length)
            seen = seen.at[d:, d:].add(-turned)
        return clamped + negative_eigenvalues(inner), seen

    legs, stiffnesses = jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu)
    stiffness = jnp.sum(stiffnesses, axis=0)
    index = jnp.sum(legs) + negative_eigenvalues(0.5 * (stiffness + stiffness.T))
    known = jnp.all(jnp.isfinite(stiffness))
    si = stiffness * wrench[: robot.n_p, None] / pose[: robot.n_p]
    return Stability(jnp.where(known, index, -1), jnp.where(known, legs, -1), si)


def _leg_tangents(geometry: AbstractGeometry, leg: Leg, q, mu, steps: int):
    """`∂(p, φ)(l)/∂μ`, `∂(n, m)(s)/∂μ` at the steps along a rod, and its tip, in world axes.

    In space moments are taken with half the turn of their axes, `δm - ½ δφ × m`: position and
    momentum in this sense are conjugate, so that flexibilities are symmetric.
    """
    base = leg_base(geometry, leg, q, mu)

    def along(mu):
        force = jnp.stack(geometry.unrotate(base.rotation, mu[: geometry.d]))
        moment = jnp.stack(geometry.to_local(base.rotation, mu[geometry.d :]))
        local = rod_shape(geometry, base.rod, force, moment, steps)

        def expand(state: RodState):
            world = to_world(geometry, base, state)
            fixed = jax.lax.stop_gradient(world)
            turn = jnp.stack(
                geometry.log(geometry.compose(world.rotation, geometry.inverse(fixed.rotation)))
            )
            moment = world.moment - 0.5 * _turned(geometry, turn, fixed.moment)
            return (
                jnp.concatenate([world.position, turn]),
                jnp.concatenate([world.force, moment]),
                world,
            )

        poses, wrenches, world = jax.vmap(expand)(local)
        return (poses[-1], wrenches), jax.tree.map(lambda leaf: leaf[-1], world)

    (U, V), tip = jax.jacfwd(along, has_aux=True)(mu)
    return U, V, tip


def _turned(geometry: AbstractGeometry, turn, moment):
    """Change of a moment whose axes turn: `φ × m` in space, none in the plane."""
    if geometry.r == 1:
        return jnp.zeros_like(moment)
    return jnp.cross(turn, moment)


def _spin(geometry: AbstractGeometry, arm) -> Float[Array, "d r"]:
    """Motion `φ × arm` of the end of an arm for a unit turn about each axis."""
    unit = jnp.eye(geometry.d)
    return jax.vmap(lambda force: jnp.stack(geometry.cross(arm, force)))(unit)


def _lever(geometry: AbstractGeometry, arm, force) -> Float[Array, "r r"]:
    """Second derivative in a turn of `-force · R arm`, symmetrised."""
    along = jnp.dot(arm, force) * jnp.eye(geometry.r)
    if geometry.r == 1:
        return along
    product = jnp.outer(arm, force)
    return along - 0.5 * (product + product.T)


def _axes(geometry: AbstractGeometry, rotation) -> Float[Array, "freedoms freedoms"]:
    """Columns: the axes of a frame for positions, then for rotations."""
    d, r = geometry.d, geometry.r
    arms = jax.vmap(lambda v: jnp.stack(geometry.rotate(rotation, v)))(jnp.eye(d)).T
    turns = jax.vmap(lambda v: jnp.stack(geometry.to_outer(rotation, v)))(jnp.eye(r)).T
    return jnp.zeros((d + r, d + r)).at[:d, :d].set(arms).at[d:, d:].set(turns)
