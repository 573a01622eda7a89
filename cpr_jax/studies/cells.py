"""Everything that a map says about one of its cells."""

import itertools
import warnings
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import jaxtyping
import numpy as np
from jaxtyping import Float, Int

from ..analysis.jacobian import linearised, names_that_vary
from ..analysis.parameters import Selection
from ..analysis.pieces import rods_in_pieces
from ..analysis.stability import count_unstable
from ..programs import program
from ..robots.robot import Robot
from ..rods.equations import RodState
from ..rods.segments import segments_of
from ..rods.solver import Scheme
from ..statics.accuracy import ROUGH
from ..statics.energy import Rods, bows_of, integrated, total_energy
from ..statics.linear import inverse_with_sign, row_axes
from ..statics.measures import motor_torques
from ..statics.residual import by_leg, leg_base, residual_in_world, to_world
from ..statics.roots import TOLERANCE
from ..statics.singular_values import evenness, norm_2
from ..statics.turns import has_rotation_vector, motion_jacobian
from ..statics.unknowns import unknown_scales, unravel

_POLISHED = 3
"""How often a cell is looked at again, each time a step of Newton's method further."""

_FINER = 12, 8
"""Order and least substeps of half as many steps: as much work as usual ones, and more accurate."""

Array: TypeAlias = jaxtyping.Array | np.ndarray


class Cell(NamedTuple):
    """Numbers of one equilibrium; in a map, of all cells along a first axis (SI units).

    **Attributes:**

    - `q_a`, `q_p`, `mu`, `motor_torques`, `energy`, `bows`, `sigma_t1`, `sigma_t2`, `sign_t2`: as
        in `Equilibrium` and `Measures`.
    - `Pi_p`: `∂q_p/∂ρ` with the motors held, shape `(n_p, n_ρ)`.
    - `semi_axes`, `directions`: of the uncertainty ellipsoid of the position, largest first.
    - `manipulability`: `√det(J Jᵀ)` of `J = ∂p_P/∂q_a`; `manipulability_condition`: smallest
        over largest singular value of J, 1 where the platform moves alike in all directions.
    - `curvature`, `moment`: largest curvature, 1/m, and internal moment, N·m, along the rods.
    - `unstable`: number of unstable directions, see `stability`.
    - `residual`: largest entry of the dimensionless `R₀`, before a last step of Newton's method.
    - `tip_error`: estimated error of the integration at the rods' tips, in rod lengths: by how much
        half as many steps of order 12 end elsewhere. It tells the order of magnitude.
    """

    q_a: Float[Array, " n_a"]
    q_p: Float[Array, " n_p"]
    mu: Float[Array, "n freedoms"]
    motor_torques: Float[Array, " n_a"]
    energy: Float[Array, ""]
    bows: Float[Array, " n"]
    sigma_t1: Float[Array, ""]
    sigma_t2: Float[Array, ""]
    sign_t2: Float[Array, ""]
    Pi_p: Float[Array, "n_p n_rho"]
    semi_axes: Float[Array, " d"]
    directions: Float[Array, "d d"]
    manipulability: Float[Array, ""]
    manipulability_condition: Float[Array, ""]
    curvature: Float[Array, ""]
    moment: Float[Array, ""]
    unstable: Int[Array, ""]
    residual: Float[Array, ""]
    tip_error: Float[Array, ""]


@program
def look_at_cells(
    robot: Robot,
    selection: Selection,
    delta: Float[Array, " n_rho"],
    y: Float[Array, "cells n_y"],
    imposed: tuple[int, ...],
    steps: int,
) -> Cell:
    """The numbers of many equilibria, from their unknowns in SI units.

    What is returned of the unknowns is a Newton step further, with the coordinates at the places
    `imposed` of `(q_a, q_p)` held.
    """
    return jax.vmap(lambda y: _look(robot, selection, delta, y, imposed, steps))(y)


