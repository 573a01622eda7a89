"""Equilibria at random parameters: most at once, the doubtful followed step by step."""

import enum
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..analysis.ellipsoid import Ellipsoid
from ..analysis.expansion import Expansion, HeldEquations
from ..analysis.parameters import Selection
from ..parallel import WORKERS, in_parallel, on_devices
from ..programs import program
from ..queue import queued_loop
from ..robots.robot import Robot
from ..statics.chord import chord_corrector
from ..statics.continuation import Jet, follow
from ..statics.linear import solve_with_sign
from ..statics.reach import used_up
from ..statics.status import Status
from ..statics.unknowns import unknown_scales
from .chord import ChordIteration
from .draws import Distribution, draw

CHUNK = 1000
"""Samples solved at once: their states fit into a core's cache, and none is solved in vain where
users ask for thousands."""

WINDOW = 64
"""Chunks in flight; memory beyond the samples that are kept does not depend on N."""

RESCUED = 256
"""Doubtful samples that are looked at again at once."""

_SLOTS = 64
"""Of these, samples that are followed at a time: most studies have only a few."""

_CORRECTIONS = 2
"""Of every sample: enough for three quarters of them or more."""

_FEW = 32
"""Samples of a chunk that are corrected further at a time."""

PATIENCE = 400
"""Steps after which following a sample is given up."""


class Prediction(enum.Enum):
    """Where the root find of a sample starts."""

    TANGENT = "tangent"
    """`y* + Π_y Δρ` (12)."""
    SECOND_ORDER = "second-order"
    """With the second derivative of y along Δρ."""


class Study(NamedTuple):
    """What all samples share."""

    robot: Robot
    y: Float[Array, " n_y"]
    delta: Float[Array, " n_rho"]
    expansion: Expansion
    scheme: Int[Array | np.ndarray, "3"]
    enough: Float[Array | np.ndarray, ""]


class Options(NamedTuple):
    """How samples are drawn and solved."""

    selection: Selection
    distribution: Distribution
    prediction: Prediction


class Samples(NamedTuple):
    """Samples of a window; `followed` marks those that no correction has led to for sure."""

    rho: np.ndarray
    q_p: np.ndarray
    status: np.ndarray
    inside: np.ndarray
    followed: np.ndarray


