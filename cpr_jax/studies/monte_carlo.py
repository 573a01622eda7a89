"""Monte Carlo: where the platform ends up when the parameters vary at random."""

import enum
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.special import betaincinv
from tqdm import tqdm

from ..analysis.ellipsoid import Ellipsoid, ellipsoid
from ..analysis.parameters import Selection, ranges, select
from ..analysis.sensitivity import Sensitivity, sensitivity
from ..errors import InputError
from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.continuation import follow
from ..statics.equilibrium import Equilibrium
from ..statics.problem import Problem, find_root, forward_rows, full_residual
from ..statics.status import Status
from ..statics.unknowns import unknown_scales

CHUNK = 2048
"""Samples solved at once; memory beyond the samples that are kept does not depend on N."""

_RESCUED = 128
"""Doubtful samples that are followed at once."""

_Kind = TypeVar("_Kind", bound=enum.Enum)


class Distribution(enum.Enum):
    """How the parameters vary."""

    GAUSSIAN = "gaussian"
    """Independent Gaussians with σ = δ/3, as in the paper."""
    ELLIPSOID = "ellipsoid"
    """Uniform in the ellipsoid (11)."""
    BOX = "box"
    """Uniform in the intervals (6)."""


class Prediction(enum.Enum):
    """Where Newton's method starts."""

    TANGENT = "tangent"
    """`y* + Π_y Δρ` (12)."""
    SECOND_ORDER = "second-order"
    """With the second derivative of y along Δρ."""


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
    prediction: Prediction | str = Prediction.TANGENT,
    keep: int = 100_000,
    steps: int = DEFAULT_STEPS,
    progress: bool = False,
) -> MonteCarlo:
    """Solves the robot for random parameters, with the motors where the equilibrium has them.

    Each sample starts at a prediction from the nominal equilibrium. One that converges close to
    its prediction, with the sign of the Jacobian's determinant unchanged, is on the branch; every
    other one is followed from the nominal parameters in small steps, which tells whether the
    branch has an equilibrium there.

    **Arguments:**

    - `samples`, `seed`: the samples of a seed do not depend on how many there are.
    - `parameters`, `delta`: as in `sensitivity`.
    - `distribution`: `"gaussian"`, `"ellipsoid"` or `"box"`.
    - `prediction`: `"tangent"` or `"second-order"`.
    - `keep`: how many samples to keep; the counts are of all of them.
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
    nominal = sensitivity(robot, equilibrium, parameters, delta, steps=steps)
    ellipse = ellipsoid(nominal)
    # det ∂R/∂y with the motors imposed is det A_p, but for moving n_a columns past the others.
    sign = equilibrium.measures.sign_t2 * (-1.0) ** (robot.n_a * (robot.n_y - robot.n_a))
    study = _Study(robot, nominal.y, nominal.Pi_y, nominal.rho, half_ranges, sign, ellipse)
    options = _Options(drawn, _Solving(selection, predicted, steps))

    tally = _Tally(robot.geometry.d)
    kept: list[_Chunk] = []
    starts = range(0, samples, CHUNK)
    with tqdm(total=samples, unit="sample", disable=not progress) as bar:
        for start, chunk, followed in _solved_chunks(study, options, seed, starts):
            size = min(CHUNK, samples - start)
            chunk = _Chunk(*(np.asarray(part)[:size] for part in chunk))
            tally.add(chunk, int(np.sum(followed[:size])))
            if start < keep:
                kept.append(_Chunk(*(part[: keep - start] for part in chunk)))
            bar.update(size)

    rho, q_p, status, inside = (np.concatenate(parts) for parts in zip(*kept, strict=True))
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


class _Study(eqx.Module):
    """What all samples share."""

    robot: Robot
    y: Float[Array, " n_y"]
    Pi_y: Float[Array, "n_y n_rho"]
    rho: Float[Array, " n_rho"]
    delta: Float[Array, " n_rho"]
    sign: Float[Array, ""]
    ellipse: Ellipsoid


class _Solving(NamedTuple):
    selection: Selection
    prediction: Prediction
    steps: int


class _Options(NamedTuple):
    distribution: Distribution
    solving: _Solving


class _Chunk(NamedTuple):
    rho: np.ndarray
    q_p: np.ndarray
    status: np.ndarray
    inside: np.ndarray


class _Tally:
    """Counts and moments of the samples so far (Chan's update of the covariance)."""

    def __init__(self, d: int) -> None:
        self.solved = self.lost = self.inside = self.followed = 0
        self.mean = np.zeros(d)
        self._scatter = np.zeros((d, d))

    def add(self, chunk: _Chunk, followed: int) -> None:
        solved = chunk.status == Status.SOLVED
        points = chunk.q_p[solved][:, : self.mean.size]
        self.lost += int(np.sum(chunk.status == Status.LOST))
        self.inside += int(np.sum(chunk.inside))
        self.followed += followed
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


def _solved_chunks(
    study: _Study, options: _Options, seed: int, starts: range
) -> Iterator[tuple[int, _Chunk, np.ndarray]]:
    """Chunks in order, one at a time: one program keeps the cores busy by itself."""
    for start in starts:
        yield start, *_solve_chunk(study, options, seed, start)


def _solve_chunk(study: _Study, options: _Options, seed: int, start: int):
    # As arrays: Python numbers would be compiled in.
    draws = _draw_all(options.distribution, study.delta, jnp.asarray(seed), jnp.asarray(start))
    rho, y, status, doubtful = (
        np.array(part) for part in _predict_and_solve(study, options.solving, draws)
    )
    waiting = np.flatnonzero(doubtful)
    batches = [waiting[k : k + _RESCUED] for k in range(0, len(waiting), _RESCUED)]

    def rescue(lanes):
        # Padded with the nominal parameters, so that one program serves any number of lanes.
        targets = np.tile(np.asarray(study.rho), (_RESCUED, 1))
        targets[: len(lanes)] = rho[lanes]
        followed, outcome = _follow_all(study, options.solving, jnp.asarray(targets))
        y[lanes] = np.asarray(followed)[: len(lanes)]
        status[lanes] = np.asarray(outcome)[: len(lanes)]

    for batch in batches:
        rescue(batch)
    y[status != Status.SOLVED] = np.nan
    robot = study.robot
    q_p = y[:, robot.n_a : robot.n_a + robot.n_p]
    inside = np.asarray(_contains(study.ellipse, q_p))
    return _Chunk(rho, q_p, status, inside), doubtful


@program
def _contains(ellipse: Ellipsoid, q_p):
    return ellipse.contains(q_p[:, : ellipse.center.size])


@program
def _draw_all(distribution: Distribution, delta, seed, start) -> Float[Array, "chunk n_rho"]:
    """Random `Δρ` of a chunk; each sample has a key of its own, by its number."""
    key = jax.random.key(seed)

    def one(index):
        return delta * _draw(distribution, jax.random.fold_in(key, index), delta.size)

    return jax.vmap(one)(start + jnp.arange(CHUNK))


def _draw(distribution: Distribution, key, size: int) -> Float[Array, " n_rho"]:
    """One random `Δρ / δ`."""
    if distribution is Distribution.GAUSSIAN:
        return jax.random.normal(key, (size,)) / 3.0
    if distribution is Distribution.BOX:
        return jax.random.uniform(key, (size,), minval=-1.0, maxval=1.0)
    direction, radius = jax.random.split(key)
    vector = jax.random.normal(direction, (size,))
    return vector / jnp.linalg.norm(vector) * jax.random.uniform(radius) ** (1.0 / size)


def _problem(study: _Study, solving: _Solving, rho) -> Problem:
    robot = solving.selection.set(study.robot, rho)
    target = study.y[: robot.n_a + robot.n_p]
    return Problem(robot, forward_rows(robot), target)


@program
def _predict_and_solve(study: _Study, solving: _Solving, draws):
    units = unknown_scales(study.robot)

    def solution(rho):
        problem = _problem(study, solving, rho)
        return find_root(problem, study.y, steps=solving.steps)

    def along(direction):
        """Second derivative of y in a direction, through the implicit derivative twice."""

        def first(t):
            return jax.jvp(lambda t: solution(study.rho + t * direction).y, (t,), (1.0,))[1]

        return jax.jvp(first, (0.0,), (1.0,))[1]

    def one(step):
        rho = study.rho + step
        shift = study.Pi_y @ step
        if solving.prediction is Prediction.SECOND_ORDER:
            shift = shift + 0.5 * along(step)
        guess = study.y + shift
        # A residual of 1e-6 and one more step make 1e-12, which is verified; where it does not,
        # the sample is followed. All lanes wait for the slowest, so an iteration counts.
        root = find_root(_problem(study, solving, rho), guess, steps=solving.steps, atol=1e-6)
        correction = jnp.max(jnp.abs((root.y - guess) / units))
        expected = 0.02 + 0.3 * jnp.max(jnp.abs(shift / units))
        sure = (root.status == Status.SOLVED) & (root.sign == study.sign)
        sure = sure & (correction <= expected)
        return rho, root.y, root.status, ~sure

    return jax.vmap(one)(draws)


@program
def _follow_all(study: _Study, solving: _Solving, targets):
    units = unknown_scales(study.robot)

    def equations(y, rho):
        problem = _problem(study, solving, rho)
        scaled = y * units / unknown_scales(problem.robot)
        return full_residual(scaled, problem, solving.steps)

    def one(rho):
        track = follow(equations, study.y / units, jnp.stack([study.rho, rho]))
        return track.y * units, track.status

    return jax.vmap(one)(targets)
