"""Single numbers of a robot, wherever they are in it."""

import dataclasses
from operator import attrgetter

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..robots.robot import Robot
from ..rods.segments import first_length

LENGTH = "legs.rod.length"
"""Where the lengths of whole rods are."""


@dataclasses.dataclass(frozen=True)
class Entry:
    """One number of a robot: where it is, and whether ρ is its reciprocal.

    **Attributes:**

    - `label`: as written by the user.
    - `path`: attributes from the robot to the array, joined by dots.
    - `index`: into that array.
    - `reciprocal`: the robot holds `1 / ρ` (stiffnesses and radii).
    - `unit`: SI unit of ρ.
    """

    label: str
    path: str
    index: tuple[int, ...]
    reciprocal: bool
    unit: str

    @property
    def positive(self) -> bool:
        """Whether no rod has it below zero: lengths, stiffnesses and compliances."""
        return self.path.startswith("legs.rod.") and self.path.endswith(("length", "compliance"))

    def get(self, robot: Robot) -> Float[Array, ""]:
        """The value of ρ."""
        number = attrgetter(self.path)(robot)[self.index]
        return 1.0 / number if self.reciprocal else number

    def set(self, robot: Robot, value: Float[Array, ""]) -> Robot:
        """The robot with another value of ρ."""
        number = 1.0 / value if self.reciprocal else value
        leaf = attrgetter(self.path)(robot)
        return eqx.tree_at(attrgetter(self.path), robot, leaf.at[self.index].set(number))

    def place(self, robot: Robot) -> tuple[int, ...]:
        """The index, counted from the front."""
        shape = attrgetter(self.path)(robot).shape
        return tuple(i % n for i, n in zip(self.index, shape, strict=True))

    def places(self, robot: Robot) -> frozenset[tuple[str, tuple[int, ...]]]:
        """All numbers of the robot that it stands for."""
        return frozenset({(self.path, self.place(robot))})


@dataclasses.dataclass(frozen=True)
class BendingStiffness(Entry):
    """Of a rod in space: ρ is that about its last axis, that about the other goes with it."""

    def set(self, robot: Robot, value: Float[Array, ""]) -> Robot:
        leaf = attrgetter(self.path)(robot)
        leaf = leaf.at[(*self.index[:-1], slice(1, 3))].multiply(self.get(robot) / value)
        return eqx.tree_at(attrgetter(self.path), robot, leaf)

    def places(self, robot: Robot) -> frozenset[tuple[str, tuple[int, ...]]]:
        rod = self.place(robot)[:-1]
        return frozenset((self.path, (*rod, axis)) for axis in (1, 2))


@dataclasses.dataclass(frozen=True)
class SegmentLength(Entry):
    """The length of one segment of a rod; the others keep theirs, the whole rod changes."""

    def get(self, robot: Robot) -> Float[Array, ""]:
        if self.path == LENGTH:
            return first_length(robot.legs.rod)[self.index]
        return super().get(robot)

    def set(self, robot: Robot, value: Float[Array, ""]) -> Robot:
        whole = robot.legs.rod.length.at[self.index[0]].add(value - self.get(robot))
        if self.path != LENGTH:
            robot = super().set(robot, value)
        return eqx.tree_at(attrgetter(LENGTH), robot, whole)


@dataclasses.dataclass(frozen=True)
class Common(Entry):
    """A number of all legs, and segments, at once: ρ is that of the first, the ratios are kept.

    Of lengths the first is that of a whole rod.

    Rods that were cut from one bar have one material, whose number none of them has for itself.

    **Attributes:**

    - `index`: those entries of each leg's vector that change; the last of them is ρ.
    """

    def get(self, robot: Robot) -> Float[Array, ""]:
        number = attrgetter(self.path)(robot)[(0, *self.index[-1:])]
        return 1.0 / number if self.reciprocal else number

    def set(self, robot: Robot, value: Float[Array, ""]) -> Robot:
        ratio = value / self.get(robot)
        factor = 1.0 / ratio if self.reciprocal else ratio
        for path in self._paths(robot):
            leaf = attrgetter(path)(robot)
            changes = np.isin(np.arange(leaf.shape[-1]), self.index) if self.index else True
            robot = eqx.tree_at(attrgetter(path), robot, leaf * jnp.where(changes, factor, 1.0))
        return robot

    def places(self, robot: Robot) -> frozenset[tuple[str, tuple[int, ...]]]:
        found = set()
        for path in self._paths(robot):
            shape = attrgetter(path)(robot).shape
            for place in np.ndindex(*(shape[:-1] if self.index else shape)):
                found |= {(path, (*place, k)) for k in self.index} or {(path, place)}
        return frozenset(found)

    def _paths(self, robot: Robot) -> list[str]:
        further = self.path.startswith("legs.rod.") and robot.legs.rod.further is not None
        return [self.path, *([self.path.replace("rod.", "rod.further.")] if further else [])]
