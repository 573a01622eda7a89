"""Small motions of the platform beside changes of its coordinates."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..robots.robot import Robot


def motion_jacobian(robot: Robot, q_p: Float[Array, " n_p"]) -> Float[Array, "n_p n_p"]:
    """Displacements and small rotations about the world axes per change of `q_p`.

    The identity but for rotation vectors, whose changes turn the less the longer these are; at a
    full turn it is singular.
    """
    geometry = robot.geometry
    d = geometry.d
    back = geometry.inverse(robot.orientation(q_p))

    def turn(changed):
        turned = geometry.compose(robot.orientation(changed), back)
        return jnp.stack(geometry.log(turned))[: robot.n_p - d]

    turns = jax.jacfwd(turn)(q_p)[:, d:]
    return jnp.eye(robot.n_p).at[d:, d:].set(turns)


def has_rotation_vector(robot: Robot) -> bool:
    """Whether the platform has an orientation that does not change by small rotations alone."""
    return robot.oriented and robot.geometry.r > 1
