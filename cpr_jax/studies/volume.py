"""Maps over three platform coordinates, slice by slice."""

import contextlib
import dataclasses
import json
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ..checks import check_kind
from ..errors import InputError, shown
from ..plain import plain
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium, check_fits, check_solved
from ..statics.problem import coordinate_places, imposed_coordinates
from ..statics.solve import solve_inverse
from ..statics.status import Status
from ..statics.unknowns import unknown_units
from .front import SeedApart
from .limits import Limits
from .parts import digest, refuse_unfinished
from .results import load_finished, save_dataset
from .versions import versions
from .workspace import workspace_map


def workspace_volume(
    robot: Robot,
    heights: Sequence[float],
    seed: Equilibrium | None = None,
    *,
    axes: tuple[str, str, str] = ("x", "y", "z"),
    imposed: Sequence[str] | None = None,
    out: str | pathlib.Path | None = None,
    **options: Any,
) -> xr.Dataset:
    """A workspace map over three platform coordinates: slices over two, at values of the third.

    Each slice starts where the branch of the seed leads along the third coordinate, so that all
    of them show one branch. A slice that the branch does not reach there, or whose grid it does not
    reach from there, counts as beyond its fold: all of its cells are NaN and say so.

    **Arguments:**

    - `heights`: values of the third axis, ascending, m or rad.
    - `seed`: an equilibrium of the branch; by default the one at the robot's home.
    - `axes`: two axes of the slices, and the third.
    - `imposed`: as in `workspace_map`, the three axes among them.
    - `out`: folder for `volume.nc`, with a folder for each slice while the run lasts.
    - `options`: of `workspace_map`; with `resume` finished slices, or a finished volume of the same
        arguments, are taken up. `box` is needed, so that all slices have the same cells.

    **Returns:** a dataset as of `workspace_map` with the third axis before the others. The
    singular curves are padded to the longest.

    **Raises:** `ValueError` for a bad argument; `SolveError` where the home has no solution.
    """
    try:
        values = np.asarray(heights, float)
    except (TypeError, ValueError):
        values = np.empty(0)
    finite = values.ndim == 1 and len(values) > 0 and np.all(np.isfinite(values))
    if not finite or not np.all(np.diff(values) > 0.0):
        raise InputError(
            f"Argument `heights` must be ascending numbers, but it is {shown(heights)}."
        )
    names = [str(name).removeprefix("p_P_") for name in axes]
    if len(set(names)) != 3 or len(names) != 3:
        raise InputError(f"Argument `axes` must name three coordinates, but it is {shown(axes)}.")
    if options.get("box") is None:
        raise InputError("Argument `box` must be given for a volume, but it is None.")
    places = imposed_coordinates(robot, imposed)
    third = coordinate_places(robot, names[2:], "axes")[0]
    if third < robot.n_a:
        raise InputError(
            f"Argument `axes` must name platform coordinates, but {names[2]} is a motor."
        )
    if third not in places:
        raise InputError(
            f"Argument `imposed` must contain the third axis, {names[2]}, but it does not."
        )
    folder = None if out is None else pathlib.Path(out)
    if folder is not None and not options.get("resume"):
        refuse_unfinished(folder, sorted(folder.glob("slice-*/map.nc")))
    if seed is None:
        if robot.home is None:
            raise InputError(
                "Argument `seed` must be given for a robot without a home configuration."
            )
        home = np.concatenate([robot.home.q_a, robot.home.q_p])
        seed = solve_inverse(robot, home[list(places)], imposed=imposed)
    limits = options.get("limits")
    if limits is not None:
        check_kind("limits", limits, Limits, "`Limits`")
    check_fits("seed", seed, robot)
    check_solved("seed", seed)
    configuration = _configuration(robot, seed, values, names, places, options)
    if folder is not None and options.get("resume"):
        finished = load_finished(folder / "volume.nc", configuration)
        if finished is not None:
            return finished

    slices: dict[int, xr.Dataset] = {}
    # From the seed outward, each from its neighbour.
    begin = np.concatenate([seed.q_a, seed.q_p])
    order = np.argsort(np.abs(values - begin[third]), kind="stable")
    starts: dict[int, Equilibrium] = {}
    for k in (int(index) for index in order):
        near = min(starts, key=lambda i: abs(i - k), default=None)
        start = seed if near is None else starts[near]
        target = np.where(np.arange(len(begin)) == third, values[k], begin)
        found = solve_inverse(
            robot, target[list(places)], imposed=imposed, guess=start, throw=False
        )
        if int(found.status) != Status.SOLVED:
            continue
        starts[k] = found
        place = None if folder is None else _slice(folder, k)
        try:
            slices[k] = workspace_map(
                robot, found, axes=(names[0], names[1]), imposed=imposed, out=place, **options
            )
        except SeedApart:
            # It is reached beside the grid only.
            if place is not None:
                with contextlib.suppress(OSError):
                    place.rmdir()
    if not slices:
        raise InputError(
            "Argument `heights` must hold a value that the branch reaches, but none is reached."
        )
    dataset = _stacked(slices, values, names[2], unknown_units(robot)[third])
    dataset.attrs["configuration"] = json.dumps(configuration, sort_keys=True)
    if folder is not None:
        save_dataset(dataset, folder / "volume.nc")
        for k in slices:
            (_slice(folder, k) / "map.nc").unlink()
            # What somebody has put there stays.
            with contextlib.suppress(OSError):
                _slice(folder, k).rmdir()
    return dataset


