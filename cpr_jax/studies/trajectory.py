"""A trajectory: one branch along a path, with all that a robot meets on its way."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from jaxtyping import Array, Bool, Float

from ..analysis.parameters import Selection, selected
from ..checks import check_kind, check_positive, check_shape, finite_rows
from ..errors import check_integer
from ..parallel import in_parallel, padded
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium, check_fits
from ..statics.problem import imposed_coordinates, imposed_rows
from ..statics.reach import out_of_reach, used_up
from ..statics.roots import TOLERANCE
from ..statics.solve import solve_inverse
from ..statics.status import Status
from ..statics.stops import visit
from ..statics.unknowns import unknown_labels
from .ahead import compile_trajectory
from .cells import Cell, look_at_cells, polished, warn_of_steps
from .limits import Limits
from .polygon import Polygon
from .trajectory_dataset import Along, changes, trajectory_dataset

CHUNK = 128
"""Stops looked at in one call, as many as cells of a small map: both share a program."""

_CLOSER = 64
"""Parts of the way between two stops where something happens."""

_TAUT = 0.999
"""How much of its reach a leg spans where it is too short for what comes: as it straightens its
tension grows without bound, and the branch is lost a little before."""


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
        robot's home. A path that was planned on a map from a seed of its own begins there.
    - `imposed`: which coordinates `waypoints` holds, as in `solve_inverse`; `("q1", "q2")` makes a
        path of the motors. By default all of the platform's.
    - `spacing`: largest distance of two stops, m, in which a radian counts as the mean length of a
        rod; in radians where only angles are imposed. By default a hundredth of the mean length of
        a rod, or of a radian. It decides what is returned, and `inf` returns the waypoints alone:
        `events` are looked for at the usual distance at least.
    - `parameters`, `delta`: as in `sensitivity`. A robot without uncertainties has a trajectory
        without sensitivities.
    - `limits`: see `Limits`.

    **Returns:**

    A dataset over `s`, the distance along the path; its variables are those of a `workspace_map`.

    **Raises:** `ValueError` for a bad argument; `SolveError` where the first waypoint has no
    solution.
    """
    check_kind("robot", robot, Robot, "a Robot")
    places = imposed_coordinates(robot, imposed)
    selection, half_ranges = selected(robot, parameters, delta)
    if seed is not None:
        check_fits("seed", seed, robot)
    if limits is not None:
        check_kind("limits", limits, Limits, "`Limits`")
        limits.check_fits(robot)
    check_integer("steps", steps)
    if spacing is not None:
        check_shape("spacing", spacing, ())
        check_positive("spacing", spacing)
    labels = [unknown_labels(robot)[place] for place in places]
    corners = finite_rows("waypoints", waypoints, labels, least=2)
    line = Polygon.of(robot, corners, places, spacing)
    stops = np.zeros((len(line.points), robot.n_a + robot.n_p))
    stops[:, places] = line.points

    rows = imposed_rows(robot, places)
    with compile_trajectory(robot, rows, selection, half_ranges, places, steps, CHUNK) as ahead:
        first = solve_inverse(robot, corners[0], imposed=imposed, guess=seed, steps=steps)
        ahead.wait("visit")
        task = _Task(robot, rows, places, selection, half_ranges, limits, steps)
        y, end = task.follow(np.asarray(first.y), stops)
        ahead.wait("look")
        cells = task.look(y)
        found = task.events(line.s, stops, y, cells)
        status = np.full(len(stops), int(Status.SOLVED), np.int8)
        status[: len(y)][task.beyond(cells)] = Status.BEYOND_LIMITS
        # What polishing does not bring below the tolerance is no solution.
        status[: len(y)][~(cells.residual < TOLERANCE)] = Status.NOT_CONVERGED
        reached = float(line.s[-1])
        if end is not None:
            k = len(y) - 1
            stride = float(line.s[k + 1] - line.s[k])
            found += task.changes(line.s[k] + stride * end.shares, task.look(end.y))
            status[len(y) :] = end.status
            reached = float(line.s[k] + stride * end.progress)
            found.append({"s": reached, "event": "end", "status": end.status.name.lower()})
    kept = line.shown
    there = kept[: len(y)] & (status[: len(y)] != Status.NOT_CONVERGED)
    along = Along(
        s=line.s[kept],
        points=line.points[kept],
        at_corner=line.at_corner[kept],
        status=status[kept],
        unit=line.unit,
        places=places,
        reached=reached,
        events=found,
        cells=Cell(*(leaf[there] for leaf in cells)),
    )
    warn_of_steps(np.asarray(along.cells.tip_error), steps)
    return trajectory_dataset(robot, selection, np.asarray(half_ranges), along)


class _End(NamedTuple):
    """What was found between the last stop and where the branch ends.

    **Attributes:**

    - `y`, `shares`: equilibria on the way to the next stop, and how much of it they have gone.
    - `progress`: how much of that way there is.
    - `status`: why no more.
    """

    y: Float[np.ndarray, "k n_y"]
    shares: Float[np.ndarray, " k"]
    progress: float
    status: Status


class _Task(NamedTuple):
    """What is asked of the stops."""

    robot: Robot
    imposed: Float[Array, "n_a n_q"]
    places: tuple[int, ...]
    selection: Selection
    delta: Float[Array, " n_rho"]
    limits: Limits | None
    steps: int

    def follow(self, start, stops) -> tuple[Float[np.ndarray, "reached n_y"], _End | None]:
        """Unknowns at the stops that are reached, and how the branch ends if it does."""
        y = start[None]
        while len(y) < len(stops):
            visited = visit(self.robot, self.imposed, y[-1], stops[len(y) :], self.steps)
            y = np.concatenate([y, visited.y])
            gone = np.flatnonzero(self._gone(y))
            y = y[: gone[0]] if len(gone) else y
            if len(y) < len(stops):
                end = self._closely(y[-1], stops[len(y) - 1], stops[len(y)])
                if end.status != Status.SOLVED:
                    return y, end
                y = np.concatenate([y, end.y[-1:]])
        return y, None

    def _closely(self, y, begin, goal) -> _End:
        """From one stop towards the next, in steps as small as events are told."""
        shares = np.linspace(0.0, 1.0, _CLOSER + 1)
        between = begin + shares[:, None] * (goal - begin)
        visited = visit(self.robot, self.imposed, y, between[1:], self.steps)
        found = np.concatenate([y[None], visited.y])
        status, progress = visited.status, (len(visited.y) + visited.progress) / _CLOSER
        gone = np.flatnonzero(self._gone(found))
        if len(gone):
            found, status = found[: gone[0]], Status.OUT_OF_REACH
            progress = float(shares[gone[0] - 1])
        elif status == Status.LOST:
            there = (begin + progress * (goal - begin))[None]
            taut = out_of_reach(self.robot, there, self.places, _TAUT)[0]
            status = Status.OUT_OF_REACH if taut else Status.BEYOND_FOLD
        elif status == Status.SOLVED:
            progress = 1.0
        return _End(found, shares[: len(found)], progress, status)

    def _gone(self, y) -> Bool[np.ndarray, " stops"]:
        return np.asarray(used_up(self.robot, y[:, : self.robot.n_a]))

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
        for k in np.flatnonzero(differ):
            closer = self._closely(y[k], stops[k], stops[k + 1])
            stride = s[k + 1] - s[k]
            found += self.changes(s[k] + stride * closer.shares, self.look(closer.y))
        return found

    def changes(self, s, cells: Cell) -> list[dict[str, Any]]:
        """What happens between equilibria that are close together."""
        return changes(s, cells, self.beyond(cells))
