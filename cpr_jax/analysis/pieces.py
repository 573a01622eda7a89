"""Rods cut into pieces: how the state at the end of each answers to that at its start."""

import dataclasses
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..geometry import AbstractGeometry
from ..robots.leg import Leg
from ..robots.robot import Robot
from ..rods.equations import RodState
from ..rods.integration import rod_tip
from ..rods.rod import Rod
from ..rods.segments import segments_of
from ..statics.residual import (
    LegBase,
    assembled,
    base_wrench,
    joint_rows,
    leg_base,
    to_world,
    units_of,
)
from ..statics.unknowns import unknown_scales, unravel


class Pieces(NamedTuple):
    """The rods of a robot in pieces, stacked by leg along a first axis, in world axes.

    States are varied by `(p, φ, n, m)`, in units of `scales(robot)`. In space moments are taken
    with half the turn of their axes, `δm - ½ δφ × m`: position and momentum in this sense are
    conjugate, so that flexibilities are symmetric.

    **Attributes:**

    - `tangents`: of each piece those at its end by `(φ, n, m)` at its start, the start's position
        held, `(n, pieces, 2 (d + r), d + 2 r)`.
    - `along`: of the tips by the motor position of the leg, in SI units, and by its μ, in units of
        their own, `(n, 2 (d + r), 1 + d + r)`.
    - `nodes`: the states at both ends of all pieces, from base to tip.
    - `tip`: the last of them.
    """

    tangents: Float[Array, "n pieces both ways"]
    along: Float[Array, "n both own"]
    nodes: RodState
    tip: RodState


def rods_in_pieces(robot: Robot, y: Float[Array, " n_y"], steps: int) -> Pieces:
    """Cuts each segment of each rod into `steps` pieces, at unknowns in SI units.

    Not differentiated.
    """
    robot, y = jax.lax.stop_gradient((robot, y))
    geometry = robot.geometry
    state = unravel(robot, y)
    units = units_of(robot)
    both = jnp.concatenate([units.pose, units.wrench])
    scale = unravel(robot, unknown_scales(robot)).mu

    def one(leg: Leg, q, mu, scale):
        base = leg_base(geometry, leg, q, mu)
        tangents, growths, nodes, tip = _cut(geometry, leg, base, steps)
        tangents = tangents / both[:, None] * both[geometry.d :]
        begin = _of_the_base(geometry, leg, base, q, mu) / both[:, None]
        begin = begin * jnp.concatenate([jnp.ones(1), scale])
        grown = None if growths is None else growths / both
        return Pieces(tangents, to_tip(geometry, tangents, begin, grown), nodes, tip)

    return jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu, scale)


def to_tip(
    geometry: AbstractGeometry,
    tangents: Float[Array, "pieces both ways"],
    begin: Float[Array, "both k"],
    grown: Float[Array, "pieces both"] | None = None,
) -> Float[Array, "both k"]:
    """Tangents of the tip of a rod whose base has the tangents `begin`.

    **Arguments:**

    - `grown`: what the first of these adds at the end of each piece.
    """

    def forward(now, piece):
        tangent, added = piece
        # Written out: a product of small matrices for each case of a batch is a call each.
        moved = jnp.sum(tangent[:, :, None] * now[geometry.d :], axis=1)
        moved = moved.at[: geometry.d].add(now[: geometry.d])
        return moved if added is None else moved.at[:, 0].add(added), None

    return jax.lax.scan(forward, begin, (tangents, grown))[0]


def jacobian(robot: Robot, y: Float[Array, " n_y"], pieces: Pieces) -> Float[Array, "n_r n_y"]:
    """Derivative of `R₀` in the dimensionless unknowns, from the pieces of the rods."""
    geometry = robot.geometry
    f = geometry.freedoms
    units, by_unknown = units_of(robot), unknown_scales(robot)
    both = jnp.concatenate([units.pose, units.wrench])
    q_p = unravel(robot, y).q_p

    def one(leg: Leg, tip: RodState, along):
        def rows(change, q_p):
            p, turn, n, m = jnp.split(change * both, [geometry.d, f, f + geometry.d])
            moved = RodState(
                position=tip.position + p,
                rotation=jnp.stack(geometry.compose(geometry.exp(turn), tip.rotation)),
                force=tip.force + n,
                moment=tip.moment + m + 0.5 * geometry.bracket(turn, tip.moment),
            )
            return jnp.concatenate(joint_rows(robot, units, leg, moved, q_p))

        by_change, by_platform = jax.jacfwd(rows, argnums=(0, 1))(jnp.zeros(2 * f), q_p)
        return jnp.sum(by_change[:, :, None] * along, axis=1), by_platform

    by_own, by_platform = jax.vmap(one)(robot.legs, pieces.tip, pieces.along)

    def equations(change):
        """`R₀` but for a constant, with the rows of the legs made linear."""
        moved = change * by_unknown
        q_a, q_p, _ = unravel(robot, moved)
        own = jnp.column_stack([robot.transmission @ q_a, unravel(robot, change).mu])
        legs = jnp.sum(by_own * own[:, None], axis=2) + jnp.sum(by_platform * q_p, axis=2)
        return assembled(robot, unravel(robot, y + moved), legs[:, :f].T, legs[:, f:].T)

    return jax.jacfwd(equations)(jnp.zeros_like(y))


