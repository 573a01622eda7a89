"""Orientations in space as people write them, to rotation vectors; no array is needed."""

import math

from ..errors import InputError
from .tables import Table, unit_vector
from .units import ANGLE, RATIO

_Vector = tuple[float, ...]

_AXES = ("x", "y", "z")
# Below this angle between the two, rounding would decide where the third axis goes.
_ALONG = 1e-6


def read_orientation(table: Table) -> _Vector:
    """The rotation vector of a table with directions, or with an axis and an angle."""
    match table.first("tangent", "axis"):
        case "axis":
            table.refuse("third", "`axis` and `angle` say all")
            angle = table.entry("angle").quantity(ANGLE)
            return tuple(angle * c for c in _direction(table, "axis"))
        case "tangent":
            table.refuse("angle", "it belongs to an `axis`")
            tangent = _direction(table, "tangent")
            if not table.has("third"):
                return shortest_rotation(tangent)
            third = _across(tangent, _direction(table, "third"))
            if third is None:
                raise table.entry("third").error("a direction that is not along the tangent")
            return rotation_of_axes(tangent, third)
    raise InputError(
        f"Argument `{table.field('tangent')}` must be given, or both `axis` and `angle`, but the "
        f"orientation is missing."
    )


def _direction(table: Table, key: str) -> _Vector:
    entry = table.entry(key)
    return unit_vector(entry.vector(RATIO, _AXES), entry)


def _across(tangent: _Vector, vector: _Vector) -> _Vector | None:
    """The unit vector at right angles to a tangent that is nearest to another one."""
    along = sum(t * v for t, v in zip(tangent, vector, strict=True))
    rest = tuple(v - along * t for v, t in zip(vector, tangent, strict=True))
    length = math.hypot(*rest)
    return None if length < _ALONG else tuple(c / length for c in rest)


def shortest_rotation(tangent: _Vector) -> _Vector:
    """The shortest rotation that takes the first axis to a unit vector, as a rotation vector.

    Of the half turns to the opposite direction it is the one about the third axis.
    """
    x, y, z = tangent
    across = math.hypot(y, z)
    if across == 0.0:
        return (0.0, 0.0, 0.0 if x > 0.0 else math.pi)
    angle = math.atan2(across, x)
    return (0.0, angle * (-z / across), angle * (y / across))


def rotation_of_axes(first: _Vector, third: _Vector) -> _Vector:
    """The rotation vector of axes of which the first and the third are given, orthonormal."""
    second = (
        third[1] * first[2] - third[2] * first[1],
        third[2] * first[0] - third[0] * first[2],
        third[0] * first[1] - third[1] * first[0],
    )
    (a, b, c), (d, e, f), (g, h, i) = zip(first, second, third, strict=True)
    # The rows are 4 q_k q for the components q_k of the quaternion q; the longest is the most
    # accurate, for half turns too.
    rows = (
        (1.0 + a + e + i, h - f, c - g, d - b),
        (h - f, 1.0 + a - e - i, b + d, c + g),
        (c - g, b + d, 1.0 - a + e - i, f + h),
        (d - b, c + g, f + h, 1.0 - a - e + i),
    )
    _, row = max((rows[k][k], rows[k]) for k in range(4))
    w, *axis = row if row[0] >= 0.0 else tuple(-c for c in row)
    sine = math.hypot(*axis)
    if sine == 0.0:
        return (0.0, 0.0, 0.0)
    angle = 2.0 * math.atan2(sine, w)
    return tuple(angle * (c / sine) for c in axis)
