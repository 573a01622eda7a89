"""The options of a trajectory, checked; no module of numbers is imported here."""

import argparse
import dataclasses
import math
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

    - `field`: the option that gave the waypoints.
    - `names`: what is imposed, one for each number of a waypoint.
    - `plan`: the folder of a map on which the ways between waypoints are planned.
    """

    out: str
    field: str
    names: tuple[str, ...]
    waypoints: tuple[tuple[float, ...], ...]
    plan: str | None
    spacing: float | None
    max_torque: float | None
    max_moment: float | None


def check_path(arguments: argparse.Namespace, request: Request) -> PathRequest:
    """Checks the arguments of a trajectory of a robot."""
    coordinates = coordinates_of(request.robot)
    names = request.imposed or tuple(coordinates.platform)
    dimensions = coordinates.dimensions(names)
    if arguments.file is None:
        field, rows = "--via", [numbers("--via", texts, dimensions) for texts in arguments.via]
    else:
        field, rows = "--file", _read(arguments.file, names, dimensions)
    if len(rows) < 2:
        raise InputError(
            f"Argument `{field}` must give two waypoints or more, but it gives {len(rows)}."
        )
    straight = LENGTH if LENGTH in dimensions else ANGLE
    return PathRequest(
        out=arguments.out,
        field=f"`{field}`",
        names=names,
        waypoints=tuple(rows),
        plan=arguments.plan,
        spacing=_spacing(arguments.spacing, straight),
        max_torque=limit("--max-torque", arguments.max_torque, torque_of(request)),
        max_moment=limit("--max-moment", arguments.max_moment, MOMENT),
    )


def _spacing(text: str | None, dimension: Dimension) -> float | None:
    """A distance, or `inf` for the waypoints alone."""
    if text is None:
        return None
    return (
        math.inf if text.strip() == "inf" else quantity("--spacing", text, dimension, Sign.POSITIVE)
    )


def _read(
    path: str, names: tuple[str, ...], dimensions: list[Dimension]
) -> list[tuple[float, ...]]:
    """Waypoints of a file: numbers or quantities, one waypoint a line.

    After an optional header with the names of its columns, of which those that are needed count.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise InputError(
            f"Argument `--file` must be a file of waypoints, but {shown(path)} is not: {reason}."
        ) from None
    rows: list[tuple[float, ...]] = []
    columns: list[int] | None = None
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        words = _words(text)
        labels = [word.removeprefix("p_P_") for word in words]
        if columns is None and any(label in names for label in labels):
            missing = [name for name in names if name not in labels]
            if missing:
                raise InputError(
                    f"Argument `--file` must have columns {', '.join(names)}, but line {number} "
                    f"of {path} does not name {missing[0]}."
                )
            columns = [labels.index(name) for name in names]
            width = len(words)
            continue
        if columns is None:
            columns, width = list(range(len(names))), len(names)
        if len(words) != width:
            raise InputError(
                f"Argument `--file, line {number}` must be {width} numbers, but there are "
                f"{len(words)}."
            )
        texts = [words[column] for column in columns]
        rows.append(numbers(f"--file, line {number}", texts, dimensions))
    return rows


def _words(text: str) -> list[str]:
    """The fields of a line: between commas or semicolons, where quantities may have blanks."""
    if not re.search("[,;]", text):
        return text.split()
    return [word.strip().strip('"').strip() for word in re.split("[,;]", text)]
