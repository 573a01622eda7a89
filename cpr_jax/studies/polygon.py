"""A path of straight lines, in stops."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from ..errors import InputError
from ..robots.robot import Robot
from ..statics.unknowns import unknown_scales, unknown_units

_MOST = 1_000_000
"""Stops of a path: so many take a quarter of an hour and some gigabytes."""


class Polygon(NamedTuple):
    """A path in stops.

    **Attributes:**

    - `s`: their distances along it, in `unit`.
    - `points`: imposed coordinates.
    - `at_corner`: which of them are waypoints.
    - `shown`: which of them belong to the result; between these nothing is to be missed.
    """

    unit: str
    s: Float[np.ndarray, " stops"]
    points: Float[np.ndarray, "stops n_a"]
    at_corner: Bool[np.ndarray, " stops"]
    shown: Bool[np.ndarray, " stops"]

    @classmethod
    def of(cls, robot: Robot, corners, places: tuple[int, ...], spacing: float | None):
        """Stops on a polygon with corners."""
        units = [unknown_units(robot)[place] for place in places]
        length = float(np.asarray(unknown_scales(robot))[robot.n_a])
        unit = "m" if "m" in units else "rad"
        usual = 0.01 * (length if unit == "m" else 1.0)
        weights = np.array([length if (unit, own) == ("m", "rad") else 1.0 for own in units])
        moves = np.diff(corners, axis=0)
        lengths = np.linalg.norm(moves * weights, axis=1)
        if not np.any(lengths > 0.0):
            raise InputError("Argument `waypoints` must be different points, but they are one.")
        wanted = np.maximum(np.ceil(lengths / (spacing or usual) - 1e-9), lengths > 0.0)
        finer = np.maximum(np.ceil(lengths / usual / np.maximum(wanted, 1.0) - 1e-9), 1.0)
        counts = wanted * finer
        if np.sum(counts) > _MOST:
            raise InputError(
                f"Argument `spacing` must leave at most {_MOST} stops, but the path of "
                f"{np.sum(lengths):g} {unit} has {np.sum(counts):.0f} of them."
            )
        begins = np.concatenate([[0.0], np.cumsum(lengths)])
        parts = [(np.zeros(1), corners[:1], np.ones(1, bool), np.ones(1, bool))]
        for k, count in enumerate(counts.astype(int)):
            number = np.arange(1, count + 1)
            share = number / max(count, 1)
            points = corners[k] + share[:, None] * moves[k]
            shown = number % int(finer[k]) == 0
            parts.append((begins[k] + share * lengths[k], points, number == count, shown))
        return cls(unit, *(np.concatenate(part) for part in zip(*parts, strict=True)))
