"""Singular curves: Type 1 and Type 2 loci, traced by continuation of an extended system."""

import enum
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from ..errors import InputError
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.problem import coordinate_places, imposed_coordinates
from ..statics.unknowns import unknown_scales
from .singular_points import Lane
from .tracer import Tracer


class SingularityType(enum.Enum):
    """Which motion becomes free (Gosselin and Angeles)."""

    TYPE_1 = "type-1"
    """Platform held: `A_q = ∂R₀/∂(q_a, μ)` is singular; the branch folds there.

    Where other coordinates are imposed than all those of the platform, they are what is held.
    """
    TYPE_2 = "type-2"
    """Motors held: `A_p = ∂R₀/∂(q_p, μ)` is singular; the platform loses its stiffness."""


class SingularCurve(NamedTuple):
    """Points of one curve, in order.

    **Attributes:**

    - `y`: unknowns in SI units, shape `(points, n_y)`.
    - `closed`: whether it ends where it starts; the first point then is repeated at the end.
    """

    y: Float[np.ndarray, "points n_y"]
    closed: bool


def trace_curves(
    robot: Robot,
    kind: SingularityType | str,
    starts: Float[np.ndarray, "starts n_y"],
    along: Float[np.ndarray, " starts"],
    axes: tuple[int | str, int | str],
    *,
    box: Float[np.ndarray, "2 2"],
    spacing: float,
    imposed: Sequence[int | str] | None = None,
    belongs: Callable[[Float[np.ndarray, "k n_y"]], Bool[np.ndarray, " k"]] | None = None,
    max_points: int = 2000,
    steps: int = DEFAULT_STEPS,
) -> list[SingularCurve]:
    """Traces the curves `{R₀ = 0, det A = 0}` through given neighbourhoods.

    Each start is pulled onto a curve; from starts far enough apart the curves are followed by
    pseudo-arclength, all at once, until they meet each other's starts, close, or leave the box.
    Folds and cusps of the projection onto the axes are ordinary points of the curve.

    **Arguments:**

    - `starts`: unknowns near a curve, SI units.
    - `along`: for each start, which of the two axes (0 or 1) may change while it is pulled.
    - `kind`: a `SingularityType`, or `"type-1"` or `"type-2"`.
    - `axes`: the two coordinates that vary, by their names or their places in `(q_a, q_p)`; other
        platform coordinates are held.
    - `box`: lower and upper corner; a curve ends at its first point outside.
    - `spacing`: wanted distance of the points in the axes' units.
    - `imposed`: what an inverse problem imposes, likewise; by default the platform coordinates.
    - `belongs`: tells of dimensionless unknowns whether they are on the sheet that is of
        interest; a curve ends where it leaves it.
    """
    try:
        kind = SingularityType(kind)
    except ValueError:
        raise InputError(
            f"Argument `kind` must be 'type-1' or 'type-2', but it is {kind!r}."
        ) from None
    first, second = _places(robot, axes, "axes")
    places = imposed_coordinates(robot) if imposed is None else _places(robot, imposed, "imposed")
    units = np.asarray(unknown_scales(robot))
    if len(starts) == 0:
        return []
    fixed = range(robot.n_a) if kind is SingularityType.TYPE_2 else places
    tracer = Tracer(robot, fixed, (first, second), places, box, spacing, belongs, steps)
    lanes = tracer.seeds(np.asarray(starts) / units, np.asarray(along))
    curves = tracer.trace(lanes, max_points)
    return [SingularCurve(points * units, closed) for points, closed in curves]


def _places(robot: Robot, coordinates: Sequence[int | str], field: str) -> tuple[int, ...]:
    """Places in `(q_a, q_p)` of coordinates that are given by these or by their names."""
    return tuple(
        coordinate_places(robot, [each], field)[0] if isinstance(each, str) else each
        for each in coordinates
    )


def compile_tracing(
    robot: Robot, axes: tuple[int, int], imposed: tuple[int, ...], steps: int
) -> None:
    """Compiles what `trace_curves` runs, for robots and axes like these."""
    box = np.zeros((2, 2))
    tracer = Tracer(robot, imposed, axes, imposed, box, 1.0, None, steps)
    nothing = np.full((1, robot.n_y), np.nan)
    borders = np.zeros((1, tracer.columns.shape[1]))
    tracer.correct(Lane(nothing, nothing, borders, borders, np.zeros(1, bool)), nothing)