def solve_window(
    study: Study, options: Options, ellipse: Ellipsoid, seed: int, first: int, count: int
) -> Samples:
    """Draws and solves the samples with the numbers `first` to `first + count - 1`."""
    places = on_devices((study, ellipse))

    def at_once(start: int):
        here, bounds = places[start // CHUNK % len(places)]
        # As arrays: Python numbers would be compiled in.
        found = _solve_chunk(here, options, bounds, np.asarray(seed), np.asarray(start))
        return [np.asarray(part) for part in found]

    chunks = in_parallel(at_once, range(first, first + count, CHUNK))
    rho, q_p, inside, sure, regular = (np.concatenate(parts) for parts in zip(*chunks, strict=True))

    def look(lanes) -> None:
        kept = _keeps_sign(study.expansion, _padded(study, rho[lanes]))
        regular[lanes] = np.asarray(kept)[: len(lanes)]

    in_parallel(look, _batches(np.flatnonzero((sure & ~regular)[:count])))
    followed = ~(sure & regular)
    status = np.where(followed, int(Status.NOT_CONVERGED), int(Status.SOLVED))

    def along(lanes) -> None:
        # What fills up the batch is not followed.
        patience = np.where(np.arange(RESCUED) < len(lanes), PATIENCE, 0)
        found = _follow_all(study, options, ellipse, _padded(study, rho[lanes]), patience)
        for whole, part in zip((q_p, inside, status), found, strict=True):
            whole[lanes] = np.asarray(part)[: len(lanes)]

    # Apart: many studies need no sample followed, and are spared the compilation.
    in_parallel(along, _batches(np.flatnonzero(followed[:count])))
    if study.robot.legs.feed is not None:
        gone = np.asarray(_used_up(study, options, rho))
        status[gone & (status == Status.SOLVED)] = Status.OUT_OF_REACH

    unsolved = status != Status.SOLVED
    q_p[unsolved], inside[unsolved] = np.nan, False
    return Samples(*(part[:count] for part in (rho, q_p, status, inside, followed)))


@program
def _used_up(study: Study, options: Options, rho):
    robot, q_a = study.robot, study.y[: study.robot.n_a]
    return jax.vmap(lambda one: used_up(options.selection.set(robot, one), q_a))(rho)


def compile_samples(study: Study, options: Options, ellipse: Ellipsoid) -> None:
    """Compiles what all samples of such a study need."""
    _solve_chunk(study, options, ellipse, np.asarray(0), np.asarray(0))


def compile_following(study: Study, options: Options, ellipse: Ellipsoid) -> None:
    """Compiles what the doubtful samples of such a study need."""
    rho = np.tile(np.asarray(study.expansion.rho), (RESCUED, 1))
    _keeps_sign(study.expansion, rho)
    _follow_all(study, options, ellipse, rho, np.zeros(RESCUED, int))


def _batches(lanes: np.ndarray) -> list[np.ndarray]:
    """Enough batches to keep all workers busy, unless they get small."""
    size = int(np.clip(-(-len(lanes) // WORKERS), _SLOTS, RESCUED))
    return [lanes[k : k + size] for k in range(0, len(lanes), size)]


def _padded(study: Study, rho: np.ndarray) -> np.ndarray:
    """Parameters, padded with the nominal ones: one program serves any number of samples."""
    nominal = np.asarray(study.expansion.rho)
    return np.concatenate([rho, np.tile(nominal, (RESCUED - len(rho), 1))])


@program
def _solve_chunk(study: Study, options: Options, ellipse: Ellipsoid, seed, start):
    """Parameters, platforms, whether they are inside, sure equilibria, and surely on the branch."""
    numbers = start + jnp.arange(CHUNK)
    steps = draw(options.distribution, study.delta, seed, numbers)
    rho = study.expansion.rho + steps
    equations = _equations(study, options)

    def one(rho):
        chord = _chord(study, options, equations, rho)
        found, _ = jax.lax.scan(
            lambda now, _: (chord.advance(now), None), chord.start(), length=_CORRECTIONS
        )

        # The few that need more make their matrices again rather than having all of them moved.
        def again():
            return _chord(study, options, equations, rho)

        found = queued_loop(
            lambda now: now.unfinished, lambda now: again().advance(now), found, slots=_FEW
        )
        regular = study.expansion.is_regular(chord.turn)
        return *_end(study, ellipse, found.y), chord.is_sure(found), regular

    return rho, *jax.vmap(one)(rho)


@program
def _keeps_sign(expansion: Expansion, rho):
    """Whether `det(1 + T) > 0` at parameters where Gershgorin's discs do not tell."""

    def one(rho):
        turned = jnp.eye(expansion.y.size) + expansion.turned(rho - expansion.rho)
        return solve_with_sign(turned, expansion.y)[1] > 0.0

    return jax.vmap(one)(rho)


@program
def _follow_all(study: Study, options: Options, ellipse: Ellipsoid, targets, patience):
    """Platforms, whether they are inside, and status, followed from the nominal parameters."""
    equations, nominal = _equations(study, options), study.expansion
    correct = chord_corrector(equations, equations.linearised)
    _, sign = solve_with_sign(nominal.inverse, nominal.y)

    def one(rho, steps):
        chord = _chord(study, options, equations, rho)
        way, jet = jnp.stack([nominal.rho, rho]), Jet(chord.slope, chord.curve, sign)
        track = follow(correct, nominal.y, way, steps, 1.0, slots=_SLOTS, jet=jet, folds=True)
        return *_end(study, ellipse, track.y), track.status

    return jax.vmap(one)(targets, patience)


def _equations(study: Study, options: Options):
    return HeldEquations(study.robot, options.selection, study.y, study.scheme)


def _chord(study: Study, options: Options, equations, rho) -> ChordIteration:
    second_order = options.prediction is Prediction.SECOND_ORDER
    return ChordIteration(study.expansion, equations, rho, second_order, study.enough)


def _end(study: Study, ellipse: Ellipsoid, y):
    """The platform, and whether it is inside."""
    robot = study.robot
    q_p = (y * unknown_scales(robot)[robot.n_a :])[: robot.n_p]
    return q_p, ellipse.covers(q_p[: ellipse.center.size])
