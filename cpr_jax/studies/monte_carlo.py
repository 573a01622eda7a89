"""Monte Carlo: where the platform ends up when the parameters vary at random."""

import enum
import os
import pathlib
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

import jax
import numpy as np
from tqdm import tqdm

from ..analysis.belonging import check_belongs
from ..analysis.ellipsoid import ellipsoid
from ..analysis.expansion import expand
from ..analysis.parameters import Selection, ranges, select
from ..analysis.sensitivity import Sensitivity, named
from ..analysis.slopes import Hold, slopes_at
from ..checks import check_kind
from ..errors import InputError, check_integer, shown
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Scheme, checked_scheme
from ..statics.accuracy import MENU, ROUGH, TOLERANCE, least_scheme
from ..statics.chord import EXACT
from ..statics.equilibrium import Equilibrium, check_fits, check_solved
from .ahead import compile_study
from .draws import Distribution
from .outcome import MonteCarlo, clopper_pearson
from .parts import Parts, digest
from .processes import gathered, gathered_tables, own_share
from .samples import CHUNK, WINDOW, Options, Prediction, Samples, Study, solve_window
from .tally import from_row, merged, tally
from .versions import versions

_SHARE = 0.1
"""Of the tolerance of the integration, what root finding may leave as a residual."""

_MOST = 2**32
"""Samples that have random numbers of their own."""

_LARGEST_SEED = 2**63 - 1

_Kind = TypeVar("_Kind", bound=enum.Enum)


def monte_carlo(
    robot: Robot,
    equilibrium: Equilibrium,
    samples: int = 2000,
    seed: int = 0,
    *,
    parameters: Sequence[str] | None = None,
    delta: Mapping[str, float] | None = None,
    distribution: Distribution | str = Distribution.GAUSSIAN,
    prediction: Prediction | str = Prediction.SECOND_ORDER,
    keep: int = 100_000,
    tolerance: float = TOLERANCE,
    steps: int | Scheme | None = None,
    folder: str | os.PathLike | None = None,
    resume: bool = False,
    save: Callable[[MonteCarlo], object] | None = None,
    progress: bool = False,
) -> MonteCarlo:
    """Solves the robot for random parameters, with the motors where the equilibrium has them.

    Each sample starts at a prediction from the nominal equilibrium. One whose corrections contract
    and end close to the prediction, the Jacobian's determinant keeping its sign, is on the branch;
    every other one is followed from the nominal parameters in steps as small as they need be, which
    tells whether the branch has an equilibrium there.

    **Arguments:**

    - `samples`, `seed`: the samples of a seed do not depend on how many there are.
    - `parameters`, `delta`: as in `sensitivity`.
    - `distribution`: `"gaussian"` with standard deviations of a third of the half ranges, as in the
        paper, or uniform in the `"ellipsoid"` (11) or the `"box"` (6).
    - `prediction`: `"tangent"` or `"second-order"`.
    - `keep`: how many samples to keep; the counts are of all of them.
    - `tolerance`: error of a rod's tip, in lengths of the rod, from which the integration steps
        and their order are chosen, unless `steps` gives them: a `Scheme`, or a number of steps of
        order 10. Root finding ends at a tenth of it, or at 1e-11 if `steps` are given.
    - `folder`: where finished windows are kept while the study runs; `resume`: go on with them.
    - `save`: is given the outcome before the finished windows are removed, so that nothing is lost
        if it cannot be written.
    - `progress`: show a progress bar on standard error.

    Batches go to all local devices, windows to all processes of `jax.distributed`, of which each
    gets the whole result; the numbers are the same. `samples_dataset` makes a labelled dataset of
    it, which `save_dataset` writes.
    """
    check_kind("robot", robot, Robot, "a Robot")
    check_integer("samples", samples, most=_MOST)
    check_integer("seed", seed, least=0, most=_LARGEST_SEED)
    check_integer("keep", keep, least=0)
    given = checked_scheme("steps", DEFAULT_STEPS if steps is None else steps)
    if not (isinstance(tolerance, float) and 0.0 < tolerance < 1.0):
        raise InputError(
            f"Argument `tolerance` must be a number between 0 and 1, but it is {shown(tolerance)}."
        )
    if resume and folder is None:
        raise InputError("Argument `folder` must be given to resume a study, but it is None.")
    check_fits("equilibrium", equilibrium, robot)
    drawn = _option(Distribution, "distribution", distribution)
    predicted = _option(Prediction, "prediction", prediction)
    check_solved("equilibrium", equilibrium)
    selection = select(robot, parameters)
    half_ranges, y = ranges(robot, selection, delta), equilibrium.y
    options = Options(selection, drawn, predicted)
    # What is not wanted beside the menu is the quickest of it.
    further = np.asarray(MENU[0] if steps is None else given)
    with compile_study(robot, options, half_ranges):
        slopes = slopes_at(robot, y, selection, DEFAULT_STEPS)
        Pi_y = slopes.answers[Hold.MOTORS.value].Pi_y
        expansion = expand(robot, selection, y, Pi_y, half_ranges, further)
        # Labels are put together while both run.
        check_belongs(robot, equilibrium, slopes.residual)
        nominal = named(robot, y, selection, half_ranges, slopes, Hold.MOTORS)
        ellipse = ellipsoid(nominal)
    _warn_of_ranges(selection, nominal)
    *errors, error = np.asarray(expansion.errors)
    scheme = given
    if steps is None:
        chosen = least_scheme(np.array(errors), tolerance)
        scheme, error = MENU[chosen], errors[chosen]
    elif error > ROUGH:
        warnings.warn(
            f"With {given} the tips of rods are off by up to {error:.1g} rod lengths, so that "
            "samples may be far away or count as lost: give finer `steps`, or none.",
            UserWarning,
            stacklevel=2,
        )
    enough = EXACT if steps is not None else max(EXACT, _SHARE * tolerance)
    study = Study(robot, y, half_ranges, expansion, np.asarray(scheme), np.asarray(enough))

    parts = _parts(folder, resume, study, options, seed, samples, keep)
    counts, kept = [], []
    starts = range(0, samples, WINDOW * CHUNK)
    with tqdm(total=samples, unit="sample", disable=not progress) as bar:
        for start in own_share(starts):
            size = min(WINDOW * CHUNK, samples - start)
            name = f"window-{start:012}"
            found = parts.load(name)
            if found is None:
                window = solve_window(study, options, ellipse, seed, start, size)
                found = {"tally": tally(window, robot.geometry.d).row()}
                if start < keep:
                    found["samples"] = _table(window)
                parts.save(name, found)
            counts.append(found["tally"])
            if start < keep:
                kept.append(found["samples"])
            bar.update(min(size * jax.process_count(), samples - bar.n))
    d, n_rho = robot.geometry.d, len(selection.labels)
    rows = gathered(np.array(counts).reshape(len(counts), 4 + d + d * d), len(starts))
    total = merged((from_row(row, d) for row in rows), d)
    width = n_rho + robot.n_p + 2
    tables = len([start for start in starts if start < keep])
    table = gathered_tables(kept, (WINDOW * CHUNK, width), tables)
    rho, q_p, status, inside = np.split(
        table[: min(keep, samples)], [n_rho, n_rho + robot.n_p, width - 1], axis=1
    )
    outcome = MonteCarlo(
        rho=rho,
        q_p=q_p,
        status=status[:, 0].astype(int),
        inside=inside[:, 0] != 0.0,
        samples=samples,
        solved=total.solved,
        lost=total.lost,
        failed=samples - total.solved - total.lost,
        coverage=total.inside / samples,
        coverage_interval=clopper_pearson(total.inside, samples),
        mean=total.mean if total.solved else np.full(d, np.nan),
        covariance=total.covariance,
        followed=total.followed,
        scheme=scheme,
        error=float(error),
        sensitivity=nominal,
        ellipsoid=ellipse,
    )
    if save is not None:
        save(outcome)
    parts.clear()
    return outcome


