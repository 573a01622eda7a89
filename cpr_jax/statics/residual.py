"""The residual R(y, ρ): platform equilibrium (3), joints (4), imposed coordinates (15)."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..geometry import AbstractGeometry, Components, as_array
from ..robots.joint import BaseJoint
from ..robots.leg import Leg
from ..robots.robot import PointLoads, Robot
from ..rods.equations import RodState
from ..rods.integration import DEFAULT_STEPS, rod_tip
from ..rods.rod import Rod
from ..rods.segments import loads_inward
from ..rods.solver import Steps
from .unknowns import State, scales


class Units(NamedTuple):
    """Units of the dimensionless rows: of wrenches and of motions, `(d + r,)`."""

    wrench: Float[Array, "freedoms *lanes"]
    pose: Float[Array, "freedoms *lanes"]


def units_of(robot: Robot) -> Units:
    """Those that belong to `scales(robot)`."""
    return Units(scales(robot).wrench(robot), scales(robot).pose(robot))


class LegBase(NamedTuple):
    """A leg's rod in the axes of its base, and where that base is.

    **Attributes:**

    - `position`, `rotation`: of the rod's first cross-section in world axes.
    - `motor`: position of the motor's axis in world axes.
    - `joint`: position of the passive joint, or again of the motor's axis.
    - `rod`: with its fed length and its load turned into the axes of the base.
    - `force`, `moment`: `n(0)` and `m(0)` in the axes of the base.
    """

    position: Float[Array, " d"]
    rotation: Components
    motor: Float[Array, " d"]
    joint: Float[Array, " d"]
    rod: Rod
    force: Float[Array, " d"]
    moment: Float[Array, " r"]


def leg_base(
    geometry: AbstractGeometry,
    leg: Leg,
    q: Float[Array, ""],
    mu: Float[Array, " freedoms"],
) -> LegBase:
    """Actuator, passive joint and rigid segment a: `p_i(0) = motor + R(q) a`."""
    d = geometry.d
    mounted = geometry.exp(leg.base_rotation)
    rotation = mounted
    if leg.turns:
        rotation = geometry.compose(mounted, geometry.exp(leg.screw[d:] * q))
    slide = geometry.outward(geometry.frame(mounted), leg.screw[:d] * q)
    joint = motor = leg.base_position + slide
    force, moment = mu[:d], mu[d:]
    if leg.base_joint is not None:
        joint, rotation, force, moment = _released(geometry, leg.base_joint, motor, rotation, mu)
    a = leg.a if leg.stroke is None else leg.a + leg.stroke * q
    frame = geometry.frame(rotation)
    arm = geometry.outward(frame, a)
    position = joint + arm
    if leg.base_joint is not None:
        # The unknowns belong to the joint, the rod begins behind its rigid segment.
        moment = moment - geometry.moment_of(arm, force)
    return LegBase(
        position=position,
        rotation=rotation,
        motor=motor,
        joint=joint,
        rod=rod_from(geometry, frame, leg, q),
        force=geometry.inward(frame, force),
        moment=geometry.moment_inward(frame, moment),
    )


def rod_from(geometry: AbstractGeometry, frame, leg: Leg, q: Float[Array, ""]) -> Rod:
    """A leg's rod with its fed length, and with its loads in the axes of a frame."""
    rod = leg.rod
    return Rod(
        length=rod.length if leg.feed is None else rod.length + leg.feed * q,
        curvature_compliance=rod.curvature_compliance,
        precurvature=rod.precurvature,
        strain_compliance=rod.strain_compliance,
        force=None if rod.force is None else geometry.inward(frame, rod.force),
        moment=None if rod.moment is None else geometry.moment_inward(frame, rod.moment),
        further=None if rod.further is None else loads_inward(geometry, frame, rod.further),
    )


