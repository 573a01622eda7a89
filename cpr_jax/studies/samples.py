"""Equilibria at random parameters: most at once, the doubtful followed step by step."""

import enum
import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..analysis.ellipsoid import Ellipsoid
from ..analysis.expansion import Expansion, held_equations
from ..analysis.parameters import Selection
from ..programs import program
from ..robots.robot import Robot
from ..statics.continuation import follow, newton_corrector
from ..statics.linear import solve_with_sign
from ..statics.status import Status
from ..statics.unknowns import unknown_scales
from .draws import Distribution, draw
from .parallel import in_parallel, on_devices

CHUNK = 1024
"""Samples solved at once: their states fit into a core's cache."""

WINDOW = 64
"""Chunks in flight; memory beyond the samples that are kept does not depend on N."""

RESCUED = 128
"""Doubtful samples that are followed at once."""

PATIENCE = (4, 16, 400)
"""Steps after which samples are followed again, apart: a batch waits for its slowest."""

_CORRECTIONS = 5
_MORE_CORRECTIONS = 20
_TOLERANCE = 1e-11


class Prediction(enum.Enum):
    """Where the root find of a sample starts."""

    TANGENT = "tangent"
    """`y* + Π_y Δρ` (12)."""
    SECOND_ORDER = "second-order"
    """With the second derivative of y along Δρ."""


class Study(eqx.Module):
    """What all samples share."""

    robot: Robot
    y: Float[Array, " n_y"]
    delta: Float[Array, " n_rho"]
    expansion: Expansion
    ellipse: Ellipsoid


class Options(NamedTuple):
    """How samples are drawn and solved."""

    selection: Selection
    distribution: Distribution
    prediction: Prediction
    steps: int


class Samples(NamedTuple):
    """Samples of a window; `followed` marks those that were doubtful."""

    rho: np.ndarray
    q_p: np.ndarray
    status: np.ndarray
    inside: np.ndarray
    followed: np.ndarray


