"""Small rotations of the platform beside changes of its rotation vector."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..geometry.space import series
from ..robots.robot import Robot

# Below this squared angle the series are exact to rounding, and what they replace is not.
_SMALL = 0.01


def motion_jacobian(robot: Robot, q_p: Float[Array, " n_p"]) -> Float[Array, "n_p n_p"]:
    """Displacements and small rotations about the world axes per change of `q_p`.

    The identity but for rotation vectors, whose changes turn the less the longer these are; at a
    full turn it is singular.
    """

    def factors(squared, angle):
        sinc = jnp.sin(angle) / angle
        return 2.0 * (jnp.sin(0.5 * angle) / angle) ** 2, (1.0 - sinc) / squared

    small = (1 / 2, -1 / 24, 1 / 720, -1 / 40320), (1 / 6, -1 / 120, 1 / 5040, -1 / 362880)
    return _along_vector(robot, q_p, 1.0, factors, small)


def coordinate_jacobian(robot: Robot, q_p: Float[Array, " n_p"]) -> Float[Array, "n_p n_p"]:
    """Changes of `q_p` per displacement and small rotation: the inverse of `motion_jacobian`."""

    def factors(squared, angle):
        half = 0.5 * angle
        return jnp.full_like(half, 0.5), (1.0 - half / jnp.tan(half)) / squared

    small = (1 / 2,), (1 / 12, 1 / 720, 1 / 30240, 1 / 1209600)
    return _along_vector(robot, q_p, -1.0, factors, small)


def has_rotation_vector(robot: Robot) -> bool:
    """Whether the platform has an orientation that does not change by small rotations alone."""
    return robot.oriented and robot.geometry.r > 1


def _along_vector(robot: Robot, q_p, sign: float, factors: Callable, small_factors) -> Array:
    """`1 ± a [φ]× + b [φ]×²` in the place of rotations, by factors a and b of the angle of φ."""
    jacobian = jnp.eye(robot.n_p)
    if not has_rotation_vector(robot):
        return jacobian
    d = robot.geometry.d
    vector = q_p[d:]
    squared = jnp.sum(vector * vector)
    small = squared < _SMALL
    large = jnp.where(small, 1.0, squared)
    a, b = (
        jnp.where(small, series(squared, *terms), factor)
        for factor, terms in zip(factors(large, jnp.sqrt(large)), small_factors, strict=True)
    )
    across = -sign * robot.geometry.spin(vector)
    twice = vector[:, None] * vector - squared * jnp.eye(len(vector))
    return jacobian.at[d:, d:].add(a * across + b * twice)
