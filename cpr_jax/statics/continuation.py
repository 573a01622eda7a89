"""Following a branch: the only way to a configuration far from a known one."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..queue import SLOTS, queued_loop
from .fold import Fold, fold_ahead, hermite, is_fold
from .status import Status

DEVIATION = 0.03
"""Largest distance of a solution from its prediction, in dimensionless unknowns."""

_AROUND = 0.2
"""As `DEVIATION`, of a point across a fold, in distances of both sides."""

_MIN_STEP = 1e-5


class Track(NamedTuple):
    """Where following a branch has led.

    **Attributes:**

    - `y`: the last point that is on the branch.
    - `progress`: arc position reached; the number of path segments if all was followed.
    - `status`: `SOLVED` at the end of the path, `LOST` where a singularity ended it.
    - `sign`: sign of the Jacobian's determinant, constant along the branch.
    - `steps`: number of accepted and rejected steps.
    """

    y: Float[Array, " n"]
    progress: Float[Array, ""]
    status: Int[Array, ""]
    sign: Float[Array, ""]
    steps: Int[Array, ""]


class Jet(NamedTuple):
    """What is known of a branch where it is to be followed from.

    **Attributes:**

    - `slope`, `curve`: first and second derivative of `y` along the first segment of the path.
    - `sign`: of `det ∂R/∂y`.
    """

    slope: Float[Array, " n"]
    curve: Float[Array, " n"]
    sign: Float[Array, ""]


class _Walk(NamedTuple):
    """A point on a branch, derivatives of y along the path there, and what is to come.

    `taken` is the step that has led there. After a step that has failed `across` tells to look for
    a fold, `looked` that this has been done, and `folded` whether there is one.
    """

    y: Float[Array, " n"]
    slope: Float[Array, " n"]
    curve: Float[Array, " n"]
    bend: Float[Array, " n"]
    position: Float[Array, ""]
    step: Float[Array, ""]
    sign: Float[Array, ""]
    steps: Int[Array, ""]
    taken: Float[Array, ""]
    across: Bool[Array, ""]
    looked: Bool[Array, ""]
    folded: Bool[Array, ""]


class _Attempt(NamedTuple):
    """Where a step leads to, what is predicted there, and how far from that a root may be."""

    end: Float[Array, ""]
    y: Float[Array, " n"]
    slope: Float[Array, " n"]
    reach: Float[Array, ""]


class Corrected(NamedTuple):
    """Where a corrector has led from a prediction.

    **Attributes:**

    - `y`: the root, or wherever it has ended.
    - `converged`: whether it is a root.
    - `sign`: of `det ∂R/∂y` there.
    - `slope`: `dy/dh` along the direction that was given.
    """

    y: Float[Array, " n"]
    converged: Bool[Array, ""]
    sign: Float[Array, ""]
    slope: Float[Array, " n"]


Corrector = Callable[
    [Float[Array, " n"], Float[Array, " n"], Float[Array, " k"], Float[Array, " k"], Array],
    Corrected,
]
"""From predictions of y and of its slope, at h, with the direction in which h goes on, and the
distance from the prediction beyond which a root does not count."""


def follow(
    correct: Corrector,
    start: Float[Array, " n"],
    path: Float[Array, "points k"],
    max_steps: int | Int[Array, ""] = 400,
    first_step: float = 0.1,
    min_step: float = _MIN_STEP,
    slots: int = SLOTS,
    jet: Jet | None = None,
    folds: bool = False,
) -> Track:
    """Follows a root of `R(y, h) = 0` while `h` runs along a polygon.

    Prediction along the cubic through the last two points and their slopes, correction, adaptive
    steps. A step counts only if the correction converges, stays close to the prediction and keeps
    the sign of `det ∂R/∂y`, so that neither a fold is crossed nor another branch taken. Where steps
    become tiny the branch has ended: the status is `LOST`, and `y` the last point on it.

    **Arguments:**

    - `correct`: such as a `chord_corrector`.
    - `start`: a root at `path[0]`.
    - `path`: corners of the polygon, at least two.
    - `first_step`, `min_step`: length of the first and of the shortest step, in segments.
    - `slots`: of a batch, how many lanes are worked on at a time.
    - `jet`: if it is known at the start; otherwise the first step stays there to find the slope.
    - `folds`: whether a fold ends the branch as soon as the point across it is found, in half of
        the steps; `y` then is farther away from it.
    """
    segments = path.shape[0] - 1

    def value_on(position, segment):
        weight = position - segment
        return (1.0 - weight) * path[segment] + weight * path[segment + 1]

    def unfinished(walk):
        going = (walk.position < segments) & (walk.step > min_step) & (walk.steps < max_steps)
        return going & ~walk.folded

    def advance(walk):
        # Without a sign yet it stays where it is: that polishes the start and gets its slope.
        first = walk.sign == 0.0
        segment = jnp.floor(walk.position).astype(int)
        rest = segment + 1.0 - walk.position
        # Land on each corner: the tangent turns there.
        lands = walk.step >= rest - min_step
        end = jnp.where(lands, segment + 1.0, walk.position + walk.step)
        end = jnp.where(first, 0.0, end)
        taken = end - walk.position
        predicted = walk.y + taken * (
            walk.slope + taken * (walk.curve / 2.0 + taken * walk.bend / 6.0)
        )
        slope = walk.slope + taken * (walk.curve + taken * walk.bend / 2.0)
        attempt = _Attempt(end, predicted, slope, jnp.asarray(DEVIATION))
        across = jnp.array(False)
        if folds:
            fold = fold_ahead(walk.y, walk.slope, walk.curve, walk.bend, walk.taken)
            across = walk.across & (fold.distance < rest)
            attempt = _either(across, _beyond(walk, fold), attempt)
        # The slope is for the segment that begins where this step ends.
        ahead = jnp.minimum(jnp.floor(attempt.end).astype(int), segments - 1)
        h, dh = value_on(attempt.end, segment), path[ahead + 1] - path[ahead]
        found = correct(attempt.y, attempt.slope, h, dh, attempt.reach)
        deviation = jnp.max(jnp.abs(found.y - attempt.y))
        expected = jnp.where(first, found.sign, walk.sign)
        arrived = found.converged & (deviation < attempt.reach)
        good = arrived & (found.sign == expected) & ~across
        folded = arrived & (found.sign == -expected) & across
        if folds:
            folded &= is_fold(fold, walk.y, walk.slope, found.y, found.slope, rest)
        # What a cubic deviates by grows with the fourth power of the step.
        growth = 0.7 * (DEVIATION / jnp.maximum(deviation, 1e-12)) ** 0.25
        # Beyond a corner the path has another direction, and y other derivatives along it.
        straight = (taken > 0.0) & (ahead == segment)
        curve, bend = (
            jnp.where(straight, part, 0.0)
            for part in hermite(found.y - walk.y, walk.slope, found.slope, taken)
        )
        grown = jnp.where(first, first_step, jnp.clip(growth, 0.3, 3.0) * taken)
        # A short step onto a corner says nothing about the steps after it.
        grown = jnp.where(lands & (growth > 1.0), jnp.maximum(grown, walk.step), grown)
        shrunk = jnp.where(first, 0.0, 0.3 * jnp.minimum(walk.step, rest))
        shrunk = jnp.where(across, walk.step, shrunk)
        return _Walk(
            y=jnp.where(good, found.y, walk.y),
            slope=jnp.where(good, found.slope, walk.slope),
            curve=jnp.where(good, curve, walk.curve),
            bend=jnp.where(good, bend, walk.bend),
            position=jnp.where(good, end, walk.position),
            step=jnp.where(good, jnp.minimum(grown, 1.0), shrunk),
            sign=expected,
            steps=walk.steps + 1,
            taken=jnp.where(good, taken, walk.taken),
            # Once from each point: what comes of it does not change before the next one.
            across=~(good | walk.across | walk.looked),
            looked=~good & (walk.across | walk.looked),
            folded=folded,
        )

    zero, still = jnp.zeros((), start.dtype), jnp.zeros_like(start)
    walk = _Walk(
        y=start,
        slope=still if jet is None else jet.slope,
        curve=still if jet is None else jet.curve,
        bend=still,
        position=zero,
        step=zero + first_step,
        sign=zero if jet is None else jet.sign,
        steps=jnp.array(0),
        taken=zero,
        across=jnp.array(False),
        looked=jnp.array(False),
        folded=jnp.array(False),
    )
    length = jnp.sum(jnp.abs(jnp.diff(path, axis=0)))
    walk = queued_loop(unfinished, advance, walk, length, slots)
    finished = walk.position >= segments
    ended = walk.folded | (walk.step <= min_step)
    finite = jnp.all(jnp.isfinite(walk.y)) & jnp.all(jnp.isfinite(path))
    status = jnp.where(
        finished,
        Status.SOLVED,
        jnp.where(
            finite,
            jnp.where(ended, Status.LOST, Status.NOT_CONVERGED),
            Status.NOT_FINITE,
        ),
    )
    return Track(walk.y, walk.position, status, walk.sign, walk.steps)


def _beyond(walk: _Walk, fold: Fold) -> _Attempt:
    """To the other side of a fold, at the same h."""
    apart = jnp.max(jnp.abs(fold.y - walk.y))
    reach = jnp.maximum(DEVIATION, _AROUND * apart)
    return _Attempt(walk.position, fold.y, fold.slope, reach)


def _either(which: Bool[Array, ""], one: _Attempt, other: _Attempt) -> _Attempt:
    return jax.tree.map(lambda a, b: jnp.where(which, a, b), one, other)
