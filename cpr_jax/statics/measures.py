"""Numbers that go with every equilibrium: conditioning, torques, energy."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..robots.robot import Robot
from ..rods.equations import RodState, strain_energy_density, strains
from ..rods.integration import rod_energy
from ..rods.segments import segments_of
from .accuracy import integration_errors
from .residual import base_wrench, leg_base, load_arms, residual
from .singular_values import norm_2, smallest
from .unknowns import unknown_scales, unravel


class Measures(eqx.Module):
    """What an equilibrium says beside its unknowns.

    All are differentiable once, energy and torques to any order; derivatives of dimensionless
    numbers are those with their units, `scales(robot)`, held.

    **Attributes:**

    - `sigma_t1`, `sigma_t2`: smallest singular value of `A_q = ∂R₀/∂(q_a, μ)` (platform held;
        zero at a Type 1 singularity) and of `A_p = ∂R₀/∂(q_p, μ)` (motors held; zero at a Type 2
        singularity), dimensionless. `sigma_t1` is NaN unless A_q is square.
    - `sign_t1`, `sign_t2`: signs of their determinants.
    - `condition`: condition number of `A_p`.
    - `motor_torques`: what the motors exert on the legs, N·m (N where they slide), `(n_a,)`.
    - `tip_error`: estimated error of the integration at the rods' tips, in rod lengths.
    - `unbalanced`: estimated error of the integration in `R₀`, in units of `scales(robot)`: its
        largest entry with twice the steps.
    - `energy`: total potential energy, of the rods and of dead loads, J.
    - `bows`: which way and how far each rod bows, shape `(n,)`: mean distance from the line between
        its base and its joint, over its length; in the plane positive where it bows to the left
        of the way from base to joint, in space without a sign. Their signs name a branch.
    """

    sigma_t1: Float[Array, ""]
    sigma_t2: Float[Array, ""]
    sign_t1: Float[Array, ""]
    sign_t2: Float[Array, ""]
    condition: Float[Array, ""]
    motor_torques: Float[Array, " n_a"]
    tip_error: Float[Array, ""]
    unbalanced: Float[Array, ""]
    energy: Float[Array, ""]
    bows: Float[Array, " n"]


def measure(robot: Robot, y: Float[Array, " n_y"], steps: int) -> tuple[Measures, Float[Array, ""]]:
    """The measures at the unknowns `y` of an equilibrium, and the largest entry of `R₀` there."""
    matrix, R_0 = _jacobian(robot, y, steps)
    return measures_with(robot, y, matrix, steps), jnp.max(jnp.abs(R_0))


def _jacobian(robot: Robot, y: Float[Array, " n_y"], steps: int):
    units = unknown_scales(robot)

    def rows(scaled):
        R_0 = residual(robot, unravel(robot, scaled * units), steps)
        return R_0, R_0

    return jax.jacfwd(rows, has_aux=True)(y / units)


@functools.cache
def _known(steps: int):
    """A Jacobian that is known, with the derivatives that it has as a function of its robot."""

    @jax.custom_jvp
    def known(robot, y, matrix):
        return matrix

    @known.defjvp
    def rule(primals, tangents):
        *given, matrix = primals

        def jacobian(robot, y):
            return _jacobian(robot, y, steps)[0]

        return matrix, jax.jvp(jacobian, tuple(given), tuple(tangents[:2]))[1]

    return known


def measures_with(
    robot: Robot, y: Float[Array, " n_y"], matrix: Float[Array, "n_r n_y"], steps: int
) -> Measures:
    """As `measure`, where `∂R₀/∂y` in the dimensionless unknowns is known.

    Differentiable in `robot` and `y`: the derivatives of the matrix are calculated where they are
    asked for.
    """
    matrix = _known(steps)(robot, y, matrix)
    n_a, n_q = robot.n_a, robot.n_a + robot.n_p
    A_p = matrix[:, n_a:]
    A_q = jnp.concatenate([matrix[:, :n_a], matrix[:, n_q:]], axis=1)
    sigma_t1 = sign_t1 = jnp.full((), jnp.nan)
    if A_q.shape[0] == A_q.shape[1]:
        sigma_t1, sign_t1 = smallest(A_q)
    sigma_t2, sign_t2 = smallest(A_p)
    rods = _rods(robot, y, steps)
    errors = integration_errors(robot, y, steps)
    return Measures(
        sigma_t1=sigma_t1,
        sigma_t2=sigma_t2,
        sign_t1=sign_t1,
        sign_t2=sign_t2,
        condition=norm_2(A_p) / sigma_t2,
        motor_torques=motor_torques(robot, y),
        tip_error=errors.tip,
        unbalanced=errors.unbalanced,
        energy=_energy(robot, y, rods),
        bows=_bows(robot, y, rods),
    )


def motor_torques(robot: Robot, y: Float[Array, " n_y"]) -> Float[Array, " n_a"]:
    """Work of the motors per unit of their motion: `τ = ∂(energy)/∂q_a`.

    A motor that feeds rod does the work `W - f·p - n·(e_1 + v) - m·u` per length, with the elastic
    energy `W` per length, the distributed load and the strains at the base.
    """
    geometry = robot.geometry
    d = geometry.d
    state = unravel(robot, y)

    def one(leg, q, mu):
        base = leg_base(geometry, leg, q, mu)
        mounted = geometry.exp(leg.base_rotation)
        arm = base.position - base.motor
        force, moment = jnp.split(base_wrench(geometry, base), [d])
        moment = moment + jnp.stack(geometry.cross(arm, force))
        wrench = jnp.stack(
            [*geometry.unrotate(mounted, force), *geometry.to_local(mounted, moment)]
        )
        torque = -leg.screw @ wrench
        if leg.stroke is not None:
            torque -= leg.stroke @ base.force
        if leg.feed is not None:
            local = RodState((0.0,) * d, geometry.identity, base.force, base.moment)
            strain, curvature = strains(geometry, local, base.rod)
            work = strain_energy_density(geometry, local, base.rod) - base.force[0]
            work -= sum(m * u for m, u in zip(base.moment, curvature, strict=True))
            if strain is not None:
                work -= sum(n * v for n, v in zip(base.force, strain, strict=True))
            if leg.rod.force is not None:
                work -= leg.rod.force @ base.position
            torque += leg.feed * work
        return torque

    q = robot.transmission @ state.q_a
    return robot.transmission.T @ jax.vmap(one)(robot.legs, q, state.mu)


class _Rods(NamedTuple):
    """Of each rod: where its base is, its length, elastic energy, integral `∫ p ds` of its
    positions, and the work `∫ f p ds` of its distributed force, component by component."""

    bases: Float[Array, "n d"]
    lengths: Float[Array, " n"]
    energies: Float[Array, " n"]
    positions: Float[Array, "n d"]
    work: Float[Array, "n d"] | None


def _rods(robot: Robot, y: Float[Array, " n_y"], steps: int) -> _Rods:
    geometry = robot.geometry
    state = unravel(robot, y)

    def one(leg, q, mu):
        base = leg_base(geometry, leg, q, mu)
        length = base.rod.length
        energy, positions = rod_energy(geometry, base.rod, base.force, base.moment, steps)
        rod, frame = leg.rod, geometry.frame(base.rotation)
        if rod.further is None:
            turned = jnp.stack(geometry.rotate(base.rotation, positions))
            positions = base.position * length + turned
            work = None if rod.force is None else rod.force * positions
            return _Rods(base.position, length, energy, positions, work)
        lengths = segments_of(base.rod).length
        turned = jax.vmap(lambda p: geometry.outward(frame, p))(positions)
        positions = base.position * lengths[:, None] + turned
        force = segments_of(rod).force
        work = None if force is None else jnp.sum(force * positions, axis=0)
        return _Rods(base.position, length, energy, jnp.sum(positions, axis=0), work)

    return jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu)


def potential_energy(robot: Robot, y: Float[Array, " n_y"], steps: int) -> Float[Array, ""]:
    """Elastic energy of the rods and potential of the dead forces, J.

    Distributed moments, and moments on a spatial body, have no potential and are left out.
    """
    return _energy(robot, y, _rods(robot, y, steps))


def energy_and_bows(
    robot: Robot, y: Float[Array, " n_y"], steps: int
) -> tuple[Float[Array, ""], Float[Array, " n"]]:
    """`potential_energy` and `Measures.bows` from one integration of the rods."""
    rods = _rods(robot, y, steps)
    return _energy(robot, y, rods), _bows(robot, y, rods)


def _energy(robot: Robot, y: Float[Array, " n_y"], rods: _Rods) -> Float[Array, ""]:
    geometry = robot.geometry
    q_p = unravel(robot, y).q_p
    energy = jnp.sum(rods.energies)
    if rods.work is not None:
        energy -= jnp.sum(rods.work)
    energy -= robot.f_P @ q_p[: geometry.d]
    if robot.loads is not None:
        points = q_p[: geometry.d] + load_arms(robot, robot.loads, q_p)
        energy -= jnp.sum(robot.loads.force * points)
    if robot.oriented and geometry.r == 1:
        energy -= robot.m_P @ q_p[geometry.d :]
    return energy


def _bows(robot: Robot, y: Float[Array, " n_y"], rods: _Rods) -> Float[Array, " n"]:
    geometry = robot.geometry
    q_p = unravel(robot, y).q_p

    def one(leg, rod: _Rods):
        arm = leg.attachment_position
        if robot.oriented:
            arm = jnp.stack(geometry.rotate(geometry.exp(q_p[geometry.d :]), arm))
        line = q_p[: geometry.d] + arm - rod.bases
        area = jnp.stack(geometry.cross(line, rod.positions / rod.lengths - rod.bases))
        size = area[0] if geometry.r == 1 else _length(area)
        return size / (_length(line) * rod.lengths)

    return jax.vmap(one)(robot.legs, rods)


def _length(vector):
    """Of a vector; where it vanishes, its derivative is taken as zero."""
    squared = jnp.sum(vector**2)
    some = squared > 0.0
    return jnp.where(some, jnp.sqrt(jnp.where(some, squared, 1.0)), 0.0)
