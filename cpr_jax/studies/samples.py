"""Equilibria at random parameters: most at once, the doubtful followed step by step."""

import enum
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
from ..statics.continuation import follow
from ..statics.status import Status
from ..statics.unknowns import unknown_scales
from .draws import Distribution, draw
from .parallel import in_parallel

CHUNK = 2048
"""Samples solved at once: their states fit into a core's cache."""

WINDOW = 16
"""Chunks in flight; memory beyond the samples that are kept does not depend on N."""

RESCUED = 128
"""Doubtful samples that are followed at once."""

PATIENCE = (4, 16, 400)
"""Steps after which samples are followed again, apart: a batch waits for its slowest."""

_CORRECTIONS = 5
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
    # As arrays: Python numbers would be compiled in.
    numbered = jnp.asarray(np.int64(seed))

    def at_once(start: int):
        found = _solve_chunk(study, options, numbered, jnp.asarray(np.int64(start)))
        return [np.asarray(part) for part in found]

    chunks = in_parallel(at_once, range(first, first + count, CHUNK))
    rho, q_p, sure = (np.concatenate(parts) for parts in zip(*chunks, strict=True))
    status = np.where(sure, int(Status.SOLVED), int(Status.NOT_CONVERGED))
    for patience in PATIENCE:
        waiting = np.flatnonzero(status[:count] == Status.NOT_CONVERGED)

        def rescue(k: int, waiting=waiting, patience=patience) -> None:
            lanes = waiting[k : k + RESCUED]
            # Padded with the nominal parameters, so that one program serves any number of lanes.
            targets = np.tile(np.asarray(study.expansion.rho), (RESCUED, 1))
            targets[: len(lanes)] = rho[lanes]
            limit = jnp.asarray(np.int64(patience))
            places, outcome = _follow_all(study, options, jnp.asarray(targets), limit)
            q_p[lanes] = np.asarray(places)[: len(lanes)]
            status[lanes] = np.asarray(outcome)[: len(lanes)]

        in_parallel(rescue, range(0, len(waiting), RESCUED))
    q_p[status != Status.SOLVED] = np.nan
    inside = np.concatenate([_contains(study.ellipse, part) for part in np.split(q_p, len(chunks))])
    return Samples(*(part[:count] for part in (rho, q_p, status, inside, ~sure)))


@program
def _contains(ellipse: Ellipsoid, q_p):
    return ellipse.contains(q_p[:, : ellipse.center.size])


@program
def _solve_chunk(study: Study, options: Options, seed, start):
    """Parameters, platforms, and whether they are sure to be on the branch.

    A chord iteration whose matrix M, the inverse of the Jacobian J expanded to first order,
    differs from sample to sample: it needs no derivative of a rod and still gains two digits or
    more at each turn. Each change is combined with the one before it (Anderson, 1965).

    Where `1 - M J` contracts, both determinants have the same sign, which is that of the branch
    as long as M stays regular. A sample is sure if it converged so, near its prediction.
    """
    robot, expansion = study.robot, study.expansion
    equations = held_equations(robot, options.selection, study.y, options.steps)
    numbers = start + jnp.arange(CHUNK)
    units = unknown_scales(robot)
    platform = slice(robot.n_a, robot.n_a + robot.n_p)

    def one(step):
        rho = expansion.rho + step
        shift = expansion.first @ step
        if options.prediction is Prediction.SECOND_ORDER:
            shift = shift + 0.5 * (expansion.second @ step) @ step
        guess = expansion.y + shift
        turn = jnp.tensordot(step, expansion.turn, axes=1)

        def change(y):
            f = equations(y, rho)
            chord = expansion.inverse @ f
            return -(chord + turn @ chord), jnp.max(jnp.abs(f))

        def correct(carry, _):
            y, chord, moved, worst = carry
            new, left = change(y)
            bent = new - chord
            share = jnp.sum(new * bent) / jnp.maximum(jnp.sum(bent**2), 1e-300)
            step = new - share * (moved + bent)
            # What `1 - M J` makes of the last step.
            kept = jnp.sqrt(jnp.sum((moved + bent) ** 2) / jnp.sum(moved**2))
            # Below the tolerance it is made of rounding errors.
            worst = jnp.where(left > _TOLERANCE, jnp.maximum(worst, kept), worst)
            return (y + step, new, step, worst), left

        first, _ = change(guess)
        start = guess + first, first, first, jnp.zeros(())
        (y, _, _, worst), left = jax.lax.scan(correct, start, None, length=_CORRECTIONS)
        # A last correction, of which the residual before it tells what is left, is in y.
        converged = left[-1] * jnp.minimum(worst, left[-1] / left[-2]) < _TOLERANCE
        regular = jnp.max(jnp.abs(turn) @ expansion.weights / expansion.weights) < 1.0
        near = jnp.max(jnp.abs(y - guess)) <= 0.02 + 0.3 * jnp.max(jnp.abs(shift))
        sure = converged & (worst < 0.5) & regular & near
        return rho, (y * units)[platform], sure

    return jax.vmap(one)(draw(options.distribution, study.delta, seed, numbers))


@program
def _follow_all(study: Study, options: Options, targets, patience):
    """Platforms and status at parameters to which the branch is followed from the nominal ones."""
    robot, expansion = study.robot, study.expansion
    equations = held_equations(robot, options.selection, study.y, options.steps)
    platform = slice(robot.n_a, robot.n_a + robot.n_p)

    def one(rho):
        way = jnp.stack([expansion.rho, rho])
        track = follow(equations, expansion.y, way, max_steps=patience, first_step=1.0)
        return (track.y * unknown_scales(robot))[platform], track.status

    return jax.vmap(one)(targets)
