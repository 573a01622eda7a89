"""The options of a workspace map, checked; no module of numbers is imported here."""

import argparse
import dataclasses

from ..errors import InputError, shown
from ..robots.units import FORCE, LENGTH, MOMENT, Dimension, Sign
from .coordinates import Coordinates, coordinates_of
from .inputs import Request, numbers, positive_integer, quantity

_TORQUES = {
    (True,): MOMENT,
    (False,): FORCE,
    (False, True): Dimension("torque or force", ("N*m", "N"), "0.5 or '0.5 N'"),
}
"""What motors need that turn, that slide, and of which some do either."""


@dataclasses.dataclass(frozen=True)
class MapRequest:
    """The options of a workspace map, SI units; lengths and angles as the axes have them."""

    out: str
    axes: tuple[str, str] | None
    spacing: tuple[float, ...] | None
    refine: int
    box: tuple[tuple[float, float], tuple[float, float]] | None
    max_torque: float | None
    max_moment: float | None
    resume: bool


def check_map(arguments: argparse.Namespace, request: Request) -> MapRequest:
    """Checks the arguments of a workspace map of a robot."""
    coordinates = coordinates_of(request.robot)
    axes = _axes(arguments.axes, coordinates)
    over = axes or _usual_axes(coordinates)
    if not set(over) <= set(request.imposed or coordinates.platform):
        raise InputError(
            f"Argument `--imposed` must contain the axes of the map, {' and '.join(over)}, but "
            f"it is {shown(arguments.imposed)}."
        )
    dimensions = coordinates.dimensions(over)
    box = None
    if arguments.box is not None:
        a, b, c, d = numbers("--box", arguments.box, [*dimensions, *dimensions])
        box = ((a, b), (c, d))
    return MapRequest(
        out=arguments.out,
        axes=axes,
        spacing=_spacing(arguments.spacing, dimensions),
        refine=positive_integer("--refine", arguments.refine, least=0),
        box=box,
        max_torque=limit("--max-torque", arguments.max_torque, torque_of(request)),
        max_moment=limit("--max-moment", arguments.max_moment, MOMENT),
        resume=arguments.resume,
    )


def _axes(text: str | None, coordinates: Coordinates) -> tuple[str, str] | None:
    if text is None:
        return None
    names = coordinates.named("--axes", text, coordinates.platform)
    if len(names) != 2:
        raise InputError(
            f"Argument `--axes` must name two platform coordinates such as "
            f"{','.join(_usual_axes(coordinates))}, but it names {len(names)}."
        )
    return names[0], names[1]


def _usual_axes(coordinates: Coordinates) -> tuple[str, str]:
    """Those that a map has where nothing else is asked for: the last two of the position."""
    first, second = [name for name, kind in coordinates.platform.items() if kind is LENGTH][-2:]
    return first, second


def _spacing(texts: list[str] | None, dimensions: list[Dimension]) -> tuple[float, ...] | None:
    """One number for both axes, which then are of one kind, or one for each."""
    if texts is None:
        return None
    alike = dimensions[0] is dimensions[1]
    if len(texts) == 1 and alike:
        dimensions = dimensions[:1]
    return numbers("--spacing", texts, dimensions, Sign.POSITIVE)


def torque_of(request: Request) -> Dimension:
    """What the motors of a robot exert."""
    return _TORQUES[tuple(sorted(set(request.robot.turning)))]


def limit(name: str, text: str | None, dimension: Dimension) -> float | None:
    """The largest value of something that is limited, SI units, or nothing."""
    return None if text is None else quantity(name, text, dimension, Sign.POSITIVE)