def _warn_of_ranges(selection: Selection, nominal: Sensitivity) -> None:
    """Says so, to whoever called the caller, where samples may lack a length or a stiffness."""
    numbers = zip(np.asarray(nominal.rho), np.asarray(nominal.delta), strict=True)
    for entry, (value, half_range) in zip(selection.entries, numbers, strict=True):
        if entry.positive and half_range > value:
            warnings.warn(
                f"The half range of {entry.label} is {half_range:g} in SI units, more than the "
                f"parameter itself, {value:g}: samples may have none of it. Check its unit.",
                UserWarning,
                stacklevel=3,
            )


def _option(kind: type[_Kind], name: str, value: object) -> _Kind:
    try:
        return kind(value)
    except ValueError:
        names = ", ".join(repr(member.value) for member in kind)
        raise InputError(
            f"Argument `{name}` must be one of {names}, but it is {value!r}."
        ) from None


def _table(window: Samples) -> np.ndarray:
    """What is kept of a window, a row a sample."""
    columns = window.rho, window.q_p, window.status[:, None], window.inside[:, None]
    return np.concatenate(columns, axis=1)


def _parts(folder, resume, study: Study, options: Options, seed, samples, keep) -> Parts:
    """Finished windows; each process has its own."""
    if folder is None:
        return Parts(None, {}, resume)
    configuration = {
        "study_digest": digest(study),
        "parameters": list(options.selection.labels),
        "distribution": options.distribution.value,
        "prediction": options.prediction.value,
        "scheme": study.scheme.tolist(),
        "seed": seed,
        "samples": samples,
        "keep": keep,
        "window": WINDOW * CHUNK,
        "processes": jax.process_count(),
        "versions": versions(),
    }
    place = pathlib.Path(folder) / f"parts-{jax.process_index()}"
    return Parts(place, configuration, resume)
