"""What is integrated along all rods of a configuration: energy, how they bow, their tips."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..robots.robot import Robot
from ..rods.equations import RodState
from ..rods.integration import rod_energy
from ..rods.segments import segments_of
from ..rods.solver import Steps
from .residual import leg_base, load_arms
from .unknowns import unravel


class Rods(NamedTuple):
    """Of each rod, stacked along a first axis.

    **Attributes** (SI units, world axes):

    - `bases`: where it begins, `(n, d)`.
    - `lengths`, `energies`: its length and its elastic energy, `(n,)`.
    - `positions`: `∫ p ds`, `(n, d)`.
    - `work`: of its distributed force, `∫ f p ds` component by component, `(n, d)`, if it has one.
    - `tips`: in the axes of the base.
    """

    bases: Float[Array, "n d"]
    lengths: Float[Array, " n"]
    energies: Float[Array, " n"]
    positions: Float[Array, "n d"]
    work: Float[Array, "n d"] | None
    tips: RodState


def integrated(robot: Robot, y: Float[Array, " n_y"], steps: Steps) -> Rods:
    """The rods at unknowns `y` in SI units."""
    geometry = robot.geometry
    state = unravel(robot, y)

    def one(leg, q, mu):
        base = leg_base(geometry, leg, q, mu)
        length = base.rod.length
        energy, positions, tip = rod_energy(geometry, base.rod, base.force, base.moment, steps)
        rod, frame = leg.rod, geometry.frame(base.rotation)
        if rod.further is None:
            positions = base.position * length + geometry.outward(frame, positions)
            work = None if rod.force is None else rod.force * positions
            return Rods(base.position, length, energy, positions, work, tip)
        lengths = segments_of(base.rod).length
        turned = jax.vmap(lambda p: geometry.outward(frame, p))(positions)
        positions = base.position * lengths[:, None] + turned
        force = segments_of(rod).force
        work = None if force is None else jnp.sum(force * positions, axis=0)
        return Rods(base.position, length, energy, jnp.sum(positions, axis=0), work, tip)

    return jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu)


def potential_energy(robot: Robot, y: Float[Array, " n_y"], steps: Steps) -> Float[Array, ""]:
    """Elastic energy of the rods and potential of the dead forces, J.

    Distributed moments, and `m_P` on a body in space, have no potential and are left out.
    """
    return total_energy(robot, y, integrated(robot, y, steps))


def total_energy(robot: Robot, y: Float[Array, " n_y"], rods: Rods) -> Float[Array, ""]:
    """As `potential_energy`, of rods that are integrated."""
    geometry = robot.geometry
    q_p = unravel(robot, y).q_p
    energy = jnp.sum(rods.energies)
    if rods.work is not None:
        energy -= jnp.sum(rods.work)
    energy -= robot.f_P @ q_p[: geometry.d]
    if robot.loads is not None:
        points = q_p[: geometry.d] + load_arms(robot, robot.loads, q_p)
        energy -= jnp.sum(robot.loads.force * points)
    return energy + geometry.potential(robot.m_P, robot.turn(q_p))


def bows_of(robot: Robot, y: Float[Array, " n_y"], rods: Rods) -> Float[Array, " n"]:
    """`Measures.bows`."""
    geometry = robot.geometry
    q_p = unravel(robot, y).q_p
    platform = geometry.frame(robot.orientation(q_p))

    def one(leg, rod: Rods):
        arm = geometry.outward(platform, leg.attachment_position)
        line = q_p[: geometry.d] + arm - rod.bases
        area = geometry.moment_of(line, rod.positions / rod.lengths - rod.bases)
        return geometry.magnitude(area) / (_length(line) * rod.lengths)

    return jax.vmap(one)(robot.legs, rods)


def _length(vector):
    """Of a vector; where it vanishes, its derivative is taken as zero."""
    squared = jnp.sum(vector**2)
    some = squared > 0.0
    return jnp.where(some, jnp.sqrt(jnp.where(some, squared, 1.0)), 0.0)
