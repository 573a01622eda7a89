"""The workspace map: one branch over two platform coordinates."""

import dataclasses
import json
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from tqdm import tqdm

from ..analysis.parameters import selected
from ..checks import check_kind
from ..errors import InputError, check_integer, shown
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium, check_fits, check_solved
from ..statics.problem import imposed_coordinates, imposed_rows
from ..statics.reach import out_of_reach
from ..statics.roots import TOLERANCE
from ..statics.solve import solve_inverse
from ..statics.status import Status
from ..statics.unknowns import unknown_scales
from .ahead import compile_map
from .cells import Cell, warn_of_steps
from .follower import Follower
from .front import Front, SeedApart
from .grid import make_grid
from .limits import Limits
from .map_dataset import Found, map_dataset
from .parts import Parts, digest
from .refinement import refined, representatives
from .results import load_finished, save_dataset
from .sheet import singular_lines
from .stages import Job, cells_and_seam, follow
from .symmetry import is_mirror_symmetric
from .versions import versions

_CHUNK = 1024
"""Cells looked at in one call, on small grids an eighth of them; finished ones are kept."""

_MANY = 5_000_000
"""Cells from which on it pays to compile for longer what follows them: 5 to 9 s, to spare a sixth
of 8 s for each million."""

_FINEST = 6
"""How often a spacing may be halved."""


