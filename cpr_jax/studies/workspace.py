"""The workspace map: one branch over two platform coordinates."""

import dataclasses
import json
import pathlib
import time
from collections.abc import Mapping, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
import xarray as xr
from tqdm import tqdm

from ..analysis.parameters import Selection, ranges, select
from ..analysis.singularity import SingularityType, trace_curves
from ..errors import InputError
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium, solve_inverse
from ..statics.problem import TOLERANCE
from ..statics.status import Status
from ..statics.unknowns import unknown_scales
from .ahead import compile_ahead
from .cells import Cell, look_at_cells
from .front import Front
from .grid import Grid, make_grid, out_of_reach
from .map_dataset import map_dataset
from .parallel import in_parallel
from .parts import Parts, digest
from .results import save_dataset, versions
from .symmetry import is_mirror_symmetric

_CHUNK = 1024
"""Cells looked at in one call; finished ones are kept."""

_POLISHED = 3
"""How often a cell is polished beyond the first time."""

_SAME_SHEET = 0.3
"""Largest difference of the motors, dimensionless, between a curve and the cells around it."""

_SAVE_EVERY = 2.0
"""Seconds between two states of the front that are kept."""


@dataclasses.dataclass(frozen=True)
class Limits:
    """What the robot may be asked for; cells beyond are marked, and still have their numbers.

    **Attributes** (SI units; `None` for no limit):

    - `motors`: lowest and highest position, of all motors alike, rad or m.
    - `torque`: largest motor torque, N·m (N where motors slide).
    - `moment`: largest internal moment of a rod, N·m.
    - `curvature`: largest curvature of a rod, 1/m.
    """

    motors: tuple[float, float] | None = None
    torque: float | None = None
    moment: float | None = None
    curvature: float | None = None

    def beyond(self, cells: Cell) -> np.ndarray:
        """Whether each cell is beyond some limit."""
        out = np.zeros(len(cells.energy), bool)
        if self.motors is not None:
            low, high = self.motors
            out |= np.any((cells.q_a < low) | (cells.q_a > high), axis=1)
        if self.torque is not None:
            out |= np.any(np.abs(cells.motor_torques) > self.torque, axis=1)
        if self.moment is not None:
            out |= np.asarray(cells.moment) > self.moment
        if self.curvature is not None:
            out |= np.asarray(cells.curvature) > self.curvature
        return out


def workspace_map(
    robot: Robot,
    seed: Equilibrium | None = None,
    *,
    spacing: float | None = None,
    box: Sequence[Sequence[float]] | None = None,
    axes: tuple[str, str] | None = None,
    symmetry: bool | None = None,
    parameters: Sequence[str] | None = None,
    delta: Mapping[str, float] | None = None,
    limits: Limits | None = None,
    steps: int = DEFAULT_STEPS,
    out: str | pathlib.Path | None = None,
    resume: bool = False,
    progress: bool = False,
) -> xr.Dataset:
    """Sensitivity, singularities and stability of a branch over its workspace.

    The branch is followed from the seed outward, cell by cell, never guessed: what the map shows
    is what a robot reaches by moving. Cells without an equilibrium say why.

    **Arguments:**

    - `seed`: an equilibrium of the branch to map; by default the one at the robot's home.
    - `spacing`: of the grid, m; by default a hundredth of the mean rod length.
    - `box`: lower and upper corner; by default all within reach of the legs.
    - `axes`: which two platform coordinates vary, by default the position in the plane of the
        robot; the others stay as they are in the seed.
    - `symmetry`: map only the half with a first coordinate from 0 on; by default where the robot
        is its own mirror image.
    - `parameters`, `delta`: as in `sensitivity`.
    - `limits`: see `Limits`.
    - `out`: folder for `map.nc`, and for the finished parts of a run that is interrupted.
    - `resume`: go on with those parts.
    - `progress`: show a progress bar on standard error.

    **Returns:**

    A dataset over the two coordinates (SI units, world axes), see `map_dataset`.

    **Raises:** `ValueError` for a bad argument; `SolveError` where the home has no solution.
    """
    if robot.n_a != robot.n_p:
        raise InputError(
            f"Argument `robot` must have as many motors as platform coordinates for a map, but "
            f"{robot.name} has {robot.n_a} motors and {robot.n_p} platform coordinates."
        )
    selection = select(robot, parameters)
    half_ranges = ranges(robot, selection, delta)
    if seed is not None:
        if int(seed.status) != Status.SOLVED:
            reason = Status(int(seed.status)).name
            raise InputError(f"Argument `seed` must be solved, but its status is {reason}.")
        start = seed.q_p
    elif robot.home is not None:
        start = robot.home.q_p
    else:
        raise InputError("Argument `seed` must be given for a robot without a home configuration.")
    step = float(jnp.mean(robot.legs.rod.length)) / 100.0 if spacing is None else float(spacing)
    corners = None if box is None else np.asarray(box, float)
    # Made once before anything is computed, so that mistakes are named at once.
    grid = make_grid(robot, np.asarray(start), step, corners, axes)
    ahead = compile_ahead(robot, selection, half_ranges, grid.axes, steps, coarse(steps), _CHUNK)
    try:
        if seed is None:
            seed = solve_inverse(robot, start, steps=steps)
    finally:
        for thread in ahead:
            thread.join()
    if symmetry is None:
        symmetry = box is None and is_mirror_symmetric(robot, seed, coarse(steps))
    grid = make_grid(robot, np.asarray(seed.q_p), step, corners, axes, symmetry)
    configuration = _configuration(robot, seed, grid, selection, half_ranges, limits, steps)
    folder = None if out is None else pathlib.Path(out)
    if folder is not None and resume:
        finished = _finished(folder / "map.nc", configuration)
        if finished is not None:
            return finished
    parts = Parts(None if folder is None else folder / "parts", configuration, resume)
    with tqdm(total=grid.shape[0] * grid.shape[1], unit="cell", disable=not progress) as bar:
        dataset = _map(robot, seed, grid, selection, half_ranges, limits, steps, parts, bar)
    dataset.attrs["configuration"] = json.dumps(configuration, sort_keys=True)
    if folder is not None:
        # What a kill leaves of it goes away with the parts.
        save_dataset(dataset, folder / "map.nc", scratch=parts.folder)
        parts.clear()
    return dataset


