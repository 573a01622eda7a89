"""The yz-plane: angles are measured from y to z, `(a × b)_x = a_y b_z - a_z b_y`."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from .abstract import AbstractGeometry, Components, namespace


class Plane(AbstractGeometry):
    """SE(2) with rotations as unit complex numbers `(cos θ, sin θ)`."""

    name = "plane"
    axes = ("y", "z")
    rotation_axes = ("x",)
    stiffnesses = ("k_b",)

    @property
    def identity(self) -> tuple[float, ...]:
        return (1.0, 0.0)

    def rows(self, rotation: Components) -> Components:
        return rotation

    def rotate(self, rows: Components, vector: Components) -> Components:
        c, s = rows
        y, z = vector
        return c * y - s * z, s * y + c * z

    def unrotate(self, rows: Components, vector: Components) -> Components:
        c, s = rows
        y, z = vector
        return c * y + s * z, c * z - s * y

    def to_local(self, rows: Components, moment: Components) -> Components:
        return moment

    def to_outer(self, rows: Components, moment: Components) -> Components:
        return moment

    def tangent(self, rows: Components) -> Components:
        c, s = rows
        return c, s

    def rate(self, rotation: Components, curvature: Components) -> Components:
        c, s = rotation
        (u,) = curvature
        return -s * u, c * u

    def compose(self, outer: Components, inner: Components) -> Components:
        return self.rotate(outer, inner)

    def inverse(self, rotation: Components) -> Components:
        c, s = rotation
        return c, -s

    def normalise(self, rotation: Components) -> Components:
        c, s = rotation
        norm = jnp.sqrt(c * c + s * s)
        return c / norm, s / norm

    def exp(self, vector: Components) -> Components:
        (angle,) = vector
        xp = namespace(angle)
        return xp.cos(angle), xp.sin(angle)

    def log(self, rotation: Components) -> Components:
        c, s = rotation
        return (jnp.arctan2(s, c),)

    def matrix(self, rotation: Components) -> Float[Array, "2 2"]:
        c, s = rotation
        return jnp.stack([jnp.stack([c, -s]), jnp.stack([s, c])])

    def frame(self, rotation: Components) -> Components:
        return rotation

    def outward(self, frame: Components, vector: Float[Array, "2"]) -> Float[Array, "2"]:
        return jnp.stack(self.rotate(frame, vector))

    def inward(self, frame: Components, vector: Float[Array, "2"]) -> Float[Array, "2"]:
        return jnp.stack(self.unrotate(frame, vector))

    def moment_outward(self, frame: Components, moment: Float[Array, "1"]) -> Float[Array, "1"]:
        return moment

    def moment_inward(self, frame: Components, moment: Float[Array, "1"]) -> Float[Array, "1"]:
        return moment

    def later(self, free: Float[Array, "1"]) -> Float[Array, "1"]:
        return jnp.zeros_like(free)

    def misalignment(self, free: Float[Array, "1"], rotation: Components) -> Float[Array, "1"]:
        return jnp.stack(self.log(rotation))

    def joint_axes(
        self, free: Float[Array, "1"], outer: Components, leg: Components
    ) -> Float[Array, "1 1"]:
        return jnp.ones((1, *free.shape))

    def cross(self, arm: Components, force: Components) -> Components:
        return (arm[0] * force[1] - arm[1] * force[0],)

    def moment_of(self, arm: Float[Array, "2"], force: Float[Array, "2"]) -> Float[Array, "1"]:
        return jnp.stack(self.cross(arm, force))

    def bracket(self, turn: Float[Array, "1"], moment: Float[Array, "1"]) -> Float[Array, "1"]:
        return jnp.zeros_like(moment)

    def magnitude(self, moment: Float[Array, "1"]) -> Float[Array, ""]:
        return moment[0]

    def potential(self, moment: Float[Array, "1"], turn: Float[Array, "1"]) -> Float[Array, ""]:
        return -moment[0] * turn[0]


PLANE = Plane()
