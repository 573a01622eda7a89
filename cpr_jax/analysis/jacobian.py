"""Derivatives of the residual at many configurations, from the pieces of their rods."""

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..robots.leg import Leg
from ..robots.robot import Robot
from ..rods.equations import RodState
from ..rods.rod import Segments
from ..rods.segments import segments_of
from ..statics.residual import LegBase, joint_rows, leg_base, platform_load, units_of
from ..statics.unknowns import unknown_scales, unravel
from .parameters import Selection
from .pieces import Pieces, moved_by, tip_of, units_of_variations, variation


def names_that_vary(robot: Robot, selection: Selection) -> tuple[str, ...]:
    """Attributes of rods that differ where the selected numbers or the motors do."""
    ones, others = robot.legs.rod, selection.set(robot, selection.get(robot)).legs.rod

    def differ(name: str) -> bool:
        if getattr(ones, name) is not getattr(others, name):
            return True
        if ones.further is None:
            return False
        return getattr(ones.further, name) is not getattr(others.further, name)

    # Motors that feed rods vary their lengths.
    fed = robot.legs.feed is not None
    names = [field.name for field in dataclasses.fields(Segments)]
    return tuple(name for name in names if differ(name) or (fed and name == "length"))


def linearised(
    robot: Robot, y: Float[Array, " n_y"], selection: Selection, pieces: Pieces
) -> tuple[Float[Array, "n_r n_y"], Float[Array, "n_r n_rho"]]:
    """`∂R₀/∂y` by dimensionless unknowns and `∂R₀/∂ρ`, from rods in pieces.

    **Arguments:**

    - `pieces`: made with `names_that_vary` of the selection.
    """
    geometry, names = robot.geometry, names_that_vary(robot, selection)
    f, n, n_p = geometry.freedoms, robot.n, robot.n_p
    units, both, here = units_of(robot), units_of_variations(robot), unravel(robot, y)
    ways, rho = robot.transmission @ here.q_a, selection.get(robot)

    def numbers(leg: Leg, base: LegBase):
        segments = segments_of(dataclasses.replace(leg.rod, length=base.rod.length))
        count = len(segments.length)
        parts = [getattr(segments, name).reshape(count, -1) for name in names]
        return jnp.concatenate([jnp.zeros((count, 0)), *parts], axis=1).reshape(-1)

    def one(i, q, mu, by_base, by_numbers, tip: RodState):
        old = jax.tree.map(lambda leaf: leaf[i], robot.legs)
        before = leg_base(geometry, old, q, mu)

        def rows(own, rho):
            varied = selection.set(robot, rho)
            leg = jax.tree.map(lambda leaf: leaf[i], varied.legs)
            q, q_p, mu = own[0], own[1 : 1 + n_p], own[1 + n_p :]
            q = q + (varied.transmission[i] - robot.transmission[i]) @ here.q_a
            base = leg_base(geometry, leg, q, mu)
            change = variation(geometry, base, before) / both
            change = tip_of(geometry, by_base, change[:, None])[:, 0]
            grown = numbers(leg, base) - numbers(old, before)
            change = (change + jnp.sum(by_numbers * grown, axis=1)) * both
            moved = moved_by(geometry, change, tip)
            return jnp.concatenate(joint_rows(varied, units, leg, moved, q_p))

        own = jnp.concatenate([q[None], here.q_p, mu])
        return jax.jacfwd(rows, argnums=(0, 1))(own, rho)

    rods = pieces.by_base, pieces.by_numbers, pieces.tip
    by_own, by_rho = jax.vmap(one)(jnp.arange(n), ways, here.mu, *rods)
    load_by_q_p, load_by_rho = jax.jacfwd(
        lambda q_p, rho: platform_load(selection.set(robot, rho), q_p), argnums=(0, 1)
    )(here.q_p, rho)

    # Columns: motors, the platform, each leg's μ, ρ.
    blocks = by_own[:, :, None, 1 + n_p :] * jnp.eye(n)[:, None, :, None]
    motors = by_own[:, :, :1] * robot.transmission[:, None]
    columns = motors, by_own[:, :, 1 : 1 + n_p], blocks.reshape(n, 2 * f, n * f), by_rho
    legs = jnp.concatenate(columns, axis=2)
    load = jnp.zeros((f, legs.shape[2])).at[:, robot.n_a : robot.n_a + n_p].set(load_by_q_p)
    load = load.at[:, robot.n_y :].set(load_by_rho)
    balance = (load - jnp.sum(legs[:, f:], axis=0)) / units.wrench[:, None]
    slopes = jnp.concatenate([balance[:n_p], legs[:, :f].reshape(n * f, -1)])
    return slopes[:, : robot.n_y] * unknown_scales(robot), slopes[:, robot.n_y :]