def workspace_map(
    robot: Robot,
    seed: Equilibrium | None = None,
    *,
    spacing: float | Sequence[float] | None = None,
    refine: int = 0,
    box: Sequence[Sequence[float]] | None = None,
    axes: tuple[str, str] | None = None,
    imposed: Sequence[str] | None = None,
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
    - `spacing`: of the grid along both axes or along each, m or rad; by default a hundredth of the
        mean rod length, or of a radian.
    - `refine`: how often the spacing is halved where the sensitivity (σ of A_p, if nothing varies)
        changes fast and where the branch ends; cells elsewhere stand for the block around them, see
        `level`.
    - `box`: lower and upper corner; by default all within reach of the legs, or a mean rod length
        around the seed if that of one has no end (motors that slide, rods that are fed or stretch);
        a quarter of a turn around the seed along rotations.
    - `axes`: which two platform coordinates vary, by default the position in the plane of the
        robot; the others stay as they are in the seed.
    - `imposed`: names of the coordinates that the motors impose, the axes among them, as in
        `solve_inverse`; by default all of the platform's. What is not imposed follows freely.
    - `symmetry`: map only the half with a first coordinate from 0 on; by default where the robot
        is its own mirror image, and so are its ranges and limits.
    - `parameters`, `delta`: as in `sensitivity`. A robot without uncertainties has a map without
        sensitivities.
    - `limits`: see `Limits`.
    - `steps`: integration steps along each rod; `tip_error` tells what they leave, and a warning
        where that is much.
    - `out`: folder for `map.nc`, and for the finished parts of a run that is interrupted.
    - `resume`: go on with those parts.
    - `progress`: show a progress bar on standard error.

    **Returns:**

    A dataset over the two coordinates (SI units, world axes), see `map_dataset`.

    **Raises:** `ValueError` for a bad argument; `SolveError` where the home has no solution.
    """
    check_kind("robot", robot, Robot, "a Robot")
    places = imposed_coordinates(robot, imposed)
    selection, half_ranges = selected(robot, parameters, delta)
    if seed is not None:
        check_fits("seed", seed, robot)
        check_solved("seed", seed)
        begin = np.concatenate([seed.q_a, seed.q_p])
    elif robot.home is not None:
        begin = np.concatenate([robot.home.q_a, robot.home.q_p])
    else:
        raise InputError("Argument `seed` must be given for a robot without a home configuration.")
    check_integer("refine", refine, least=0, most=_FINEST)
    check_integer("steps", steps)
    if resume and out is None:
        raise InputError("Argument `out` must be given to resume a map, but it is None.")
    # Made once before anything is computed, so that mistakes are named at once.
    grid = make_grid(robot, begin, spacing, box, axes, refine=refine)
    if not set(grid.axes) <= set(places):
        raise InputError(
            f"Argument `imposed` must contain the axes of the map, {' and '.join(grid.names)}, "
            f"but it is {shown(imposed)}."
        )
    if limits is not None:
        check_kind("limits", limits, Limits, "`Limits`")
        limits.check_fits(robot)
    chunk = _CHUNK if grid.shape[0] * grid.shape[1] > 4 * _CHUNK else _CHUNK // 8
    folder = None if out is None else pathlib.Path(out)
    many = grid.shape[0] * grid.shape[1] > _MANY
    follower = Follower(robot, imposed_rows(robot, places), grid.axes, steps, many)
    needs = follower, selection, half_ranges, places, steps, chunk, seed is None
    with compile_map(*needs) as ahead:
        if seed is None:
            seed = solve_inverse(robot, begin[list(places)], imposed=imposed, steps=steps)
        ahead.wait("follow")
        if symmetry is None:
            uncertain = selection, np.asarray(half_ranges), limits
            symmetry = box is None and is_mirror_symmetric(follower, seed, grid, places, *uncertain)
        begin = np.concatenate([seed.q_a, seed.q_p])
        grid = make_grid(robot, begin, spacing, box, axes, symmetry, refine)
        configuration = _configuration(
            robot, seed, grid, places, selection, half_ranges, limits, steps, refine
        )
        if folder is not None and resume:
            finished = load_finished(folder / "map.nc", configuration)
            if finished is not None:
                return finished
        place = None if folder is None else folder / "parts"
        parts = Parts(place, configuration, resume, "out")
        job = Job(
            robot,
            seed,
            grid,
            places,
            selection,
            half_ranges,
            limits,
            steps,
            refine,
            parts,
            follower,
            ahead,
            chunk,
        )
        with tqdm(total=grid.shape[0] * grid.shape[1], unit="cell", disable=not progress) as bar:
            try:
                dataset = _map(job, bar)
            except SeedApart:
                # There is nothing to go on with.
                parts.clear()
                raise
    warn_of_steps(dataset["tip_error"].values, steps)
    dataset.attrs["configuration"] = json.dumps(configuration, sort_keys=True)
    if folder is not None:
        # What a kill leaves of it goes away with the parts.
        save_dataset(dataset, folder / "map.nc", scratch=parts.folder)
        parts.clear()
    return dataset


def _configuration(
    robot, seed, grid, imposed, selection, delta, limits, steps, refine
) -> dict[str, Any]:
    """What decides every number of a map, in a form that can be compared and stored."""
    return {
        "robot": robot.name,
        "robot_digest": digest(robot),
        "seed_digest": digest(seed.y),
        "axes": list(grid.names),
        "imposed": list(imposed),
        "box": grid.box.tolist(),
        "cells": list(grid.shape),
        "parameters": list(selection.labels),
        "delta": np.asarray(delta).tolist(),
        "limits": dataclasses.asdict(limits or Limits()),
        "steps": steps,
        "refine": refine,
        "versions": versions(),
    }


def _map(job: Job, bar: tqdm) -> xr.Dataset:
    robot, seed, grid, imposed, selection, delta, limits, steps, refine, _, follower, ahead, _ = job
    units = np.asarray(unknown_scales(robot))
    front = Front(follower, grid, np.asarray(seed.y) / units, 2**refine)
    wanted, looked, seen = {}, [], np.zeros_like(front.solved)
    seam = np.zeros(grid.shape, bool)
    size = np.full(front.solved.shape, np.nan)
    for level in range(refine + 1):
        stride = job.stride(level)
        wanted[stride] = front.wanted
        follow(job, front, bar, level)
        new = front.solved & ~seen
        ahead.wait("look")
        cells, beside = cells_and_seam(job, front, new, bar, level)
        seam |= beside
        if cells is not None:
            looked.append((np.flatnonzero(new[front.inner]), cells))
            seen |= new
            size[new] = cells.semi_axes[:, 0] if selection.entries else cells.sigma_t2
        if stride > 1:
            front.wanted = refined(front, size, stride)
    order = np.argsort(np.concatenate([places for places, _ in looked]))
    cells = Cell(
        *(np.concatenate(leaf)[order] for leaf in zip(*(c for _, c in looked), strict=True))
    )
    solved = front.solved[front.inner].copy()
    y = front.y[front.inner] * units

    status = front.ended()
    targets = grid.targets(grid.points.reshape(-1, 2))
    far = out_of_reach(robot, targets, imposed).reshape(grid.shape)
    status[far] = Status.OUT_OF_REACH
    # What polishing does not bring below the tolerance is no solution, and does not look like one.
    kept = cells.residual < TOLERANCE
    status[solved] = np.where(kept, int(Status.SOLVED), int(Status.NOT_CONVERGED))
    solved[solved] = kept
    cells = Cell(*(leaf[kept] for leaf in cells))
    if limits is not None:
        status[solved] = np.where(limits.beyond(cells), Status.BEYOND_LIMITS, Status.SOLVED)
    stands_for, levels = representatives(front, wanted)
    sign = np.zeros(grid.shape)
    sign[solved] = cells.sign_t2
    ahead.wait("lines")
    shown_y, shown_sign = y[stands_for], sign[stands_for]
    lines = singular_lines(robot, grid, imposed, shown_y, solved[stands_for], shown_sign, steps)
    bar.update(bar.total - bar.n)
    found = Found(status, solved, seam, cells, stands_for, levels)
    return map_dataset(robot, grid, imposed, selection, np.asarray(delta), found, lines)