def _look(robot: Robot, selection: Selection, delta, y, imposed, steps: int) -> Cell:
    units = unknown_scales(robot)
    n_a, n_p = robot.n_a, robot.n_p
    n_q = n_a + n_p
    d = robot.geometry.d

    pieces = rods_in_pieces(robot, y, steps, names_that_vary(robot, selection))
    by_y, by_rho = linearised(robot, y, selection, pieces)
    A_p = by_y[:, n_a:]
    free = free_runs(robot, imposed)
    A_q = jnp.concatenate([by_y[:, run] for run in free], axis=1)
    # As a batch of two they share their compiled code.
    (inverse_q, inverse_p), (_, sign_t2) = jax.vmap(inverse_with_sign)(jnp.stack([A_q, A_p]))
    by_motion = inverse_p
    if has_rotation_vector(robot):
        motion = motion_jacobian(robot, y[n_a:n_q])
        by_motion = inverse_p.at[:n_p].set(motion @ inverse_p[:n_p])
    sigma_t1, sigma_t2 = 1.0 / jax.vmap(norm_2)(jnp.stack([inverse_q, by_motion]))
    answers = -inverse_p[:n_p] @ jnp.concatenate([by_rho, by_y[:, :n_a]], axis=1)
    answers = answers * units[n_a:n_q, None]
    Pi_p, J = answers[:, : delta.size], answers[:d, delta.size :] / units[:n_a]
    semi_axes, directions = row_axes(Pi_p[:d] * delta)
    stretch, _ = row_axes(J)
    tips = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -1), pieces.tip)
    R_0 = residual_in_world(robot, unravel(robot, y), tips)
    rods = integrated(robot, y, Scheme((steps + 1) // 2, *_FINER))
    error = _tip_error(robot, y, tips, rods)
    energy, bows = total_energy(robot, y, rods), bows_of(robot, y, rods)
    counted = count_unstable(robot, y, pieces)
    curvature, moment = _strongest(robot, pieces.nodes)
    moved = -(inverse_q @ R_0) * jnp.concatenate([units[run] for run in free])
    for run in free:
        y, moved = y.at[run].add(moved[: run.stop - run.start]), moved[run.stop - run.start :]
    state = unravel(robot, y)
    return Cell(
        q_a=state.q_a,
        q_p=state.q_p,
        mu=state.mu,
        motor_torques=motor_torques(robot, y),
        energy=energy,
        bows=bows,
        sigma_t1=sigma_t1,
        sigma_t2=sigma_t2,
        sign_t2=sign_t2,
        Pi_p=Pi_p,
        semi_axes=semi_axes,
        directions=directions,
        manipulability=jnp.prod(stretch),
        manipulability_condition=evenness(stretch),
        curvature=curvature,
        moment=moment,
        unstable=counted.index,
        residual=jnp.max(jnp.abs(R_0)),
        tip_error=error,
    )


def _tip_error(robot: Robot, y, tips: RodState, finer: Rods) -> Float[Array, ""]:
    """Largest distance between tips in world axes, the legs last, and those of other steps."""
    legs, q, mu = by_leg(robot, unravel(robot, y))
    base = leg_base(robot.geometry, legs, q, mu)
    other = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -1), finer.tips)
    apart = to_world(robot.geometry, base, other).position - tips.position
    return jnp.max(jnp.abs(apart) / finer.lengths)


def polished(look: Callable[[Float[np.ndarray, "some n_y"], int], Cell], cells: Cell) -> Cell:
    """Cells of which those that are not solved well enough were looked at again.

    **Arguments:**

    - `look`: at unknowns in SI units, and how often that was done before.
    - `cells`: arrays of numpy, which are changed.
    """
    for turn in range(_POLISHED):
        rough = np.flatnonzero(~(cells.residual < TOLERANCE))
        if len(rough) == 0:
            break
        mu = cells.mu[rough].reshape(len(rough), -1)
        better = np.concatenate([cells.q_a[rough], cells.q_p[rough], mu], axis=1)
        for leaf, part in zip(cells, look(better, turn), strict=True):
            leaf[rough] = part
    return cells


def warn_of_steps(tip_error: np.ndarray, steps: int) -> None:
    """Says so, to whoever called the caller, where rods take more integration steps than they have.

    **Arguments:**

    - `tip_error`: see `Cell`; NaN where there is no equilibrium.
    """
    worst = np.max(tip_error, initial=0.0, where=np.isfinite(tip_error))
    if worst > ROUGH:
        warnings.warn(
            f"With {steps} integration steps the tips of rods are off by up to {worst:.1g} rod "
            "lengths: give more `steps`, or leave out what the variable `tip_error` tells of.",
            UserWarning,
            stacklevel=3,
        )


def free_runs(robot: Robot, imposed: tuple[int, ...]) -> list[slice]:
    """Contiguous parts of y that remain free when some coordinates are imposed."""
    ends = [-1, *sorted(imposed), robot.n_y]
    runs = [slice(a + 1, b) for a, b in itertools.pairwise(ends)]
    return [run for run in runs if run.stop > run.start]


def _strongest(robot: Robot, nodes: RodState):
    """Largest curvature and largest internal moment at nodes along the rods."""
    geometry = robot.geometry

    def one(rod, rotation, moment):
        def at(rotation, moment):
            local = geometry.moment_inward(geometry.frame(rotation), moment)
            curved = rod.curvature_compliance * local + rod.precurvature
            return jnp.sqrt(jnp.sum(curved**2)), jnp.sqrt(jnp.sum(local**2))

        return jax.tree.map(jnp.max, jax.vmap(at)(rotation, moment))

    def segmented(rod, rotation, moment):
        # Where two segments meet the curvature jumps: that node is one of both.
        count = rod.further.length.size + 1
        steps = (len(moment) - 1) // count
        ends = steps * jnp.arange(count)[:, None] + jnp.arange(steps + 1)
        both = jax.vmap(one)(segments_of(rod), rotation[ends], moment[ends])
        return jax.tree.map(jnp.max, both)

    look = one if robot.legs.rod.further is None else segmented
    both = jax.vmap(look)(robot.legs.rod, nodes.rotation, nodes.moment)
    return jax.tree.map(jnp.max, both)