def coarse(steps: int) -> int:
    """Steps that find the cells; each is polished with all steps when it is looked at."""
    return max(2, (steps + 1) // 2)


def _configuration(robot, seed, grid, selection, delta, limits, steps) -> dict[str, Any]:
    """What decides every number of a map, in a form that can be compared and stored."""
    return {
        "robot": robot.name,
        "robot_digest": digest(robot),
        "seed_digest": digest(seed.y),
        "axes": list(grid.names),
        "box": grid.box.tolist(),
        "cells": list(grid.shape),
        "parameters": list(selection.labels),
        "delta": np.asarray(delta).tolist(),
        "limits": dataclasses.asdict(limits or Limits()),
        "steps": steps,
        "versions": versions(),
    }


def _finished(path: pathlib.Path, configuration: dict) -> xr.Dataset | None:
    """A map that is there already, if it is the same one."""
    if not path.exists():
        return None
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        stored = json.loads(dataset.attrs.get("configuration", "{}"))
        if stored != json.loads(json.dumps(configuration)):
            return None
        return dataset.load()


def _map(
    robot: Robot,
    seed: Equilibrium,
    grid: Grid,
    selection: Selection,
    delta,
    limits: Limits | None,
    steps: int,
    parts: Parts,
    bar: tqdm,
) -> xr.Dataset:
    units = np.asarray(unknown_scales(robot))
    front = Front(robot, grid, np.asarray(seed.y) / units, coarse(steps))
    front = _followed(front, parts, bar)
    solved = front.solved[front.inner].copy()
    y = front.y[front.inner] * units
    seam = front.seam()
    cells = _looked_at(robot, selection, delta, y[solved], steps, parts, bar)

    status = np.full(grid.shape, int(Status.BEYOND_FOLD), np.int8)
    status[front.stalled[front.inner]] = Status.NOT_CONVERGED
    targets = grid.targets(grid.points.reshape(-1, 2))
    far = out_of_reach(robot, targets[:, robot.n_a :]).reshape(grid.shape)
    status[far] = Status.OUT_OF_REACH
    # What polishing does not bring below the tolerance is no solution, and does not look like one.
    polished = cells.residual < TOLERANCE
    status[solved] = np.where(polished, Status.SOLVED, Status.NOT_CONVERGED)
    solved[solved] = polished
    cells = Cell(*(leaf[polished] for leaf in cells))
    if limits is not None:
        status[solved] = np.where(limits.beyond(cells), Status.BEYOND_LIMITS, Status.SOLVED)
    lines = _lines(robot, grid, y, solved, cells, steps)
    bar.update(bar.total - bar.n)
    return map_dataset(robot, grid, selection, delta, status, solved, seam, cells, lines)


def _followed(front: Front, parts: Parts, bar: tqdm) -> Front:
    known = parts.load("front")
    if known is not None:
        front.restore(known)
    saved = time.monotonic()

    def report(solved: int) -> None:
        # Half of the work is to find the cells, half to look at them.
        bar.update(solved // 2 - bar.n)

    def keep() -> None:
        nonlocal saved
        if time.monotonic() - saved > _SAVE_EVERY:
            parts.save("front", front.state())
            saved = time.monotonic()

    front.spread(report, keep)
    parts.save("front", front.state())
    return front


def _looked_at(robot, selection, delta, y, steps, parts: Parts, bar: tqdm) -> Cell:
    """The numbers of all cells, chunk by chunk; those beside a fold are polished further."""

    def look(name: str, y) -> Cell:
        known = parts.load(name)
        if known is not None:
            return Cell(**known)
        padded = np.concatenate([y, np.repeat(y[-1:], _CHUNK - len(y), axis=0)])
        looked = look_at_cells(robot, selection, delta, jnp.asarray(padded), steps)
        chunk = Cell(*(np.array(leaf)[: len(y)] for leaf in looked))
        parts.save(name, chunk._asdict())
        return chunk

    def look_at_all(name: str, y) -> Cell:
        def one(k: int) -> Cell:
            chunk = look(f"{name}-{k // _CHUNK:05}", y[k : k + _CHUNK])
            bar.update(len(chunk.residual) // 2 if name == "cells" else 0)
            return chunk

        chunks = in_parallel(one, range(0, len(y), _CHUNK))
        return Cell(*(np.concatenate(leaves) for leaves in zip(*chunks, strict=True)))

    cells = look_at_all("cells", y)
    n_a, n_q = robot.n_a, robot.n_a + robot.n_p
    for round_ in range(_POLISHED):
        rough = np.flatnonzero(~(cells.residual < TOLERANCE))
        if len(rough) == 0:
            break
        better = y[rough].copy()
        better[:, :n_a] = cells.q_a[rough]
        better[:, n_q:] = cells.mu[rough].reshape(len(rough), -1)
        polished = look_at_all(f"polished-{round_}", better)
        for leaf, part in zip(cells, polished, strict=True):
            leaf[rough] = part
    return cells


def _lines(robot, grid: Grid, y, solved, cells: Cell, steps: int) -> dict[str, list[np.ndarray]]:
    """Singular curves of both kinds on the sheet that the map shows, as points on the axes."""
    sheet = _Sheet(robot, grid, y, solved)
    sign = np.zeros(grid.shape)
    sign[solved] = np.asarray(cells.sign_t2)
    lines = {}
    for name, kind in (("t1_line", SingularityType.TYPE_1), ("t2_line", SingularityType.TYPE_2)):
        starts, along = (sheet.rim() if name == "t1_line" else sheet.crossings(sign))[:2]
        curves = trace_curves(
            robot,
            kind,
            starts * sheet.units,
            along,
            grid.axes,
            box=grid.box,
            spacing=float(np.max(grid.spacing)),
            belongs=sheet.shows,
            steps=steps,
        )
        lines[name] = [curve.y[:, list(grid.axes)] for curve in curves]
    return lines


class _Sheet:
    """The solutions of a map as a surface over its grid."""

    def __init__(self, robot: Robot, grid: Grid, y, solved) -> None:
        self.grid, self.solved, self.n_a = grid, solved, robot.n_a
        self.axes = list(grid.axes)
        self.units = np.asarray(unknown_scales(robot))
        self.y = np.where(solved[..., None], y, np.nan) / self.units

    def crossings(self, sign):
        """Middles of the edges at whose ends a sign differs, on one sheet; and their axis."""
        starts, along = [], []
        for axis in (0, 1):
            low, high = (_along(axis, part) for part in (slice(None, -1), slice(1, None)))
            gap = np.max(np.abs(self.y[low] - self.y[high])[..., : self.n_a], axis=-1)
            changes = (sign[low] * sign[high] < 0.0) & (gap < _SAME_SHEET)
            starts.append(0.5 * (self.y[low] + self.y[high])[changes])
            along.append(np.full(len(starts[-1]), axis))
        return np.concatenate(starts), np.concatenate(along)

    def rim(self):
        """Solved cells beside an unsolved one within the grid, and the axis across."""
        starts, along = [], []
        for axis in (0, 1):
            for side in (-1, 1):
                beside = np.roll(self.solved, -side, axis=axis)
                beside[_along(axis, slice(-1, None) if side == 1 else slice(0, 1))] = True
                starts.append(self.y[self.solved & ~beside])
                along.append(np.full(len(starts[-1]), axis))
        return np.concatenate(starts), np.concatenate(along)

    def shows(self, z: np.ndarray) -> np.ndarray:
        """Whether points of curves lie on the sheet that the cells around them are on."""
        places = z[:, self.axes] * self.units[self.axes]
        origin, spacing = self.grid.box[0], self.grid.spacing
        nearest = np.rint((places - origin) / spacing).astype(int)
        best = np.full(len(z), np.inf)
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                cell = np.clip(nearest + np.array([i, j]), 0, np.array(self.grid.shape) - 1)
                # Wrenches change like a square root beside a fold, motors less.
                there = self.y[cell[:, 0], cell[:, 1], : self.n_a]
                gap = np.max(np.abs(there - z[:, : self.n_a]), axis=1)
                best = np.fmin(best, np.where(np.isnan(gap), np.inf, gap))
        return best < _SAME_SHEET


def _along(axis: int, part: slice) -> tuple[slice, slice]:
    """An index that cuts one of two axes."""
    return (part, slice(None)) if axis == 0 else (slice(None), part)
