"""The unknowns y = (q_a, q_p, μ): packing, scales, labels."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..robots.robot import Robot


class State(NamedTuple):
    """The unknowns of a robot in SI units.

    **Attributes:**

    - `q_a`: motor positions, rad or m, shape `(n_a,)`.
    - `q_p`: platform position in world axes, m, then for a body its rotation vector, rad.
    - `mu`: `n(0)`, N, and `m(0)`, N·m, at the base of each rod in world axes, `(n, d + r)`.
    """

    q_a: Float[Array, " n_a"]
    q_p: Float[Array, " n_p"]
    mu: Float[Array, "n freedoms"]


class Scales(NamedTuple):
    """Units in which a robot's unknowns and residual are of the order of one."""

    length: Float[Array, ""]
    force: Float[Array, ""]

    def wrench(self, robot: Robot) -> Float[Array, " freedoms"]:
        """Units of a wrench: forces, then moments."""
        d, r = robot.geometry.d, robot.geometry.r
        return jnp.concatenate(
            [jnp.full(d, 1.0) * self.force, jnp.full(r, 1.0) * self.force * self.length]
        )

    def pose(self, robot: Robot) -> Float[Array, " freedoms"]:
        """Units of a motion: translations, then rotations."""
        d, r = robot.geometry.d, robot.geometry.r
        return jnp.concatenate([jnp.full(d, 1.0) * self.length, jnp.ones(r)])

    def motors(self, robot: Robot) -> Float[Array, " n_a"]:
        """Units of the motor positions: 1 rad for what turns, the length for what slides."""
        turns = jnp.any(robot.legs.screw[:, robot.geometry.d :] != 0.0, axis=-1)
        turned = jnp.abs(robot.transmission).T @ turns.astype(float) > 0.0
        return jnp.where(turned, 1.0, self.length)


def scales(robot: Robot) -> Scales:
    """Mean rod length, and the force `k_b / l²` that bends a rod by about 1 rad."""
    # Units are a choice, not physics: no derivative goes through them.
    rod = jax.lax.stop_gradient(robot.legs.rod)
    length = jnp.mean(rod.length)
    return Scales(length, 1.0 / (jnp.mean(rod.curvature_compliance[:, -1]) * length**2))


def unknown_scales(robot: Robot) -> Float[Array, " n_y"]:
    """The unit of each entry of the flat y."""
    units = scales(robot)
    wrench = jnp.broadcast_to(units.wrench(robot), (robot.n, robot.geometry.freedoms))
    return jnp.concatenate(
        [units.motors(robot), units.pose(robot)[: robot.n_p], wrench.reshape(-1)]
    )


def ravel(state: State) -> Float[Array, " n_y"]:
    """The flat y = (q_a, q_p, μ_1, …, μ_n)."""
    return jnp.concatenate([state.q_a, state.q_p, state.mu.reshape(-1)])


def unravel(robot: Robot, y: Float[Array, " n_y"]) -> State:
    """Inverse of `ravel`."""
    q_a, q_p, mu = jnp.split(y, [robot.n_a, robot.n_a + robot.n_p])
    return State(q_a, q_p, mu.reshape(robot.n, robot.geometry.freedoms))


def unknown_labels(robot: Robot) -> tuple[str, ...]:
    """Label of each entry of the flat y; motors and legs count from 1."""
    geometry = robot.geometry
    platform = [f"p_P_{axis}" for axis in geometry.axes]
    if robot.oriented:
        platform += [f"phi_P_{axis}" for axis in geometry.rotation_axes]
    wrenches = [
        f"{name}{i + 1}_{axis}"
        for i in range(robot.n)
        for name, axes in (("n", geometry.axes), ("m", geometry.rotation_axes))
        for axis in axes
    ]
    return (*(f"q{i + 1}" for i in range(robot.n_a)), *platform, *wrenches)


def unknown_units(robot: Robot) -> tuple[str, ...]:
    """SI unit of each entry of the flat y."""
    geometry = robot.geometry
    sliding = [bool(u) for u in _slides(robot)]
    pose = ["m"] * geometry.d + ["rad"] * geometry.r
    wrench = ["N"] * geometry.d + ["N m"] * geometry.r
    motors = ["m" if slides else "rad" for slides in sliding]
    return (*motors, *pose[: robot.n_p], *(wrench * robot.n))


def _slides(robot: Robot):
    marker = Scales(jnp.asarray(2.0), jnp.asarray(1.0))
    return marker.motors(robot) == 2.0
