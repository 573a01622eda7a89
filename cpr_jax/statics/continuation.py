"""Following a branch: the only way to a configuration far from a known one."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .linear import solve_with_sign
from .status import Status

_MIN_STEP = 1e-5
_MAX_DEVIATION = 0.03
_CORRECTIONS = 6
_CORRECTED = 1e-9


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


class _Walk(NamedTuple):
    y: Float[Array, " n"]
    jacobian: Float[Array, "n n"]
    position: Float[Array, ""]
    step: Float[Array, ""]
    sign: Float[Array, ""]
    steps: Int[Array, ""]


def follow(
    equations: Callable[[Float[Array, " n"], Float[Array, " k"]], Float[Array, " n"]],
    start: Float[Array, " n"],
    path: Float[Array, "points k"],
    max_steps: int | Int[Array, ""] = 400,
    first_step: float = 0.1,
    min_step: float = _MIN_STEP,
) -> Track:
    """Follows the root of `equations(y, h) = 0` while `h` runs along a polygon.

    Tangent prediction, Newton correction, adaptive steps. A step counts only if the correction
    converges, stays close to the prediction and keeps the sign of `det ∂R/∂y`, so that neither
    a fold is crossed nor another branch taken. Where steps become tiny the branch has ended:
    the status is `LOST`, and `y` the last point on it.

    **Arguments:**

    - `equations`: dimensionless, square in `y`.
    - `start`: a root at `path[0]`.
    - `path`: corners of the polygon, at least two.
    - `first_step`, `min_step`: length of the first and of the shortest step, in segments.
    """
    segments = path.shape[0] - 1

    def value_on(position, segment):
        weight = position - segment
        return (1.0 - weight) * path[segment] + weight * path[segment + 1]

    def tangent(walk, segment):
        h = value_on(walk.position, segment)
        dh = path[segment + 1] - path[segment]
        _, shift = jax.jvp(lambda h: equations(walk.y, h), (h,), (dh,))
        return solve_with_sign(walk.jacobian, -shift)[0]

    def correct(y, h):
        def evaluate(y):
            f = equations(y, h)
            return f, f

        def unfinished(carry):
            # Away from its prediction a correction counts as failed, wherever it may lead.
            moved, norm, _, _, k = carry
            near = jnp.max(jnp.abs(moved - y)) < _MAX_DEVIATION
            return (k < _CORRECTIONS) & (norm > _CORRECTED) & near

        def newton(carry):
            y, *_, k = carry
            jacobian, f = jax.jacfwd(evaluate, has_aux=True)(y)
            change, sign = solve_with_sign(jacobian, -f)
            return y + change, jnp.max(jnp.abs(f)), sign, jacobian, k + 1

        one = jnp.ones((), y.dtype)
        first = (y, jnp.inf * one, one, jnp.eye(y.size), jnp.array(0))
        y, norm, sign, jacobian, _ = jax.lax.while_loop(unfinished, newton, first)
        return y, norm <= _CORRECTED, sign, jacobian

    def unfinished(walk):
        return (walk.position < segments) & (walk.step > min_step) & (walk.steps < max_steps)

    def advance(walk):
        # The first advance stays where it is: it polishes the start and gets its Jacobian.
        first = walk.steps == 0
        segment = jnp.floor(walk.position).astype(int)
        rest = segment + 1.0 - walk.position
        # Land on each corner: the tangent turns there.
        lands = walk.step >= rest - min_step
        end = jnp.where(lands, segment + 1.0, walk.position + walk.step)
        end = jnp.where(first, 0.0, end)
        taken = end - walk.position
        predicted = walk.y + jnp.where(first, 0.0, taken * tangent(walk, segment))
        y, converged, sign, jacobian = correct(predicted, value_on(end, segment))
        deviation = jnp.max(jnp.abs(y - predicted))
        expected = jnp.where(first, sign, walk.sign)
        good = converged & (deviation < _MAX_DEVIATION) & (sign == expected)
        growth = 0.7 * jnp.sqrt(_MAX_DEVIATION / jnp.maximum(deviation, 1e-12))
        grown = jnp.where(first, first_step, jnp.clip(growth, 0.3, 3.0) * taken)
        # A short step onto a corner says nothing about the steps after it.
        grown = jnp.where(lands & (growth > 1.0), jnp.maximum(grown, walk.step), grown)
        shrunk = jnp.where(first, 0.0, 0.3 * jnp.minimum(walk.step, rest))
        return _Walk(
            y=jnp.where(good, y, walk.y),
            jacobian=jnp.where(good, jacobian, walk.jacobian),
            position=jnp.where(good, end, walk.position),
            step=jnp.where(good, jnp.minimum(grown, 1.0), shrunk),
            sign=expected,
            steps=walk.steps + 1,
        )

    zero = jnp.zeros((), start.dtype)
    walk = _Walk(
        y=start,
        jacobian=jnp.eye(start.size),
        position=zero,
        step=zero + first_step,
        sign=zero,
        steps=jnp.array(0),
    )
    walk = jax.lax.while_loop(unfinished, advance, walk)
    finished = walk.position >= segments
    finite = jnp.all(jnp.isfinite(walk.y)) & jnp.all(jnp.isfinite(path))
    status = jnp.where(
        finished,
        Status.SOLVED,
        jnp.where(
            finite,
            jnp.where(walk.step > min_step, Status.NOT_CONVERGED, Status.LOST),
            Status.NOT_FINITE,
        ),
    )
    return Track(walk.y, walk.position, status, walk.sign, walk.steps)
