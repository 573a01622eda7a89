"""The options of a trajectory, checked; no module of numbers is imported here."""

import argparse
import dataclasses
import re
from pathlib import Path

from ..errors import InputError, shown
from ..robots.units import ANGLE, LENGTH, MOMENT, Dimension, Sign
from .coordinates import coordinates_of
from .inputs import Request, numbers, quantity
from .map_inputs import limit, torque_of


@dataclasses.dataclass(frozen=True)
class PathRequest:
    """The options of a trajectory, SI units.

    **Attributes:**

    - `names`: what is imposed, one for each number of a waypoint.
    """

    out: str
    names: tuple[str, ...]
    waypoints: tuple[tuple[float, ...], ...]
    spacing: float | None
    max_torque: float | None
    max_moment: float | None


def check_path(arguments: argparse.Namespace, request: Request) -> PathRequest:
    """Checks the arguments of a trajectory of a robot."""
    coordinates = coordinates_of(request.robot)
    names = request.imposed or tuple(coordinates.platform)
    dimensions = coordinates.dimensions(names)
    if arguments.file is None:
        rows = [numbers("--via", texts, dimensions) for texts in arguments.via]
    else:
        rows = _read(arguments.file, names, dimensions)
    if len(rows) < 2:
        field = "--via" if arguments.file is None else "--file"
        raise InputError(
            f"Argument `{field}` must give two waypoints or more, but it gives {len(rows)}."
        )
    straight = LENGTH if LENGTH in dimensions else ANGLE
    spacing = arguments.spacing
    return PathRequest(
        out=arguments.out,
        names=names,
        waypoints=tuple(rows),
        spacing=None
        if spacing is None
        else quantity("--spacing", spacing, straight, Sign.POSITIVE),
        max_torque=limit("--max-torque", arguments.max_torque, torque_of(request)),
        max_moment=limit("--max-moment", arguments.max_moment, MOMENT),
    )


def _read(
    path: str, names: tuple[str, ...], dimensions: list[Dimension]
) -> list[tuple[float, ...]]:
    """Waypoints of a file: numbers or quantities, one waypoint a line, after an optional header."""
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise InputError(
            f"Argument `--file` must be a file of waypoints, but {shown(path)} is not: {reason}."
        ) from None
    rows: list[tuple[float, ...]] = []
    header_may_come = True
    for number, line in enumerate(lines, start=1):
        words = re.split(r"[,;\s]+", line.partition("#")[0].strip(" ,;\t"))
        if words == [""]:
            continue
        labels = [word.strip("\"'").removeprefix("p_P_") for word in words]
        if header_may_come and all(re.match(r"[A-Za-z_]", label) for label in labels):
            if tuple(labels) != tuple(names):
                raise InputError(
                    f"Argument `--file` must have the columns {', '.join(names)}, but line "
                    f"{number} of {path} names {', '.join(labels)}."
                )
        else:
            rows.append(numbers(f"--file, line {number}", words, dimensions))
        header_may_come = False
    return rows