def solve_window(study: Study, options: Options, seed: int, first: int, count: int) -> Samples:
    """Draws and solves the samples with the numbers `first` to `first + count - 1`."""
    studies = on_devices(study)

    def at_once(start: int):
        here = studies[start // CHUNK % len(studies)]
        # As arrays: Python numbers would be compiled in.
        found = _solve_chunk(here, options, np.asarray(seed), np.asarray(start))
        return [np.asarray(part) for part in found]

    chunks = in_parallel(at_once, range(first, first + count, CHUNK))
    rho, q_p, sure = (np.concatenate(parts) for parts in zip(*chunks, strict=True))
    status = np.where(sure, int(Status.SOLVED), int(Status.NOT_CONVERGED))

    def correct(batch) -> None:
        lanes, targets = batch
        places, sure = _correct_longer(study, options, targets)
        q_p[lanes] = np.asarray(places)[: len(lanes)]
        status[lanes[np.asarray(sure)[: len(lanes)]]] = Status.SOLVED

    def along(batch, patience: int) -> None:
        lanes, targets = batch
        limit = jnp.asarray(np.int64(patience))
        places, outcome = _follow_all(study, options, targets, limit)
        q_p[lanes] = np.asarray(places)[: len(lanes)]
        status[lanes] = np.asarray(outcome)[: len(lanes)]

    def waiting() -> np.ndarray:
        return np.flatnonzero(status[:count] == Status.NOT_CONVERGED)

    in_parallel(correct, _batches(study, rho, waiting()))
    # A single batch has nothing to gain from being sorted by patience.
    for patience in PATIENCE if len(waiting()) > RESCUED else PATIENCE[-1:]:
        rescue = functools.partial(along, patience=patience)
        in_parallel(rescue, _batches(study, rho, waiting()))

    q_p[status != Status.SOLVED] = np.nan
    inside = np.concatenate([_contains(study.ellipse, part) for part in np.split(q_p, len(chunks))])
    return Samples(*(part[:count] for part in (rho, q_p, status, inside, ~sure)))


def _batches(study: Study, rho, lanes):
    """Lanes with their parameters, padded with the nominal ones: one program serves any number."""
    for k in range(0, len(lanes), RESCUED):
        batch = lanes[k : k + RESCUED]
        targets = np.tile(np.asarray(study.expansion.rho), (RESCUED, 1))
        targets[: len(batch)] = rho[batch]
        yield batch, jnp.asarray(targets)


@program
def _contains(ellipse: Ellipsoid, q_p):
    return ellipse.contains(q_p[:, : ellipse.center.size])


@program
def _solve_chunk(study: Study, options: Options, seed, start):
    """Parameters, platforms, and whether they are sure to be on the branch."""
    numbers = start + jnp.arange(CHUNK)
    steps = draw(options.distribution, study.delta, seed, numbers)
    rho = study.expansion.rho + steps
    q_p, sure = jax.vmap(lambda rho: _corrected(study, options, rho, _CORRECTIONS, False))(rho)
    return rho, q_p, sure


@program
def _correct_longer(study: Study, options: Options, targets):
    """Platforms of samples that take more corrections, and whether they are sure."""
    return jax.vmap(lambda rho: _corrected(study, options, rho, _MORE_CORRECTIONS, True))(targets)


def _corrected(study: Study, options: Options, rho, corrections: int, exact: bool):
    """The platform at other parameters, and whether it is sure to be on the branch.

    A chord iteration whose matrix M, the inverse of the Jacobian J expanded to first order,
    differs from sample to sample: it needs no derivative of a rod and still gains two digits or
    more at each turn. Each change is combined with the one before it (Anderson, 1965).

    Where `1 - M J` contracts, both determinants have the same sign, which is that of the branch
    as long as that of M does not change: it is calculated if `exact`, and otherwise bounded. A
    sample is sure if it converged so, near its prediction.
    """
    robot, expansion = study.robot, study.expansion
    equations = held_equations(robot, options.selection, study.y, options.steps)
    away = rho - expansion.rho
    shift = expansion.first @ away
    if options.prediction is Prediction.SECOND_ORDER:
        shift = shift + 0.5 * (expansion.second @ away) @ away
    guess = expansion.y + shift
    turn = jnp.tensordot(away, expansion.turn, axes=1)

    def change(y):
        f = equations(y, rho)
        chord = expansion.inverse @ f
        return -(chord + turn @ chord), jnp.max(jnp.abs(f))

    def correct(carry, _):
        y, chord, moved, worst, before, _ = carry
        new, left = change(y)
        bent = new - chord
        share = jnp.sum(new * bent) / jnp.maximum(jnp.sum(bent**2), 1e-300)
        step = new - share * (moved + bent)
        # What `1 - M J` makes of the last step; below the tolerance, of rounding errors.
        kept = jnp.sqrt(jnp.sum((moved + bent) ** 2) / jnp.sum(moved**2))
        worst = jnp.where(left > _TOLERANCE, jnp.maximum(worst, kept), worst)
        return (y + step, new, step, worst, left, before), None

    first, left = change(guess)
    start = guess + first, first, first, jnp.zeros(()), left, left
    (y, _, _, worst, left, before), _ = jax.lax.scan(correct, start, None, length=corrections)
    # A last correction, of which the residual before it tells what is left, is in y.
    converged = left * jnp.minimum(worst, left / before) < _TOLERANCE
    if exact:
        regular = solve_with_sign(jnp.eye(y.size) + turn, y)[1] > 0.0
    else:
        regular = jnp.max(jnp.abs(turn) @ expansion.weights / expansion.weights) < 1.0
    near = jnp.max(jnp.abs(y - guess)) <= 0.02 + 0.3 * jnp.max(jnp.abs(shift))
    units = unknown_scales(robot)
    platform = slice(robot.n_a, robot.n_a + robot.n_p)
    return (y * units)[platform], converged & (worst < 0.9) & regular & near


@program
def _follow_all(study: Study, options: Options, targets, patience):
    """Platforms and status at parameters to which the branch is followed from the nominal ones."""
    robot, expansion = study.robot, study.expansion
    correct = newton_corrector(held_equations(robot, options.selection, study.y, options.steps))
    platform = slice(robot.n_a, robot.n_a + robot.n_p)

    def one(rho):
        way = jnp.stack([expansion.rho, rho])
        track = follow(correct, expansion.y, way, max_steps=patience, first_step=1.0)
        return (track.y * unknown_scales(robot))[platform], track.status

    return jax.vmap(one)(targets)
