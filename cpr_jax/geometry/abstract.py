"""What the rest of the package asks of the plane and of space."""

import abc
from collections.abc import Sequence
from typing import Any, ClassVar, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..outline import are_traced

# Vectors are tuples of scalars here: under `vmap` each component then is one contiguous
# row with the samples last in memory, and no stage of the integration pays for stacking.
Components: TypeAlias = Float[Array, " k"] | Sequence[Float[Array, ""] | float]

Numbers: TypeAlias = ArrayLike | Sequence[ArrayLike]
"""What users may give for an array."""


def namespace(*values: Any) -> Any:
    """`numpy` for numbers that are known, `jax.numpy` where a program traces one of them.

    Outside of a program each operation of `jax.numpy` would be compiled by itself.
    """
    return jnp if are_traced(jax.tree.leaves(values)) else np


def floats(values: Any) -> jax.Array:
    """An array of floating-point numbers.

    `jnp.asarray` without a type compiles a program for each shape of what it is given, which takes
    longer than all the rest of describing a robot.
    """
    if isinstance(values, jax.Array):
        return values.astype(float)
    return _known(namespace(values).asarray(values, float), float)


def unchanged(values: Any) -> jax.Array:
    """As `floats`, of the precision that they have: numbers of a robot that was described before
    float64 was enabled are to be noticed, not to pass for accurate ones."""
    array = namespace(values).asarray(values)
    return _known(array, jax.dtypes.canonicalize_dtype(array.dtype))


def _known(array: Any, dtype: Any) -> jax.Array:
    """As `jnp.asarray`; what is known stays so within a transformation."""
    if not isinstance(array, np.ndarray):
        return jnp.asarray(array, dtype)
    with jax.ensure_compile_time_eval():
        return jnp.asarray(array, dtype)


def as_array(components: Components) -> Any:
    """Components as one array: outside of integrations the size of a program counts."""
    if isinstance(components, (jax.Array, np.ndarray)):
        return components
    return namespace(components).stack(components)


