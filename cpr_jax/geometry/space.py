"""Space: world axes x, y, z; the restriction to the yz-plane is `Plane`."""

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .abstract import AbstractGeometry, Components, namespace

# Below this squared angle the series of sin and cos are exact to rounding.
_SMALL = 1e-4


class Space(AbstractGeometry):
    """SE(3) with rotations as unit quaternions `(w, x, y, z)`."""

    name = "space"
    axes = ("x", "y", "z")
    rotation_axes = ("x", "y", "z")
    stiffnesses = ("k_t", "k_2", "k_3")

    @property
    def identity(self) -> tuple[float, ...]:
        return (1.0, 0.0, 0.0, 0.0)

    def rotate(self, rotation: Components, vector: Components) -> Components:
        w, *axis = rotation
        twice = [2.0 * c for c in self.cross(axis, vector)]
        turned = self.cross(axis, twice)
        return tuple(v + w * t + u for v, t, u in zip(vector, twice, turned, strict=True))

    def unrotate(self, rotation: Components, vector: Components) -> Components:
        return self.rotate(self.inverse(rotation), vector)

    def to_local(self, rotation: Components, moment: Components) -> Components:
        return self.unrotate(rotation, moment)

    def to_outer(self, rotation: Components, moment: Components) -> Components:
        return self.rotate(rotation, moment)

    def tangent(self, rotation: Components) -> Components:
        w, x, y, z = rotation
        return 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)

    def rate(self, rotation: Components, curvature: Components) -> Components:
        w, x, y, z = rotation
        a, b, c = (0.5 * u for u in curvature)
        return (
            -x * a - y * b - z * c,
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
        )

    def compose(self, outer: Components, inner: Components) -> Components:
        w, x, y, z = outer
        v, a, b, c = inner
        return (
            w * v - x * a - y * b - z * c,
            w * a + x * v + y * c - z * b,
            w * b + y * v + z * a - x * c,
            w * c + z * v + x * b - y * a,
        )

    def inverse(self, rotation: Components) -> Components:
        w, x, y, z = rotation
        return w, -x, -y, -z

    def normalise(self, rotation: Components) -> Components:
        norm = jnp.sqrt(sum(c * c for c in rotation))
        return tuple(c / norm for c in rotation)

    def exp(self, vector: Components) -> Components:
        xp = namespace(*vector)
        squared = _squared(vector)
        small = squared < _SMALL
        half = 0.5 * xp.sqrt(xp.where(small, 1.0, squared))
        w = xp.where(small, 1.0 - squared / 8.0 + squared**2 / 384.0, xp.cos(half))
        factor = xp.where(
            small, 0.5 - squared / 48.0 + squared**2 / 3840.0, xp.sin(half) / (2.0 * half)
        )
        return w, *(factor * c for c in vector)

    def log(self, rotation: Components) -> Components:
        # q and -q are one rotation; the sign of w chooses the shorter way round.
        sign = jnp.where(rotation[0] < 0.0, -1.0, 1.0)
        w, *axis = (sign * c for c in rotation)
        squared = _squared(axis)
        small = squared < _SMALL
        sine = jnp.sqrt(jnp.where(small, 1.0, squared))
        series = 2.0 + squared / 3.0 + 3.0 * squared**2 / 20.0 + 5.0 * squared**3 / 56.0
        factor = jnp.where(small, series, 2.0 * jnp.arctan2(sine, w) / sine)
        return tuple(factor * c for c in axis)

    def matrix(self, rotation: Components) -> Float[Array, "3 3"]:
        w, x, y, z = rotation
        rows = (
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
            (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
            (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
        )
        return jnp.stack([jnp.stack(row) for row in rows])

    def frame(self, rotation: Components) -> Float[Array, "3 3"]:
        return self.matrix(rotation)

    def outward(self, frame: Float[Array, "3 3"], vector: Float[Array, "3"]) -> Float[Array, "3"]:
        # A sum, which XLA fuses with what is around it.
        return jnp.sum(frame * vector, axis=1)

    def inward(self, frame: Float[Array, "3 3"], vector: Float[Array, "3"]) -> Float[Array, "3"]:
        return jnp.sum(frame * vector[:, None], axis=0)

    def moment_outward(
        self, frame: Float[Array, "3 3"], moment: Float[Array, "3"]
    ) -> Float[Array, "3"]:
        return self.outward(frame, moment)

    def moment_inward(
        self, frame: Float[Array, "3 3"], moment: Float[Array, "3"]
    ) -> Float[Array, "3"]:
        return self.inward(frame, moment)

    def later(self, free: Float[Array, "3"]) -> Float[Array, "3"]:
        a, b, c = free
        return jnp.stack([0.0 * a, a * b * (1.0 - c), c * (a + b - 2.0 * a * b)])

    def misalignment(self, free: Float[Array, "3"], rotation: Components) -> Float[Array, "3"]:
        # The axes of a universal joint stay at right angles; elsewhere nothing turns at all.
        w, x, y, z = rotation
        across = jnp.stack([y * z + w * x, w * y - x * z, x * y + w * z])
        return jnp.where(_universal(free), 2.0 * across, jnp.stack(self.log(rotation)))

    def joint_axes(
        self, free: Float[Array, "3"], outer: Float[Array, "3 3"], leg: Float[Array, "3 3"]
    ) -> Float[Array, "3 3"]:
        axes = jnp.where(self.later(free) > 0.5, leg, outer)
        normals = jnp.stack(self.cross(jnp.roll(axes, 2, axis=1), jnp.roll(axes, 1, axis=1)))
        return jnp.where(_universal(free), normals, axes)

    def cross(self, arm: Components, force: Components) -> Components:
        x, y, z = arm
        a, b, c = force
        return y * c - z * b, z * a - x * c, x * b - y * a

    def bracket(self, turn: Float[Array, "3"], moment: Float[Array, "3"]) -> Float[Array, "3"]:
        return jnp.cross(turn, moment)

    def magnitude(self, moment: Float[Array, "3"]) -> Float[Array, ""]:
        # Where it vanishes, its derivative is taken as zero.
        squared = _squared(moment)
        some = squared > 0.0
        return jnp.where(some, jnp.sqrt(jnp.where(some, squared, 1.0)), 0.0)

    def potential(self, moment: Float[Array, "3"], turn: Float[Array, "3"]) -> Float[Array, ""]:
        # A dead moment does other work on other ways to the same rotation.
        return jnp.zeros(())


def _universal(free: Float[Array, "3"]) -> Bool[Array, "3"]:
    """Whether a rotation is the locked one of a universal joint."""
    return (free < 0.5) & (jnp.sum(free, axis=0) == 2.0)


def _squared(vector: Components) -> Any:
    x, y, z = vector
    return x * x + y * y + z * z


SPACE = Space()
