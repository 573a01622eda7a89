"""Monte Carlo: where the platform ends up when the parameters vary at random."""

import enum
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float
from scipy.special import betaincinv
from tqdm import tqdm

from ..analysis.ellipsoid import Ellipsoid, ellipsoid
from ..analysis.expansion import expand
from ..analysis.parameters import ranges, select
from ..analysis.sensitivity import Sensitivity, sensitivity
from ..errors import InputError
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.accuracy import TOLERANCE, error_with, steps_for
from ..statics.equilibrium import Equilibrium
from ..statics.status import Status
from .draws import Distribution
from .samples import CHUNK, WINDOW, Options, Prediction, Samples, Study, solve_window

_Kind = TypeVar("_Kind", bound=enum.Enum)


class MonteCarlo(NamedTuple):
    """Outcome of a Monte Carlo study with the motors held.

    **Attributes** (SI units; `kept` samples of all `samples`, the first ones):

    - `rho`: parameters, shape `(kept, n_ρ)`.
    - `q_p`: platform coordinates, NaN where not solved, shape `(kept, n_p)`.
    - `status`: `Status` codes, shape `(kept,)`.
    - `inside`: whether the platform is inside the ellipsoid, shape `(kept,)`.
    - `samples`, `solved`, `lost`, `failed`: how many in all; solved; without an equilibrium on
        the branch (beyond a Type 2 singularity); without an answer. Their sum is `samples`.
    - `coverage`: share of all samples inside the ellipsoid; lost samples are not inside.
    - `coverage_interval`: its exact 95 % confidence interval (Clopper–Pearson).
    - `mean`, `covariance`: of the solved positions.
    - `followed`: samples whose branch was followed step by step to be sure of it.
    - `steps`, `error`: integration steps along each rod, and the estimated error of its tip
        that they leave where the parameters are at the ends of their ranges, in rod lengths.
    - `sensitivity`, `ellipsoid`: the linear theory they are compared with.
    """

    rho: Float[np.ndarray, "kept n_rho"]
    q_p: Float[np.ndarray, "kept n_p"]
    status: np.ndarray
    inside: np.ndarray
    samples: int
    solved: int
    lost: int
    failed: int
    coverage: float
    coverage_interval: tuple[float, float]
    mean: Float[np.ndarray, " d"]
    covariance: Float[np.ndarray, "d d"]
    followed: int
    steps: int
    error: float
    sensitivity: Sensitivity
    ellipsoid: Ellipsoid


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
    steps: int | None = None,
    progress: bool = False,
) -> MonteCarlo:
    """Solves the robot for random parameters, with the motors where the equilibrium has them.

    Each sample starts at a prediction from the nominal equilibrium. One that converges fast and
    close to its prediction, the Jacobian's determinant keeping its sign, is on the branch; every
    other one is followed from the nominal parameters in steps as small as they need be, which
    tells whether the branch has an equilibrium there.

    **Arguments:**

    - `samples`, `seed`: the samples of a seed do not depend on how many there are.
    - `parameters`, `delta`: as in `sensitivity`.
    - `distribution`: `"gaussian"`, `"ellipsoid"` or `"box"`.
    - `prediction`: `"tangent"` or `"second-order"`.
    - `keep`: how many samples to keep; the counts are of all of them.
    - `tolerance`: error of a rod's tip, in lengths of the rod, from which the number of
        integration steps is chosen, unless `steps` gives it.
    - `progress`: show a progress bar on standard error.
    """
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 1:
        raise InputError(f"Argument `samples` must be a positive integer, but it is {samples!r}.")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError(f"Argument `seed` must be an integer from 0 on, but it is {seed!r}.")
    drawn = _option(Distribution, "distribution", distribution)
    predicted = _option(Prediction, "prediction", prediction)
    if int(equilibrium.status) != Status.SOLVED:
        raise InputError(
            "Argument `equilibrium` must be solved, but its status is "
            f"{Status(int(equilibrium.status)).name}."
        )
    selection = select(robot, parameters)
    half_ranges = ranges(robot, selection, delta)
    nominal = sensitivity(robot, equilibrium, parameters, delta)
    ellipse = ellipsoid(nominal)
    expansion = expand(robot, selection, nominal.y, nominal.Pi_y, half_ranges, DEFAULT_STEPS)
    study = Study(robot, nominal.y, half_ranges, expansion, ellipse)
    error = float(expansion.error)
    if steps is None:
        steps = steps_for(error, tolerance)
    options = Options(selection, drawn, predicted, steps)

    tally = _Tally(robot.geometry.d)
    kept: list[Samples] = []
    with tqdm(total=samples, unit="sample", disable=not progress) as bar:
        for start in range(0, samples, WINDOW * CHUNK):
            size = min(WINDOW * CHUNK, samples - start)
            window = solve_window(study, options, seed, start, size)
            tally.add(window)
            if start < keep:
                kept.append(Samples(*(part[: keep - start] for part in window)))
            bar.update(size)

    rho, q_p, status, inside, _ = (np.concatenate(parts) for parts in zip(*kept, strict=True))
    return MonteCarlo(
        rho=rho,
        q_p=q_p,
        status=status,
        inside=inside,
        samples=samples,
        solved=tally.solved,
        lost=tally.lost,
        failed=samples - tally.solved - tally.lost,
        coverage=tally.inside / samples,
        coverage_interval=clopper_pearson(tally.inside, samples),
        mean=tally.mean,
        covariance=tally.covariance,
        followed=tally.followed,
        steps=steps,
        error=error_with(error, steps),
        sensitivity=nominal,
        ellipsoid=ellipse,
    )


def clopper_pearson(hits: int, trials: int) -> tuple[float, float]:
    """Exact 95 % confidence interval of a probability (Clopper and Pearson, 1934)."""
    misses = trials - hits
    low = betaincinv(hits, misses + 1, 0.025) if hits else 0.0
    high = betaincinv(hits + 1, misses, 0.975) if misses else 1.0
    return float(low), float(high)


def _option(kind: type[_Kind], name: str, value: object) -> _Kind:
    try:
        return kind(value)
    except ValueError:
        names = ", ".join(repr(member.value) for member in kind)
        raise InputError(
            f"Argument `{name}` must be one of {names}, but it is {value!r}."
        ) from None


class _Tally:
    """Counts and moments of the samples so far (Chan's update of the covariance)."""

    def __init__(self, d: int) -> None:
        self.solved = self.lost = self.inside = self.followed = 0
        self.mean = np.zeros(d)
        self._scatter = np.zeros((d, d))

    def add(self, window: Samples) -> None:
        solved = window.status == Status.SOLVED
        points = window.q_p[solved][:, : self.mean.size]
        self.lost += int(np.sum(window.status == Status.LOST))
        self.inside += int(np.sum(window.inside))
        self.followed += int(np.sum(window.followed))
        if len(points) == 0:
            return
        mean = points.mean(axis=0)
        shift = mean - self.mean
        total = self.solved + len(points)
        self._scatter += (points - mean).T @ (points - mean)
        self._scatter += np.outer(shift, shift) * self.solved * len(points) / total
        self.mean = self.mean + shift * len(points) / total
        self.solved = total

    @property
    def covariance(self) -> np.ndarray:
        return self._scatter / max(self.solved - 1, 1)