def _configuration(robot, seed, values, names, places, options) -> dict[str, Any]:
    """What decides every number of a volume, in a form that can be compared and stored."""
    limits = options.get("limits")
    told = {**options, "limits": None if limits is None else dataclasses.asdict(limits)}
    told.pop("resume", None)
    told.pop("progress", None)
    return {
        "robot": robot.name,
        "robot_digest": digest(robot),
        "seed_digest": digest(seed.y),
        "heights": values.tolist(),
        "axes": names,
        "imposed": list(places),
        "options": json.loads(json.dumps(plain(told), default=_listed)),
        "versions": versions(),
    }


def _listed(value: Any) -> Any:
    """What users may give in the place of a dictionary or a list."""
    return dict(value) if isinstance(value, Mapping) else list(value)


def _slice(folder: pathlib.Path, k: int) -> pathlib.Path:
    return folder / f"slice-{k:04}"


_FILL = {"status": int(Status.BEYOND_FOLD), "index": -1, "branch": -1}
"""What integers say where there is no slice."""


def _stacked(slices: dict[int, xr.Dataset], values: np.ndarray, axis: str, unit: str) -> xr.Dataset:
    """All slices along a new first dimension; those that are missing say why."""
    model = next(iter(slices.values()))
    variables: dict[str, Any] = {}
    for name in model.data_vars:
        if name == "delta":
            variables["delta"] = model["delta"]
            continue
        arrays = {k: layer[name].values for k, layer in slices.items()}
        # Singular curves differ in number and in length.
        shape = np.max([array.shape for array in arrays.values()], axis=0)
        kind = model[name].dtype
        blank = _FILL.get(str(name), np.nan if kind.kind == "f" else 0)
        full = np.full((len(values), *shape), blank, kind)
        for k, array in arrays.items():
            full[k][tuple(slice(0, size) for size in array.shape)] = array
        variables[str(name)] = ((axis, *model[name].dims), full, model[name].attrs)
    attributes = {**model.attrs, "held": json.dumps(_held(model, axis))}
    third = axis, values, {"units": unit, "long_name": f"platform coordinate {axis}"}
    return xr.Dataset(variables, {**model.coords, axis: third}, attributes)


def _held(model: xr.Dataset, axis: str) -> dict[str, float]:
    """The other coordinates that are held."""
    held = json.loads(model.attrs["held"])
    return {name: value for name, value in held.items() if name.removeprefix("p_P_") != axis}
