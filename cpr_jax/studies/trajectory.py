"""A trajectory: one branch along a path, with all that a robot meets on its way."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from jaxtyping import Array, Bool, Float

from ..analysis.parameters import Selection, ranges, select
from ..checks import check_positive
from ..errors import InputError, check_integer, shown
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium, check_fits, solve_inverse
from ..statics.problem import imposed_coordinates, imposed_rows
from ..statics.reach import out_of_reach, used_up
from ..statics.status import Status
from ..statics.stops import visit
from ..statics.unknowns import unknown_labels, unknown_scales, unknown_units
from .ahead import compile_trajectory
from .cells import Cell, look_at_cells, polished
from .limits import Limits
from .parallel import in_parallel, padded
from .trajectory_dataset import Along, changes, trajectory_dataset

CHUNK = 128
"""Stops looked at in one call, as many as cells of a small map: both share a program."""

_CLOSER = 64
"""Parts of the way between two stops where something happens."""

_MOST = 1_000_000
"""Stops of a path: so many take a quarter of an hour and some gigabytes."""


def trajectory(
    robot: Robot,
    waypoints: Sequence[Sequence[float]] | Float[np.ndarray, "waypoints n_a"],
    seed: Equilibrium | None = None,
    *,
    imposed: Sequence[str] | None = None,
    spacing: float | None = None,
    parameters: Sequence[str] | None = None,
    delta: Mapping[str, float] | None = None,
    limits: Limits | None = None,
    steps: int = DEFAULT_STEPS,
) -> xr.Dataset:
    """What a robot goes through on a path: motors, torques, sensitivity, stability, singularities.

    The branch is followed along straight lines between waypoints, never guessed, and looked at in
    stops along them. Where it ends, the stops behind say why. Platform and motors move slowly:
    every stop is an equilibrium.

    A robot can take the path as far as it is stable: where a direction becomes unstable, it jumps
    off, whatever its motors do. `events` names such places, ends and limits.

    **Arguments:**

    - `waypoints`: values of the imposed coordinates, SI units; at least two.
    - `seed`: an equilibrium from which the branch is followed to the first waypoint; by default the
        robot's home.
    - `imposed`: which coordinates `waypoints` holds, as in `solve_inverse`; `("q1", "q2")` makes a
        path of the motors. By default all of the platform's.
    - `spacing`: largest distance of two stops, m, in which a radian counts as the mean length of a
        rod; in radians where only angles are imposed. By default a hundredth of either.
    - `parameters`, `delta`: as in `sensitivity`. A robot without uncertainties has a trajectory
        without sensitivities.
    - `limits`: see `Limits`.

    **Returns:**

    A dataset over `s`, the distance along the path; its variables are those of a `workspace_map`.

    **Raises:** `ValueError` for a bad argument; `SolveError` where the first waypoint has no
    solution.
    """
    places = imposed_coordinates(robot, imposed)
    certain = parameters is None and not robot.uncertainty
    selection = Selection(()) if certain else select(robot, parameters)
    half_ranges = ranges(robot, selection, delta)
    if seed is not None:
        check_fits("seed", seed, robot)
    if limits is not None and not isinstance(limits, Limits):
        raise InputError(f"Argument `limits` must be `Limits`, but it is {shown(limits)}.")
    check_integer("steps", steps)
    if spacing is not None:
        check_positive("spacing", spacing)
    corners = _checked(robot, waypoints, places)
    unit, weights = _distance(robot, places)
    s, points, at_corner = _stops(corners, weights, spacing or float(0.01 * np.max(weights)))
    stops = np.zeros((len(points), robot.n_a + robot.n_p))
    stops[:, places] = points

    imposed_by = imposed_rows(robot, places)
    with compile_trajectory(
        robot, imposed_by, selection, half_ranges, places, steps, CHUNK
    ) as ahead:
        first = solve_inverse(robot, corners[0], imposed=imposed, guess=seed, steps=steps)
        start = np.asarray(first.y)
        ahead.wait("visit")
        visited = visit(robot, imposed_by, start, stops[1:], steps)
        y = np.concatenate([start[None], visited.y])
        gone = np.flatnonzero(used_up(robot, y[:, : robot.n_a]))
        y = y[: gone[0]] if len(gone) else y
        ahead.wait("look")
        task = _Task(robot, imposed_by, places, selection, half_ranges, limits, steps)
        cells = task.look(y)
        found = task.events(s, stops, y, cells)

    ends = Status.OUT_OF_REACH if len(gone) else visited.status
    if ends == Status.LOST:
        ends = Status.BEYOND_FOLD
    status = np.full(len(s), int(ends), np.int8)
    status[out_of_reach(robot, stops, places)] = Status.OUT_OF_REACH
    status[: len(y)] = np.where(task.beyond(cells), Status.BEYOND_LIMITS, Status.SOLVED)
    reached = float(s[len(y) - 1])
    if len(y) < len(s):
        reached += (0.0 if len(gone) else visited.progress) * float(s[len(y)] - reached)
        found.append({"s": reached, "event": "end", "status": Status(status[len(y)]).name.lower()})
    along = Along(s, unit, points, places, at_corner, status, reached, found, cells)
    return trajectory_dataset(robot, selection, np.asarray(half_ranges), along)


class _Task(NamedTuple):
    """What is asked of the stops."""

    robot: Robot
    imposed: Float[Array, "n_a n_q"]
    places: tuple[int, ...]
    selection: Selection
    delta: Float[Array, " n_rho"]
    limits: Limits | None
    steps: int

    def look(self, y: Float[np.ndarray, "stops n_y"]) -> Cell:
        """The numbers of stops."""

        def one(some) -> Cell:
            lanes = padded(some, CHUNK)
            looked = look_at_cells(
                self.robot, self.selection, self.delta, lanes, self.places, self.steps
            )
            return Cell(*(np.array(leaf)[: len(some)] for leaf in looked))

        def all_of(y, _: int = 0) -> Cell:
            chunks = in_parallel(one, [y[k : k + CHUNK] for k in range(0, len(y), CHUNK)])
            return Cell(*(np.concatenate(leaves) for leaves in zip(*chunks, strict=True)))

        return polished(all_of, all_of(y))

    def beyond(self, cells: Cell) -> Bool[np.ndarray, " stops"]:
        """Which are beyond a limit."""
        none = np.zeros(len(cells.energy), bool)
        return none if self.limits is None else self.limits.beyond(cells)

    def events(self, s, stops, y, cells: Cell) -> list[dict[str, Any]]:
        """What happens between stops, each place looked at closely, and with what it begins."""
        beyond, index = self.beyond(cells), np.asarray(cells.unstable)
        found: list[dict[str, Any]] = []
        if index[0] > 0:
            found.append({"s": 0.0, "event": "unstable", "index": int(index[0])})
        if beyond[0]:
            found.append({"s": 0.0, "event": "beyond limits"})
        differ = (beyond[1:] != beyond[:-1]) | ((index[1:] > 0) != (index[:-1] > 0))
        differ |= cells.sign_t2[1:] != cells.sign_t2[:-1]
        share = np.linspace(0.0, 1.0, _CLOSER + 1)[:, None]
        for k in np.flatnonzero(differ):
            between = (1.0 - share) * stops[k] + share * stops[k + 1]
            visited = visit(self.robot, self.imposed, y[k], between[1:], self.steps)
            closer = self.look(np.concatenate([y[k : k + 1], visited.y]))
            places = s[k] + share[: len(closer.energy), 0] * (s[k + 1] - s[k])
            found += changes(places, closer, self.beyond(closer))
        return found


def _checked(robot: Robot, waypoints, places: tuple[int, ...]) -> Float[np.ndarray, "k n_a"]:
    names = ", ".join(unknown_labels(robot)[place] for place in places)
    try:
        corners = np.asarray(waypoints, float)
    except (TypeError, ValueError):
        corners = np.empty(0)
    if corners.ndim != 2 or len(corners) < 2 or corners.shape[1] != len(places):
        raise InputError(
            f"Argument `waypoints` must be at least two rows of {len(places)} numbers ({names}), "
            f"but it is {shown(waypoints)} of shape {np.shape(corners)}."
        )
    if not np.all(np.isfinite(corners)):
        raise InputError("Argument `waypoints` must be finite, but some of it is not.")
    return corners


def _distance(robot: Robot, places: tuple[int, ...]) -> tuple[str, Float[np.ndarray, " n_a"]]:
    """The unit of distances, and what a unit of each imposed coordinate counts in it."""
    units = [unknown_units(robot)[place] for place in places]
    if "m" not in units:
        return "rad", np.ones(len(places))
    length = float(np.asarray(unknown_scales(robot))[robot.n_a])
    return "m", np.array([1.0 if unit == "m" else length for unit in units])


def _stops(corners, weights, spacing: float):
    """Distances along a polygon, the points there, and which of them are corners."""
    moves = np.diff(corners, axis=0)
    lengths = np.linalg.norm(moves * weights, axis=1)
    if not np.any(lengths > 0.0):
        raise InputError("Argument `waypoints` must be different points, but they are one.")
    counts = np.ceil(lengths / spacing - 1e-9)
    if np.sum(counts) > _MOST:
        raise InputError(
            f"Argument `spacing` must leave at most {_MOST} stops, but {spacing:g} makes "
            f"{np.sum(counts):.0f} of them on a path of {np.sum(lengths):g}."
        )
    counts = counts.astype(int)
    shares = [np.arange(1, count + 1)[:, None] / max(count, 1) for count in counts]
    begins = np.concatenate([[0.0], np.cumsum(lengths)])
    points = [corners[:1]]
    s, at_corner = [np.zeros(1)], [np.ones(1, bool)]
    for k, share in enumerate(shares):
        points.append((1.0 - share) * corners[k] + share * corners[k + 1])
        s.append(begins[k] + share[:, 0] * lengths[k])
        at_corner.append(share[:, 0] == 1.0)
    return np.concatenate(s), np.concatenate(points), np.concatenate(at_corner)
