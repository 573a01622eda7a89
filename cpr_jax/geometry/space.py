"""Space: world axes x, y, z; the restriction to the yz-plane is `Plane`."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from .abstract import AbstractGeometry, Components, as_array, namespace

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

    def rows(self, rotation: Components) -> Any:
        w, x, y, z = rotation
        a, b, c = 2.0 * x, 2.0 * y, 2.0 * z
        xx, yy, zz = a * x, b * y, c * z
        xy, yz, zx = a * y, b * z, c * x
        wx, wy, wz = w * a, w * b, w * c
        return (
            (1.0 - (yy + zz), xy - wz, zx + wy),
            (xy + wz, 1.0 - (xx + zz), yz - wx),
            (zx - wy, yz + wx, 1.0 - (xx + yy)),
        )

    def rotate(self, rows: Any, vector: Components) -> Components:
        x, y, z = vector
        return tuple(a * x + b * y + c * z for a, b, c in rows)

    def unrotate(self, rows: Any, vector: Components) -> Components:
        return self.rotate(zip(*rows, strict=True), vector)

    def to_local(self, rows: Any, moment: Components) -> Components:
        return self.unrotate(rows, moment)

    def to_outer(self, rows: Any, moment: Components) -> Components:
        return self.rotate(rows, moment)

    def tangent(self, rows: Any) -> Components:
        return tuple(row[0] for row in rows)

    def rate(self, rotation: Components, curvature: Components) -> Components:
        w, x, y, z = rotation
        a, b, c = (0.5 * u for u in curvature)
        return (
            -x * a - y * b - z * c,
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
        )

    def compose(self, outer: Components, inner: Components) -> Float[Array, "4"]:
        return _bilinear(_PRODUCT, outer, inner)

    def inverse(self, rotation: Components) -> Components:
        w, x, y, z = rotation
        return w, -x, -y, -z

    def normalise(self, rotation: Components) -> Components:
        norm = jnp.sqrt(sum(c * c for c in rotation))
        return tuple(c / norm for c in rotation)

    def exp(self, vector: Components) -> Float[Array, "4"]:
        xp = namespace(vector)
        turn = as_array(vector)
        squared = xp.sum(turn * turn, axis=0)
        small = squared < _SMALL
        half = 0.5 * xp.sqrt(xp.where(small, 1.0, squared))
        w = xp.where(small, series(squared, 1.0, -1 / 8, 1 / 384), xp.cos(half))
        sinc = series(squared, 1 / 2, -1 / 48, 1 / 3840)
        factor = xp.where(small, sinc, xp.sin(half) / (2.0 * half))
        return xp.concatenate([w[None], factor * turn])

    def log(self, rotation: Components) -> Float[Array, "3"]:
        quaternion = as_array(rotation)
        # q and -q are one rotation; the sign of w chooses the shorter way round.
        quaternion = jnp.where(quaternion[0] < 0.0, -quaternion, quaternion)
        w, axis = quaternion[0], quaternion[1:]
        squared = jnp.sum(axis * axis, axis=0)
        small = squared < _SMALL
        sine = jnp.sqrt(jnp.where(small, 1.0, squared))
        near = series(squared, 2.0, 1 / 3, 3 / 20, 5 / 56)
        factor = jnp.where(small, near, 2.0 * jnp.arctan2(sine, w) / sine)
        return factor * axis

    def matrix(self, rotation: Components) -> Float[Array, "3 3"]:
        return _bilinear(_MATRIX, rotation, rotation)

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
        across = _bilinear(_ACROSS, rotation, rotation)
        return jnp.where(_universal(free), across, self.log(rotation))

    def joint_axes(
        self, free: Float[Array, "3"], outer: Float[Array, "3 3"], leg: Float[Array, "3 3"]
    ) -> Float[Array, "3 3"]:
        axes = jnp.where(self.later(free) > 0.5, leg, outer)
        normals = self.moment_of(jnp.roll(axes, 2, axis=1), jnp.roll(axes, 1, axis=1))
        return jnp.where(_universal(free), normals, axes)

    def cross(self, arm: Components, force: Components) -> Components:
        x, y, z = arm
        a, b, c = force
        return y * c - z * b, z * a - x * c, x * b - y * a

    def moment_of(self, arm: Float[Array, "3"], force: Float[Array, "3"]) -> Float[Array, "3"]:
        return _bilinear(_PRODUCT[1:, 1:, 1:], arm, force)

    def bracket(self, turn: Float[Array, "3"], moment: Float[Array, "3"]) -> Float[Array, "3"]:
        return self.moment_of(turn, moment)

    def magnitude(self, moment: Float[Array, "3"]) -> Float[Array, ""]:
        # Where it vanishes, its derivative is taken as zero.
        squared = jnp.sum(moment * moment, axis=0)
        some = squared > 0.0
        return jnp.where(some, jnp.sqrt(jnp.where(some, squared, 1.0)), 0.0)

    def potential(self, moment: Float[Array, "3"], turn: Float[Array, "3"]) -> Float[Array, ""]:
        # A dead moment does other work on other ways to the same rotation.
        return jnp.zeros(())


def _universal(free: Float[Array, "3"]) -> Bool[Array, "3"]:
    """Whether a rotation is the locked one of a universal joint."""
    return (free < 0.5) & (jnp.sum(free, axis=0) == 2.0)


def series(x: Any, *coefficients: float) -> Any:
    """A polynomial by Horner's rule, its constant first: powers take more operations."""
    *others, total = coefficients
    for coefficient in reversed(others):
        total = coefficient + x * total
    return total


def _product_of_quaternions() -> Float[np.ndarray, "4 4 4"]:
    """The table of `(p q)_i = P_ijk p_j q_k`; without its first entries that of `a × b`."""
    table = np.zeros((4, 4, 4))
    table[0, 0, 0] = 1.0
    for i in range(3):
        axis, after, last = (1 + (i + k) % 3 for k in range(3))
        table[0, axis, axis] = -1.0
        table[axis, 0, axis] = table[axis, axis, 0] = 1.0
        table[axis, after, last], table[axis, last, after] = 1.0, -1.0
    return table


_PRODUCT = _product_of_quaternions()

# `(R e_b)_a`: component a of `q e_b q*`, by components of q and q.
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
_MATRIX = np.einsum("mib,amj,j->abij", _PRODUCT[:, :, 1:], _PRODUCT[1:], _CONJUGATE)

# Products of the axes of the leg and of what carries the joint, but for the axis that is locked.
_ACROSS = _MATRIX[[2, 2, 1], [1, 0, 0]] * np.array([1.0, -1.0, 1.0])[:, None, None]


def _bilinear(table: Float[np.ndarray, "*out j k"], a: Components, b: Components) -> Array:
    """`Σ table_jk a_j b_k`, in few operations: written out, it is fast in loops along rods only."""
    pairs = as_array(a)[:, None] * as_array(b)
    return jnp.tensordot(table.astype(pairs.dtype), pairs, axes=2)


SPACE = Space()
