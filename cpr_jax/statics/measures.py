"""Numbers that go with every equilibrium: conditioning, torques, energy."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..robots.robot import Robot
from ..rods.equations import strain_energy_density, strains
from ..rods.solver import Steps
from .accuracy import errors_between
from .energy import bows_of, integrated, total_energy
from .residual import base_wrench, leg_base, residual
from .singular_values import norm_2, smallest
from .turns import coordinate_jacobian, has_rotation_vector
from .unknowns import row_scales, scales, unknown_scales, unravel


class Measures(eqx.Module):
    """What an equilibrium says beside its unknowns.

    All are differentiable once, energy and torques to any order, dimensionless numbers with their
    units, `scales(robot)`. Estimates of errors have slopes of zero.

    **Attributes:**

    - `sigma_t1`, `sigma_t2`: smallest singular value of `A_q = ∂R₀/∂(q_a, μ)` (platform held;
        zero at a Type 1 singularity) and of `A_p = ∂R₀/∂(q_p, μ)` (motors held; zero at a Type 2
        singularity), dimensionless. `sigma_t1` is NaN unless A_q is square. Of a body in space A_p
        has derivatives by small rotations about the world axes, which do not depend on how its
        orientation is written.
    - `sign_t1`, `sign_t2`: signs of their determinants.
    - `condition`: condition number of `A_p`.
    - `motor_torques`: what the motors exert on the legs, N·m (N where they slide), `(n_a,)`.
    - `tip_error`: estimated error of the integration at the rods' tips, in rod lengths.
    - `unbalanced`: estimated error of the integration in `R₀`, in units of `scales(robot)`: its
        largest entry with twice the steps.
    - `energy`: total potential energy, of the rods and of dead loads, J. Distributed moments on
        rods, and `m_P` on a body in space, have no potential: they are not part of it, and where
        they act the torques are not its slopes.
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


def measure(
    robot: Robot, y: Float[Array, " n_y"], steps: Steps
) -> tuple[Measures, Float[Array, ""]]:
    """The measures at the unknowns `y` of an equilibrium, and the largest entry of `R₀` there."""
    matrix, R_0 = _jacobian(robot, y, steps)
    return measures_with(robot, y, matrix, steps), jnp.max(jnp.abs(R_0))


def _jacobian(robot: Robot, y: Float[Array, " n_y"], steps: Steps):
    units = unknown_scales(robot)

    def rows(scaled):
        R_0 = residual(robot, unravel(robot, scaled * units), steps)
        return R_0, R_0

    return jax.jacfwd(rows, has_aux=True)(y / units)


def _units_by_themselves(robot: Robot):
    """Ones for rows and columns of a Jacobian, with the logarithmic slopes of their units."""
    units = scales(robot, held=False)
    ones = jax.tree.map(lambda unit: unit / jax.lax.stop_gradient(unit), units)
    return row_scales(robot, ones), unknown_scales(robot, ones)


@jax.custom_jvp
def _known(robot, y, matrix, steps):
    """A Jacobian that is known, with the derivatives that it has as a function of its robot."""
    return matrix


@_known.defjvp
def _known_jvp(primals, tangents):
    robot, y, matrix, steps = primals

    def jacobian(robot, y):
        rows, columns = _units_by_themselves(robot)
        return _jacobian(robot, y, steps)[0] * columns / rows[:, None]

    return matrix, jax.jvp(jacobian, (robot, y), tuple(tangents[:2]))[1]


@jax.custom_jvp
def _known_rods(robot, y, rods, steps):
    """Integrated rods that are known, with their derivatives.

    Partial evaluation takes loops apart, and the rules of derivatives of what is in them with it:
    the derivatives are those of an integration outside of any loop.
    """
    return rods


@_known_rods.defjvp
def _known_rods_jvp(primals, tangents):
    robot, y, rods, steps = primals

    def again(robot, y):
        return integrated(robot, y, steps)

    return rods, jax.jvp(again, (robot, y), tuple(tangents[:2]))[1]


def measures_with(
    robot: Robot, y: Float[Array, " n_y"], matrix: Float[Array, "n_r n_y"], steps: Steps
) -> Measures:
    """As `measure`, where `∂R₀/∂y` in the dimensionless unknowns is known.

    Differentiable in `robot` and `y`: the derivatives of the matrix are calculated where they are
    asked for.
    """
    matrix = _known(robot, y, matrix, jnp.asarray(steps))
    n_a, n_q = robot.n_a, robot.n_a + robot.n_p
    A_p = matrix[:, n_a:]
    if has_rotation_vector(robot):
        by_motion = A_p[:, : robot.n_p] @ coordinate_jacobian(robot, y[n_a:n_q])
        A_p = A_p.at[:, : robot.n_p].set(by_motion)
    A_q = jnp.concatenate([matrix[:, :n_a], matrix[:, n_q:]], axis=1)
    if A_q.shape == A_p.shape:
        # As a batch of two they share their compiled code.
        sigmas, signs = jax.vmap(smallest)(jnp.stack([A_q, A_p]))
        (sigma_t1, sigma_t2), (sign_t1, sign_t2) = sigmas, signs
    else:
        sigma_t1 = sign_t1 = jnp.full((), jnp.nan)
        sigma_t2, sign_t2 = smallest(A_p)
    # A loop over both accuracies keeps one copy of the integration in the compiled program.
    here = jax.lax.stop_gradient((robot, y))
    both = jax.lax.map(lambda count: integrated(*here, count), jnp.array([1, 2]) * steps)
    coarse, fine = (jax.tree.map(lambda leaf, k=k: leaf[k], both) for k in range(2))
    errors = errors_between(*here, coarse, fine)
    fine = _known_rods(robot, y, fine, 2 * jnp.asarray(steps))
    return Measures(
        sigma_t1=sigma_t1,
        sigma_t2=sigma_t2,
        sign_t1=sign_t1,
        sign_t2=sign_t2,
        condition=norm_2(A_p) / sigma_t2,
        motor_torques=motor_torques(robot, y),
        tip_error=errors.tip,
        unbalanced=errors.unbalanced,
        energy=total_energy(robot, y, fine),
        bows=bows_of(robot, y, fine),
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
        mounted = geometry.frame(geometry.exp(leg.base_rotation))
        arm = base.position - base.motor
        force, moment = jnp.split(base_wrench(geometry, base), [d])
        moment = moment + geometry.moment_of(arm, force)
        wrench = geometry.inward(mounted, force), geometry.moment_inward(mounted, moment)
        torque = -leg.screw @ jnp.concatenate(wrench)
        if leg.stroke is not None:
            torque -= leg.stroke @ base.force
        if leg.feed is not None:
            strain, curvature = strains(base.rod, base.force, base.moment)
            work = strain_energy_density(base.rod, base.force, base.moment) - base.force[0]
            work -= sum(m * u for m, u in zip(base.moment, curvature, strict=True))
            if strain is not None:
                work -= sum(n * v for n, v in zip(base.force, strain, strict=True))
            if leg.rod.force is not None:
                work -= leg.rod.force @ base.position
            torque += leg.feed * work
        return torque

    q = robot.transmission @ state.q_a
    return robot.transmission.T @ jax.vmap(one)(robot.legs, q, state.mu)