def _released(geometry: AbstractGeometry, joint: BaseJoint, motor, carrier, mu):
    """A passive joint on its carrier: its place, the leg's rotation, force and moment there.

    Of the unknowns `mu` those in free directions are motions of the joint, m and rad, the others
    the components of the wrench along and about its axes.
    """
    d = geometry.d
    slides, turns = joint.free[:d], joint.free[d:]
    outer = geometry.compose(carrier, geometry.exp(joint.rotation))
    frame = geometry.frame(outer)
    place = motor + geometry.outward(geometry.frame(carrier), joint.position)
    place = place + geometry.outward(frame, slides * mu[:d])
    later = geometry.later(turns)
    turned = geometry.compose(outer, geometry.exp((1.0 - later) * turns * mu[d:]))
    rotation = geometry.compose(turned, geometry.exp(later * turns * mu[d:]))
    force = geometry.outward(frame, (1.0 - slides) * mu[:d])
    axes = geometry.joint_axes(turns, frame, geometry.frame(rotation))
    return place, rotation, force, jnp.sum(axes * (1.0 - turns) * mu[d:], axis=1)


def base_wrench(geometry: AbstractGeometry, base: LegBase) -> Float[Array, " freedoms"]:
    """`n(0)` and `m(0)` in world axes."""
    frame = geometry.frame(base.rotation)
    moment = geometry.moment_outward(frame, base.moment)
    return jnp.concatenate([geometry.outward(frame, base.force), moment])


def to_world(geometry: AbstractGeometry, base: LegBase, state: RodState) -> RodState:
    """A rod's state, given in the axes of its base, in world axes."""
    frame = geometry.frame(base.rotation)
    return RodState(
        position=base.position + geometry.outward(frame, state.position),
        rotation=as_array(geometry.compose(base.rotation, state.rotation)),
        force=geometry.outward(frame, state.force),
        moment=geometry.moment_outward(frame, state.moment),
    )


def leg_rows(robot: Robot, units: Units, steps: Steps, leg: Leg, q, q_p, mu):
    """A leg's joint rows, dimensionless, and the wrench that it takes from the platform at p_P.

    Arrays may have further axes behind their components, for many legs and many cases at once.
    """
    base = leg_base(robot.geometry, leg, q, mu)
    tip = rod_tip(robot.geometry, base.rod, base.force, base.moment, steps)
    return closing_rows(robot, units, leg, base, tip, q_p)


def closing_rows(robot: Robot, units: Units, leg: Leg, base: LegBase, tip: RodState, q_p):
    """As `leg_rows`, of a rod whose tip is known in the axes of its base."""
    return joint_rows(robot, units, leg, to_world(robot.geometry, base, tip), q_p)


def joint_rows(robot: Robot, units: Units, leg: Leg, tip: RodState, q_p):
    """As `leg_rows`, of a rod whose tip is known in world axes."""
    geometry = robot.geometry
    d = geometry.d
    section = geometry.frame(tip.rotation)
    b = geometry.outward(section, leg.b)
    end = tip.position + b
    turned = geometry.moment_of(b, tip.force)

    orientation = robot.orientation(q_p)
    arm = geometry.outward(geometry.frame(orientation), leg.attachment_position)
    rotation = geometry.compose(orientation, geometry.exp(leg.attachment_rotation))
    frame = geometry.frame(rotation)
    gap = geometry.inward(frame, q_p[:d] + arm - end)
    released = leg.joint.free[d:]
    # At a point, which has no orientation to keep, all joints are free to turn.
    turn = jnp.zeros_like(tip.moment)
    if robot.oriented:
        seen = geometry.compose(geometry.inverse(tip.rotation), rotation)
        turn = geometry.misalignment(released, seen)
    error = jnp.concatenate([gap, turn])

    axes = geometry.joint_axes(released, frame, section)
    about = jnp.sum(axes * (tip.moment - leg.joint.lever * turned)[:, None], axis=0)
    transmitted = jnp.concatenate([geometry.inward(frame, tip.force), about])
    rows = jnp.where(leg.joint.free > 0.5, transmitted / units.wrench, error / units.pose)
    # A joint that slides takes the wrench along, away from its attachment.
    slid = geometry.outward(frame, leg.joint.free[:d] * gap)
    carried = geometry.moment_of(arm - slid, tip.force)
    return rows, jnp.concatenate([tip.force, tip.moment - turned + carried])


