"""Rods cut into pieces: how the state at the end of each answers to that at its start."""

import dataclasses
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..geometry import AbstractGeometry, as_array
from ..robots.leg import Leg
from ..robots.robot import Robot
from ..rods.equations import RodState
from ..rods.integration import rod_tip
from ..rods.rod import Rod
from ..rods.segments import segments_of
from ..statics.residual import LegBase, base_wrench, leg_base, to_world, units_of
from ..statics.unknowns import unravel


class Pieces(NamedTuple):
    """The rods of a robot in pieces, stacked by leg along a first axis, in world axes.

    States are varied by `(p, φ, n, m)`, in units of `scales(robot)`. In space moments are taken
    with half the turn of their axes, `δm - ½ δφ × m`: position and momentum in this sense are
    conjugate, so that flexibilities are symmetric.

    **Attributes:**

    - `tangents`: of each piece those at its end by `(φ, n, m)` at its start, the start's position
        held, `(n, pieces, 2 (d + r), d + 2 r)`.
    - `by_base`: those of the tip by `(φ, n, m)` at the base, `(n, 2 (d + r), d + 2 r)`.
    - `by_numbers`: those of the tip by some numbers of the segments, see `rods_in_pieces`.
    - `nodes`: the states at both ends of all pieces, from base to tip.
    - `tip`: the last of them.
    """

    tangents: Float[Array, "n pieces both ways"]
    by_base: Float[Array, "n both ways"]
    by_numbers: Float[Array, "n both numbers"]
    nodes: RodState
    tip: RodState


def rods_in_pieces(
    robot: Robot, y: Float[Array, " n_y"], steps: int, names: tuple[str, ...] = ()
) -> Pieces:
    """Cuts each segment of each rod into `steps` pieces, at unknowns in SI units.

    Not differentiated.

    **Arguments:**

    - `names`: of the attributes of rods whose tangents are wanted, too.
    """
    robot, y = jax.lax.stop_gradient((robot, y))
    geometry = robot.geometry
    d, r = geometry.d, geometry.r
    state = unravel(robot, y)
    both = units_of_variations(robot)

    def one(leg: Leg, q, mu):
        base = leg_base(geometry, leg, q, mu)
        tangents, grown, nodes, tip = _cut(geometry, leg, base, steps, names)
        tangents = tangents / both[:, None] * both[d:]
        begin = jnp.zeros((both.size, d + 2 * r + grown.shape[-1]))
        begin = begin.at[d:, : d + 2 * r].set(jnp.eye(d + 2 * r))

        def forward(now, piece):
            tangent, added = piece
            moved = tip_of(geometry, tangent, now)
            return moved.at[:, d + 2 * r :].add(added), None

        end, _ = jax.lax.scan(forward, begin, (tangents, grown / both[:, None]))
        by_base, by_numbers = jnp.split(end, [d + 2 * r], axis=1)
        return Pieces(tangents, by_base, by_numbers, nodes, tip)

    return jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu)


def tip_of(
    geometry: AbstractGeometry, tangents: Float[Array, "both ways"], begin: Float[Array, "both k"]
) -> Float[Array, "both k"]:
    """Variations at the end of a piece or of a rod, from those at its beginning."""
    # Written out: a product of small matrices for each case of a batch is a call each.
    moved = jnp.sum(tangents[:, :, None] * begin[geometry.d :], axis=1)
    return moved.at[: geometry.d].add(begin[: geometry.d])


def units_of_variations(robot: Robot) -> Float[Array, " both"]:
    """Of `(p, φ, n, m)`."""
    units = units_of(robot)
    return jnp.concatenate([units.pose, units.wrench])


def variation(geometry: AbstractGeometry, base: LegBase, here: LegBase) -> Float[Array, " both"]:
    """By how much the state where a rod begins differs from one nearby, SI units."""
    return _varied(geometry, _start(geometry, base), _start(geometry, here))


