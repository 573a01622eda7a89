"""How the values of a robot file depend on its geometry."""

from typing import NamedTuple

from .orientation import read_orientation
from .tables import Entry
from .units import ANGLE, LENGTH, Dimension, Sign


class Frame(NamedTuple):
    """How many numbers things have: names of the components of vectors and of rotations."""

    geometry: str
    axes: tuple[str, ...]
    rotation_axes: tuple[str, ...]

    def rotational(self, entry: Entry, dimension: Dimension) -> tuple[float, ...]:
        """A rotation or moment: one number in the plane, a vector in space."""
        if len(self.rotation_axes) == 1:
            return (entry.quantity(dimension),)
        return entry.vector(dimension, self.rotation_axes)

    def rotation(self, entry: Entry) -> tuple[float, ...]:
        """A rotation: an angle in the plane; in space a rotation vector, or a table."""
        if len(self.rotation_axes) == 3:
            if entry.is_table:
                return read_orientation(entry.table("rotation"))
            if not entry.is_list:
                raise entry.error(
                    "a rotation vector (x, y, z) or a table such as { tangent = [0, 0, 1] }"
                )
        return self.rotational(entry, ANGLE)

    def segment(self, entry: Entry) -> tuple[float, ...]:
        """A rigid segment: a length along the tangent, or a vector."""
        if entry.is_list:
            return entry.vector(LENGTH, self.axes)
        return (entry.quantity(LENGTH, Sign.NOT_NEGATIVE), *self.zeros[1:])

    @property
    def zeros(self) -> tuple[float, ...]:
        """What stands for no vector in a file."""
        return (0.0,) * len(self.axes)

    @property
    def no_turn(self) -> object:
        """What stands for no rotation or moment in a file."""
        return 0.0 if len(self.rotation_axes) == 1 else (0.0,) * len(self.rotation_axes)