def residual(
    robot: Robot, state: State, steps: Steps = DEFAULT_STEPS
) -> Float[Array, " n_y_minus_n_a"]:
    """`R₀(y, ρ)`: every row of R but the imposed ones, in units of `scales(robot)`.

    Rows: equilibrium of the platform `f_P - Σ n_i(l_i)` (and, for a body, of its moments about
    `p_P`); then for each leg its joint, see `Joint`: `p_P - p_i(l_i) - R_i(l_i) b_i` and the
    moment at the pivot, `m(l_i) - R_i(l_i) b_i × n(l_i)`, for the legs of (15).
    """
    units, (legs, q, mu) = units_by_leg(robot), by_leg(robot, state)
    rows, wrenches = leg_rows(robot, units, steps, legs, q, state.q_p[:, None], mu)
    return assembled(robot, state, rows, wrenches)


def residual_at(robot: Robot, state: State, tips: RodState) -> Float[Array, " n_y_minus_n_a"]:
    """As `residual`, where the tips of the rods are known.

    **Arguments:**

    - `tips`: in the axes of the rods' bases, stacked by leg along a first axis.
    """
    legs, q, mu = by_leg(robot, state)
    base = leg_base(robot.geometry, legs, q, mu)
    tips = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -1), tips)
    return residual_in_world(robot, state, to_world(robot.geometry, base, tips))


def residual_in_world(robot: Robot, state: State, tips: RodState) -> Float[Array, " n_y_minus_n_a"]:
    """As `residual_at`, of tips in world axes, with the legs as their last axis."""
    legs, *_ = by_leg(robot, state)
    rows = joint_rows(robot, units_by_leg(robot), legs, tips, state.q_p[:, None])
    return assembled(robot, state, *rows)


def units_by_leg(robot: Robot) -> Units:
    """`units_of` for arrays of all legs."""
    return Units(*(unit[:, None] for unit in units_of(robot)))


def by_leg(
    robot: Robot, state: State
) -> tuple[Leg, Float[Array, " n"], Float[Array, "freedoms n"]]:
    """All legs, their motor positions and their unknowns, with the legs as the last axis."""
    legs = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -1), robot.legs)
    return legs, robot.transmission @ state.q_a, state.mu.T


def assembled(
    robot: Robot,
    state: State,
    rows: Float[Array, "freedoms n"],
    wrenches: Float[Array, "freedoms n"],
) -> Float[Array, " n_y_minus_n_a"]:
    """`R₀` from what `leg_rows` says of all legs."""
    load = platform_load(robot, state.q_p)
    balance = (load - jnp.sum(wrenches, axis=-1)) / units_of(robot).wrench
    return jnp.concatenate([balance[: robot.n_p], rows.T.reshape(-1)])


def platform_load(robot: Robot, q_p: Float[Array, "n_p *lanes"]) -> Float[Array, "freedoms *lanes"]:
    """Wrench of all loads on the platform, at `p_P`."""
    geometry, force, moment = robot.geometry, robot.f_P, robot.m_P
    if robot.loads is not None:
        forces = jnp.moveaxis(robot.loads.force, 0, 1)
        arms = jnp.moveaxis(load_arms(robot, robot.loads, q_p), 0, 1)
        force = force + jnp.sum(forces, axis=1)
        moment = moment + jnp.sum(geometry.moment_of(arms, forces), axis=1)
    lanes = jnp.broadcast_shapes(force.shape[1:], moment.shape[1:])
    return jnp.concatenate([jnp.broadcast_to(a, (len(a), *lanes)) for a in (force, moment)])


def load_arms(
    robot: Robot, loads: PointLoads, q_p: Float[Array, "n_p *lanes"]
) -> Float[Array, "k d *lanes"]:
    """From `p_P` to where the forces act, world axes."""
    geometry = robot.geometry
    frame = geometry.frame(robot.orientation(q_p))
    return jax.vmap(lambda place: geometry.outward(frame, place))(loads.position)