class AbstractGeometry(abc.ABC):
    """The Euclidean group of the plane or of space, in components.

    A rotation is a unit complex number `(cos, sin)` in the plane and a unit quaternion
    `(w, x, y, z)` in space. The first local axis of a cross-section is the tangent of its
    rod. Instances carry no data and serve as static fields. Arrays may have further axes behind
    their components, for many cases at once.
    """

    name: ClassVar[str]
    axes: ClassVar[tuple[str, ...]]
    """Names of the world axes, in the order of the components of a vector."""
    rotation_axes: ClassVar[tuple[str, ...]]
    """Names of the world axes that a rotation or a moment can have."""
    stiffnesses: ClassVar[tuple[str, ...]]
    """Names of a rod's stiffnesses against the curvature about each local axis."""

    @property
    def d(self) -> int:
        """Number of components of a position or a force."""
        return len(self.axes)

    @property
    def r(self) -> int:
        """Number of components of a moment or an angular velocity."""
        return len(self.rotation_axes)

    @property
    def freedoms(self) -> int:
        """Number of freedoms of a rigid body: 3 in the plane, 6 in space."""
        return self.d + self.r

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other)

    def __hash__(self) -> int:
        return hash(type(self))

    def __repr__(self) -> str:
        return self.name.upper()

    @property
    @abc.abstractmethod
    def identity(self) -> tuple[float, ...]:
        """The rotation that does nothing."""

    @abc.abstractmethod
    def rows(self, rotation: Components) -> Any:
        """A rotation in the form in which `rotate` and its kin apply it, in components.

        In space the rows of its matrix: a rod turns several vectors at each of its points.
        """

    @abc.abstractmethod
    def rotate(self, rows: Any, vector: Components) -> Components:
        """A vector of the local frame, expressed in the outer one: `R v`."""

    @abc.abstractmethod
    def unrotate(self, rows: Any, vector: Components) -> Components:
        """A vector of the outer frame, expressed in the local one: `Rᵀ v`."""

    @abc.abstractmethod
    def to_local(self, rows: Any, moment: Components) -> Components:
        """A moment of the outer frame, expressed in the local one."""

    @abc.abstractmethod
    def to_outer(self, rows: Any, moment: Components) -> Components:
        """A moment of the local frame, expressed in the outer one."""

    @abc.abstractmethod
    def tangent(self, rows: Any) -> Components:
        """The first local axis in the outer frame."""

    @abc.abstractmethod
    def rate(self, rotation: Components, curvature: Components) -> Components:
        """Derivative of the rotation that turns with `curvature`, local axes, rad/m."""

    @abc.abstractmethod
    def compose(self, outer: Components, inner: Components) -> Components:
        """The rotation `R_outer R_inner`."""

    @abc.abstractmethod
    def inverse(self, rotation: Components) -> Components:
        """The rotation `Rᵀ`."""

    @abc.abstractmethod
    def normalise(self, rotation: Components) -> Components:
        """Removes what the integration has added to the length of the rotation."""

    @abc.abstractmethod
    def exp(self, vector: Components) -> Components:
        """The rotation by a rotation vector (an angle in the plane), rad."""

    @abc.abstractmethod
    def log(self, rotation: Components) -> Components:
        """The rotation vector of a rotation, its angle in (-π, π], rad."""

    @abc.abstractmethod
    def later(self, free: Float[Array, " r"]) -> Float[Array, " r"]:
        """1 for the axis of a universal joint that the leg carries, 0 elsewhere.

        A joint that leaves two rotations free turns about the earlier axis, which belongs to the
        base or to the platform, then about the later one, which belongs to the leg.

        **Arguments:**

        - `free`: 1 for each rotation that a joint leaves free, 0 for the others.
        """

    @abc.abstractmethod
    def matrix(self, rotation: Components) -> Float[Array, "d d"]:
        """The rotation as a matrix `R` that acts on vectors."""

    @abc.abstractmethod
    def frame(self, rotation: Components) -> Any:
        """A rotation in the form in which `outward` and its kin apply it to many vectors.

        Outside of integrations the size of a program counts: in space this is a matrix.
        """

    @abc.abstractmethod
    def outward(self, frame: Any, vector: Float[Array, " d"]) -> Float[Array, " d"]:
        """A vector of the local frame, expressed in the outer one: `R v`."""

    @abc.abstractmethod
    def inward(self, frame: Any, vector: Float[Array, " d"]) -> Float[Array, " d"]:
        """A vector of the outer frame, expressed in the local one: `Rᵀ v`."""

    @abc.abstractmethod
    def moment_outward(self, frame: Any, moment: Float[Array, " r"]) -> Float[Array, " r"]:
        """A moment of the local frame, expressed in the outer one."""

    @abc.abstractmethod
    def moment_inward(self, frame: Any, moment: Float[Array, " r"]) -> Float[Array, " r"]:
        """A moment of the outer frame, expressed in the local one."""

    @abc.abstractmethod
    def misalignment(self, free: Float[Array, " r"], rotation: Components) -> Float[Array, " r"]:
        """What vanishes, for each locked rotation of a joint, where the joint is assembled.

        **Arguments:**

        - `rotation`: of the base or the platform as seen from the leg.
        """

    @abc.abstractmethod
    def joint_axes(
        self,
        free: Float[Array, " r"],
        outer: Any,
        leg: Any,
    ) -> Float[Array, "r r"]:
        """Columns: axes about which a joint turns or transmits a moment, in world axes.

        **Arguments:**

        - `outer`, `leg`: frames of the base or the platform, and of the leg.
        """

    @abc.abstractmethod
    def cross(self, arm: Components, force: Components) -> Components:
        """The moment `arm × force`."""

    @abc.abstractmethod
    def moment_of(self, arm: Float[Array, " d"], force: Float[Array, " d"]) -> Float[Array, " r"]:
        """As `cross`, of arrays outside of integrations."""

    @abc.abstractmethod
    def bracket(self, turn: Float[Array, " r"], moment: Float[Array, " r"]) -> Float[Array, " r"]:
        """Change of a moment that a small turn carries along: `φ × m`."""

    @abc.abstractmethod
    def magnitude(self, moment: Float[Array, " r"]) -> Float[Array, ""]:
        """Size of a moment or of an area; about the only axis of the plane with its sign."""

    @abc.abstractmethod
    def potential(self, moment: Float[Array, " r"], turn: Float[Array, " r"]) -> Float[Array, ""]:
        """Energy of a dead moment at a rotation vector, zero where it has no potential, J."""

    def spin(self, arm: Float[Array, " d"]) -> Float[Array, "d r"]:
        """Motion `φ × arm` of the end of an arm for a unit turn about each axis."""
        return jax.vmap(lambda force: jnp.stack(self.cross(arm, force)))(jnp.eye(self.d))

    def lever(self, arm: Float[Array, " d"], force: Float[Array, " d"]) -> Float[Array, "r r"]:
        """Second derivative in a turn of the energy `-force · R arm` of a dead force."""
        moments = jax.vmap(lambda moved: jnp.stack(self.cross(moved, force)))(self.spin(arm).T)
        return -0.5 * (moments + moments.T)

    def mirror(self, axis: str) -> tuple[Float[np.ndarray, " d"], Float[np.ndarray, " r"]]:
        """Signs that a reflection along a world axis gives to vectors, and to moments and turns."""
        vectors = [-1.0 if name == axis else 1.0 for name in self.axes]
        turns = [1.0 if name == axis else -1.0 for name in self.rotation_axes]
        return np.array(vectors), np.array(turns)
