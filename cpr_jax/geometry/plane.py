"""The yz-plane: angles are measured from y to z, `(a × b)_x = a_y b_z - a_z b_y`."""

import jax.numpy as jnp

from .abstract import AbstractGeometry, Components


class Plane(AbstractGeometry):
    """SE(2) with rotations as unit complex numbers `(cos θ, sin θ)`."""

    name = "plane"
    axes = ("y", "z")
    rotation_axes = ("x",)

    @property
    def identity(self) -> tuple[float, ...]:
        return (1.0, 0.0)

    def rotate(self, rotation: Components, vector: Components) -> Components:
        c, s = rotation
        y, z = vector
        return c * y - s * z, s * y + c * z

    def unrotate(self, rotation: Components, vector: Components) -> Components:
        c, s = rotation
        y, z = vector
        return c * y + s * z, c * z - s * y

    def to_local(self, rotation: Components, moment: Components) -> Components:
        return moment

    def to_outer(self, rotation: Components, moment: Components) -> Components:
        return moment

    def tangent(self, rotation: Components) -> Components:
        c, s = rotation
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
        return jnp.cos(angle), jnp.sin(angle)

    def log(self, rotation: Components) -> Components:
        c, s = rotation
        return (jnp.arctan2(s, c),)

    def later(self, free: Components) -> Components:
        return (0.0,)

    def misalignment(self, free: Components, rotation: Components) -> Components:
        return self.log(rotation)

    def joint_axes(
        self, free: Components, outer: Components, leg: Components
    ) -> tuple[Components, ...]:
        return ((1.0,),)

    def cross(self, arm: Components, force: Components) -> Components:
        return (arm[0] * force[1] - arm[1] * force[0],)


PLANE = Plane()
