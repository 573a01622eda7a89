"""Stability: how many directions lower the potential energy with the motors held."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..errors import check_integer
from ..geometry import AbstractGeometry
from ..programs import brief_program
from ..robots.leg import Leg
from ..robots.robot import Robot
from ..rods.equations import RodState
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium, check_fits
from ..statics.linear import inverse_with_sign, negative_eigenvalues
from ..statics.residual import load_arms, residual_in_world
from ..statics.unknowns import scales, unravel
from ..summary import in_notebook, summary
from .belonging import check_belongs
from .joint_energy import axes_of, bent, carried_work, released_base
from .pieces import Pieces, rods_in_pieces, tip_of, units_of_variations

_SOFTENING = 1e-11
"""Flexibility added in units of `scales(robot)`: a straight rod has none along its axis."""

_HOLD = 1e-7
"""Stiffness against free motions of a base joint, where their number is to be told only."""


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

    _repr_pretty_ = in_notebook

    def __str__(self) -> str:
        return summary(
            self,
            "Stability with the motors held: the index counts motions that lower the energy",
            index=self.index,
            leg_indices=self.leg_indices,
            platform_stiffness=self.platform_stiffness,
        )

    @property
    def stable(self) -> Bool[Array, ""]:
        return self.index == 0


def stability(robot: Robot, equilibrium: Equilibrium, steps: int = DEFAULT_STEPS) -> Stability:
    """Counts the negative directions of the energy at an equilibrium.

    By Haynsworth's additivity the index is the sum of those of the rods with both ends clamped,
    of what the joints leave free, and of the platform. That of a clamped rod is the number of
    its conjugate points. Here it is taken from the rod with a free end under dead loads, built up
    from its `steps` pieces, less the negative eigenvalues of the flexibility of its tip. Unlike
    conjugate points this is well-behaved near the base, for straight rods, and where several of
    them coincide. Each piece must be stable by itself, which fails beyond forces of about
    `(steps π / 2)² k_b / l²`.

    NaN-valued equilibria give an index of -1. What has no energy is judged by its nearest kin:
    rods under distributed moments by the symmetric part of their flexibility, a body in space under
    a dead moment `m_P` by the symmetric part of its stiffness, joints with a `lever` of 0 as if it
    were 1. There an index of 0 is no proof of stability.

    Nothing of it has derivatives: those of `platform_stiffness` are NaN. `sensitivity` has the same
    stiffness from the residual, with derivatives.
    """
    check_integer("steps", steps)
    check_fits("equilibrium", equilibrium, robot)
    found, left = _stability(robot.unnamed, equilibrium.y, steps)
    check_belongs(robot, equilibrium, left)
    given = jax.tree.leaves((robot, equilibrium.y))
    moving = [leaf for leaf in given if isinstance(leaf, jax.core.Tracer)]
    if not moving:
        return found
    return dataclasses.replace(
        found, platform_stiffness=_without_slopes(found.platform_stiffness, moving)
    )


@jax.custom_jvp
def _without_slopes(stiffness, moving):
    """A stiffness whose derivatives are not known: better NaN than the zeros of a constant."""
    return stiffness


@_without_slopes.defjvp
def _without_slopes_jvp(primals, tangents):
    unknown = jnp.nan * sum(jnp.sum(tangent) for tangent in tangents[1])
    return primals[0], unknown * jnp.ones_like(primals[0])


@brief_program
def _stability(
    robot: Robot, y: Float[Array, " n_y"], steps: int
) -> tuple[Stability, Float[Array, ""]]:
    """With the largest entry of the residual."""
    pieces = rods_in_pieces(robot, y, steps)
    tips = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -1), pieces.tip)
    left = jnp.max(jnp.abs(residual_in_world(robot, unravel(robot, y), tips)))
    return count_unstable(robot, y, pieces), left


def count_unstable(robot: Robot, y: Float[Array, " n_y"], pieces: Pieces) -> Stability:
    """`stability` at the unknowns `y`, for one configuration; not compiled by itself."""
    robot, y = jax.lax.stop_gradient((robot, y))
    geometry = robot.geometry
    d = geometry.d
    state = unravel(robot, y)
    units = scales(robot)
    pose, wrench = units.pose(robot), units.wrench(robot)
    both = units_of_variations(robot)
    orientation, n_p = robot.orientation(state.q_p), robot.n_p

    def levers(arm, force):
        turned = geometry.lever(arm, force) / (units.force * units.length)
        return jnp.zeros((pose.size, pose.size)).at[d:, d:].set(turned)[:n_p, :n_p]

    def one(leg: Leg, q, mu, tangents, by_base, tip: RodState):
        index, carried = _free_end_index(geometry, tangents)
        eye = jnp.eye(mu.size)
        if leg.base_joint is None:
            flexibility = _flexibility(*jnp.split(by_base[:, geometry.r :], 2))
            K = inverse_with_sign(flexibility + _SOFTENING * eye)[0]
        else:
            begin, slides, added = released_base(geometry, leg, q, mu, both, carried)
            index = index + added
            poses, wrenches = jnp.split(tip_of(geometry, by_base, begin), 2)
            K = wrenches @ inverse_with_sign(poses + _SOFTENING * wrenches)[0]
            held = tip_of(geometry, by_base, begin + _HOLD * slides)
            flexibility = _flexibility(*jnp.split(held, 2))
        clamped = index - negative_eigenvalues(flexibility + _SOFTENING * eye)

        # Two terms of the series in what was added undo it where the rod is not straight. With
        # both, no eigenvalue changes its sign.
        added = _SOFTENING * K
        K = (K + (K + K @ added) @ added) * wrench[:, None] / pose
        b = geometry.outward(geometry.frame(tip.rotation), leg.b)
        A = eye.at[:d, d:].set(-geometry.spin(b))
        K = (A.T @ K @ A).at[d:, d:].add(geometry.lever(b, tip.force))

        # From the platform to where the joint is, which differs from its attachment by a slide.
        arm = tip.position + b - state.q_p[:d]
        follows = eye.at[:d, d:].set(geometry.spin(arm))[:, :n_p]
        frame = geometry.compose(orientation, geometry.exp(leg.attachment_rotation))
        released = leg.joint.free[d:]
        Q = axes_of(geometry, released, frame, tip.rotation)
        moment = tip.moment - geometry.moment_of(b, tip.force)
        # In the joint's axes and free of units; what is locked gets a stiffness of one.
        K_joint = (Q.T @ K @ Q) / wrench[:, None] * pose
        moves = Q.T @ follows / pose[:, None] * pose[:n_p]
        free = leg.joint.free
        turning = bent(geometry, released, Q, moment) / (units.force * units.length)
        K_inner = K_joint.at[d:, d:].add(turning)
        inner = free[:, None] * K_inner * free + jnp.diag(1.0 - free)
        work = carried_work(geometry, Q, tip.force, moment)[:, :n_p] / wrench[:, None]
        cross = free[:, None] * (K_joint @ moves + work)
        seen = moves.T @ K_joint @ moves - cross.T @ inverse_with_sign(inner)[0] @ cross
        seen = seen - levers(arm, tip.force)
        return clamped + negative_eigenvalues(inner), seen

    own = robot.legs, robot.transmission @ state.q_a, state.mu
    legs, stiffnesses = jax.vmap(one)(*own, pieces.tangents, pieces.by_base, pieces.tip)
    stiffness = jnp.sum(stiffnesses, axis=0)
    if robot.loads is not None:
        arms = load_arms(robot, robot.loads, state.q_p)
        stiffness = stiffness + jnp.sum(jax.vmap(levers)(arms, robot.loads.force), axis=0)
    index = jnp.sum(legs) + negative_eigenvalues(0.5 * (stiffness + stiffness.T))
    known = jnp.all(jnp.isfinite(stiffness))
    si = stiffness * wrench[:n_p, None] / pose[:n_p]
    return Stability(jnp.where(known, index, -1), jnp.where(known, legs, -1), si)


def _flexibility(poses, wrenches):
    """`∂(p, φ)/∂(n, m)` from the tangents of both."""
    flexibility = poses @ inverse_with_sign(wrenches)[0]
    return 0.5 * (flexibility + flexibility.T)


def _free_end_index(geometry: AbstractGeometry, pieces):
    """Index of a rod that dead loads hold at its tip, and its stiffness against turns of its base.

    From the tip to the base, one piece after the other is added to what it carries, of which
    only the stiffness against turns `P` is not zero. With the flexibility A of the piece the
    new joint between both adds the negative eigenvalues of `A⁻¹ + P`.
    """
    d, r = geometry.d, geometry.r
    f = d + r

    def backward(carried, piece):
        turn_by_turn, turn_by_moment = piece[d:f, :r], piece[d:f, f:]
        moment_by_turn, moment_by_moment = piece[f + d :, :r], piece[f + d :, f:]
        flexibility = turn_by_moment @ inverse_with_sign(moment_by_moment)[0]
        flexibility = 0.5 * (flexibility + flexibility.T) + _SOFTENING * jnp.eye(r)
        count = negative_eigenvalues(inverse_with_sign(flexibility)[0] + carried)
        held = inverse_with_sign(moment_by_moment + carried @ turn_by_moment)[0]
        stiffness = held @ (moment_by_turn + carried @ turn_by_turn)
        return 0.5 * (stiffness + stiffness.T), count

    carried, counts = jax.lax.scan(backward, jnp.zeros((r, r)), pieces, reverse=True)
    return jnp.sum(counts), carried