def _cut(geometry: AbstractGeometry, leg: Leg, base: LegBase, steps: int):
    """Tangents of the pieces, what their ends gain per motor position, their ends, and the tip."""
    d, r = geometry.d, geometry.r

    def move(change, start: RodState, segment: Rod):
        turn, n, m, stretch = jnp.split(change, [r, r + d, d + 2 * r])
        length = segment.length / steps
        rotation = geometry.compose(geometry.exp(turn), start.rotation)
        moment = start.moment + m + 0.5 * geometry.bracket(turn, start.moment)
        load, couple = segment.force, segment.moment
        rod = Rod(
            length=length if leg.feed is None else length + stretch[0],
            curvature_compliance=segment.curvature_compliance,
            precurvature=segment.precurvature,
            strain_compliance=segment.strain_compliance,
            force=None if load is None else jnp.stack(geometry.unrotate(rotation, load)),
            moment=None if couple is None else jnp.stack(geometry.to_local(rotation, couple)),
        )
        first = LegBase(
            position=start.position,
            rotation=rotation,
            motor=base.motor,
            joint=base.joint,
            rod=rod,
            force=jnp.stack(geometry.unrotate(rotation, start.force + n)),
            moment=jnp.stack(geometry.to_local(rotation, moment)),
        )
        last = to_world(geometry, first, rod_tip(geometry, rod, first.force, first.moment, 1))
        end = jax.lax.stop_gradient(last)
        return varied(geometry, last, end), end

    whole = dataclasses.replace(leg.rod, length=base.rod.length)
    segments = None
    if whole.further is not None:
        segments = jax.tree.map(lambda leaf: jnp.repeat(leaf, steps, axis=0), segments_of(whole))

    def forward(start: RodState, segment: Rod | None):
        segment = whole if segment is None else segment
        tangents, end = jax.jacfwd(move, has_aux=True)(jnp.zeros(ways), start, segment)
        return end, (tangents, end)

    ways = d + 2 * r + (leg.feed is not None)
    force, moment = jnp.split(base_wrench(geometry, base), [d])
    start = RodState(base.position, jnp.stack(base.rotation), force, moment)
    tip, (tangents, ends) = jax.lax.scan(
        forward, start, segments, length=steps if segments is None else None
    )
    nodes = jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), start, ends)
    if leg.feed is None:
        return tangents, None, nodes, tip
    # The first segment is the one that grows.
    share = jnp.where(jnp.arange(len(tangents)) < steps, leg.feed / steps, 0.0)
    return tangents[..., :-1], tangents[..., -1] * share[:, None], nodes, tip


def _of_the_base(geometry: AbstractGeometry, leg: Leg, here: LegBase, q, mu):
    """Tangents of the state where a rod begins by the leg's motor position and its μ."""

    def state(base: LegBase) -> RodState:
        force, moment = jnp.split(base_wrench(geometry, base), [geometry.d])
        return RodState(base.position, base.rotation, force, moment)

    def move(own):
        return varied(geometry, state(leg_base(geometry, leg, own[0], own[1:])), state(here))

    return jax.jacfwd(move)(jnp.concatenate([q[None], mu]))


def varied(geometry: AbstractGeometry, state: RodState, here: RodState) -> Float[Array, " both"]:
    """A state near another one as its variation, see `Pieces`, but that of the position whole."""
    turn = geometry.log(geometry.compose(state.rotation, geometry.inverse(here.rotation)))
    turn = jnp.stack(turn)
    moment = state.moment - 0.5 * geometry.bracket(turn, here.moment)
    return jnp.concatenate([state.position, turn, state.force, moment])