def moved_by(geometry: AbstractGeometry, change: Float[Array, " both"], here: RodState) -> RodState:
    """The state that differs from another one by a variation in SI units."""
    d, f = geometry.d, geometry.freedoms
    p, turn, n, m = jnp.split(change, [d, f, f + d])
    return RodState(
        position=here.position + p,
        rotation=as_array(geometry.compose(geometry.exp(turn), here.rotation)),
        force=here.force + n,
        moment=here.moment + m + 0.5 * geometry.bracket(turn, here.moment),
    )


def _cut(geometry: AbstractGeometry, leg: Leg, base: LegBase, steps: int, names: tuple[str, ...]):
    """Tangents of the pieces, by their starts and by numbers; all their ends; the tip."""
    d, r = geometry.d, geometry.r

    def move(change, numbers, start: RodState, segment: Rod):
        turn, n, m = jnp.split(change, [r, r + d])
        segment = dataclasses.replace(segment, **numbers)
        rotation = geometry.compose(geometry.exp(turn), start.rotation)
        frame = geometry.frame(rotation)
        moment = start.moment + m + 0.5 * geometry.bracket(turn, start.moment)
        load, couple = segment.force, segment.moment
        rod = Rod(
            length=segment.length / steps,
            curvature_compliance=segment.curvature_compliance,
            precurvature=segment.precurvature,
            strain_compliance=segment.strain_compliance,
            force=None if load is None else geometry.inward(frame, load),
            moment=None if couple is None else geometry.moment_inward(frame, couple),
        )
        first = LegBase(
            position=start.position,
            rotation=rotation,
            motor=base.motor,
            joint=base.joint,
            rod=rod,
            force=geometry.inward(frame, start.force + n),
            moment=geometry.moment_inward(frame, moment),
        )
        last = to_world(geometry, first, rod_tip(geometry, rod, first.force, first.moment, 1))
        end = jax.lax.stop_gradient(last)
        return _varied(geometry, last, end), end

    whole = dataclasses.replace(leg.rod, length=base.rod.length)
    segments, count = None, 1
    if whole.further is not None:
        segments, count = segments_of(whole), len(whole.further.length) + 1
        segments = jax.tree.map(lambda leaf: jnp.repeat(leaf, steps, axis=0), segments)

    def forward(start: RodState, segment: Rod | None):
        segment = whole if segment is None else segment
        numbers = {name: getattr(segment, name) for name in names}
        slopes = jax.jacfwd(move, argnums=(0, 1), has_aux=True)
        (tangents, by_numbers), end = slopes(jnp.zeros(d + 2 * r), numbers, start, segment)
        parts = [by_numbers[name].reshape(len(tangents), -1) for name in names]
        return end, (tangents, jnp.concatenate([tangents[:, :0], *parts], axis=1), end)

    start = _start(geometry, base)
    tip, (tangents, grown, ends) = jax.lax.scan(
        forward, start, segments, length=steps if segments is None else None
    )
    # Each piece answers to the numbers of its own segment.
    own = jnp.repeat(jnp.eye(count), steps, axis=0)
    grown = (own[:, None, :, None] * grown[:, :, None]).reshape(*grown.shape[:2], -1)
    nodes = jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), start, ends)
    return tangents, grown, nodes, tip


def _start(geometry: AbstractGeometry, base: LegBase) -> RodState:
    force, moment = jnp.split(base_wrench(geometry, base), [geometry.d])
    return RodState(base.position, as_array(base.rotation), force, moment)


def _varied(geometry: AbstractGeometry, state: RodState, here: RodState) -> Float[Array, " both"]:
    back = geometry.inverse(here.rotation)
    turn = as_array(geometry.log(geometry.compose(state.rotation, back)))
    moment = state.moment - here.moment - 0.5 * geometry.bracket(turn, here.moment)
    straight = state.position - here.position, turn, state.force - here.force, moment
    return jnp.concatenate(straight)
