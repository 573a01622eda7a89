"""Grids over two platform coordinates."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from ..errors import InputError, shown
from ..robots.robot import Robot
from ..statics.reach import reaches
from ..statics.unknowns import unknown_labels, unknown_scales

_MOST = 500_000_000
"""Cells of a grid: so many take some hours and a terabyte or less."""


@dataclasses.dataclass(frozen=True)
class Grid:
    """A rectangular grid over two platform coordinates; the others are held.

    **Attributes:**

    - `axes`: the two entries of `(q_a, q_p)` that vary.
    - `names`: their names, such as `("y", "z")`.
    - `coordinates`: the values along each of them, SI units, ascending and equidistant.
    - `held`: a full `(q_a, q_p)` with the values of the other platform coordinates.
    """

    axes: tuple[int, int]
    names: tuple[str, str]
    coordinates: tuple[Float[np.ndarray, " n_0"], Float[np.ndarray, " n_1"]]
    held: Float[np.ndarray, " n_q"]

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.coordinates[0]), len(self.coordinates[1])

    @property
    def spacing(self) -> Float[np.ndarray, "2"]:
        return np.array([c[1] - c[0] for c in self.coordinates])

    @property
    def box(self) -> Float[np.ndarray, "2 2"]:
        """Lower and upper corner."""
        return np.array([[c[0] for c in self.coordinates], [c[-1] for c in self.coordinates]])

    @property
    def points(self) -> Float[np.ndarray, "n_0 n_1 2"]:
        return np.stack(np.meshgrid(*self.coordinates, indexing="ij"), axis=-1)

    def targets(self, points: Float[np.ndarray, "k 2"]) -> Float[np.ndarray, "k n_q"]:
        """Full `(q_a, q_p)` with the platform at points of the plane of the grid."""
        targets = np.tile(self.held, (len(points), 1))
        targets[:, list(self.axes)] = points
        return targets

    def nearest(self, point: Float[np.ndarray, "2"]) -> tuple[int, int]:
        """The cell nearest to a point."""
        i, j = (int(np.argmin(np.abs(c - x))) for c, x in zip(self.coordinates, point, strict=True))
        return i, j


def make_grid(
    robot: Robot,
    begin: Float[np.ndarray, " n_q"],
    spacing: float | Sequence[float] | None,
    box: Sequence[Sequence[float]] | Float[np.ndarray, "2 2"] | None,
    names: tuple[str, str] | None = None,
    mirror: bool = False,
    refine: int = 0,
) -> Grid:
    """A grid whose lines are multiples of the spacing, over a box or over all within reach.

    **Arguments:**

    - `begin`: `(q_a, q_p)`, whose entries off the axes are held where they are imposed.
    - `spacing`: along both axes or along each; by default a hundredth of their units.
    - `box`: lower and upper corner, SI units.
    - `mirror`: keep only what of it has a first coordinate that is not negative.
    - `refine`: how often the spacing is halved.
    """
    n_a = robot.n_a
    labels = [label.removeprefix("p_P_") for label in unknown_labels(robot)[n_a : n_a + robot.n_p]]
    chosen = names or tuple(labels[: robot.geometry.d][-2:])
    for name in chosen:
        if name not in labels:
            raise InputError(
                f"Argument `axes` must name platform coordinates ({', '.join(labels)}), but it "
                f"names {name!r}."
            )
    places = [labels.index(name) for name in chosen]
    if len(set(places)) != 2:
        raise InputError(f"Argument `axes` must name two coordinates, but it is {chosen!r}.")
    axes = (n_a + places[0], n_a + places[1])
    strides = _spacing(robot, axes, spacing) / 2**refine
    reach = _reachable_box(robot, begin[n_a:])
    try:
        corners = reach[:, places] if box is None else np.asarray(box, float)
    except (TypeError, ValueError):
        corners = np.empty(0)
    if corners.shape != (2, 2) or not np.all(np.isfinite(corners)):
        raise InputError(
            "Argument `box` must hold a lower and an upper corner of two finite numbers each, "
            f"but it is {shown(box)}."
        )
    if mirror:
        corners = np.array([[max(0.0, corners[0, 0]), corners[0, 1]], corners[1]])
    # A box of the user is kept to; one of all within reach is to hold the edge of the workspace.
    inward = 1.0 if box is not None else -1.0
    low, high = corners / strides + 1e-9 * inward * np.array([[-1.0], [1.0]])
    first, last = (
        (np.ceil(low), np.floor(high)) if box is not None else (np.floor(low), np.ceil(high))
    )
    first, last = first.astype(int), last.astype(int)
    if np.any(last - first < 2):
        name, expected = "box", "at least two spacings wide"
        if box is None:
            name, expected = "spacing", "at most half of what is within reach"
        raise InputError(
            f"Argument `{name}` must be {expected}, but the corners are {corners.tolist()} with a "
            f"spacing of {strides.tolist()}."
        )
    count = int(np.prod(last - first + 1.0))
    if count > _MOST:
        raise InputError(
            f"Argument `spacing` must leave at most {_MOST} cells, but {strides.tolist()} makes "
            f"{count} of them."
        )
    lines = [h * np.arange(a, b + 1) for h, a, b in zip(strides, first, last, strict=True)]
    return Grid(axes, (chosen[0], chosen[1]), (lines[0], lines[1]), np.asarray(begin, float))


def _spacing(robot: Robot, axes: tuple[int, int], spacing) -> Float[np.ndarray, "2"]:
    """The spacing along each axis."""
    if spacing is None:
        return np.asarray(unknown_scales(robot))[list(axes)] / 100.0
    try:
        strides = np.broadcast_to(np.asarray(spacing, float), (2,))
    except (TypeError, ValueError):
        strides = np.full(2, np.nan)
    if not np.all(strides > 0.0):
        raise InputError(
            f"Argument `spacing` must be positive, one number or two, but it is {spacing!r}."
        )
    return strides


def _reachable_box(robot: Robot, q_p) -> Float[np.ndarray, "2 n_p"]:
    d = robot.geometry.d
    base = np.asarray(robot.legs.base_position)
    size = reaches(robot) + np.linalg.norm(np.asarray(robot.legs.attachment_position), axis=-1)
    if not np.all(np.isfinite(size)):
        # Motors that slide or feed: a rod length around where the platform is.
        around = np.full(d, 1.0) * np.mean(np.asarray(robot.legs.rod.length))
        low, high = np.asarray(q_p)[:d] - around, np.asarray(q_p)[:d] + around
    else:
        low = np.max(base - size[:, None], axis=0)
        high = np.min(base + size[:, None], axis=0)
    spread = np.full(robot.n_p - d, np.pi / 2.0)
    middle = np.asarray(q_p)[d:]
    return np.array(
        [np.concatenate([low, middle - spread]), np.concatenate([high, middle + spread])]
    )
