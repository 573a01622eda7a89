"""Folds of a branch, told from across them: where it turns back, steps towards it become tiny."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

_ALIKE = 0.3
"""Least ratio of the speeds on both sides of a fold, at equal distances from it."""

_MISSED = 0.3
"""Largest distance from where the other side was expected, in distances of both sides."""

_CLEAR = 1.5
"""Distances of a fold that the end of a path must be away, for the fold to lie before it."""


class Fold(NamedTuple):
    """What is expected of a fold ahead, where `y = y_f + a u + b u² + …` with `u² = h_f - h`.

    **Attributes:**

    - `distance`: how far ahead it is, `u²`; infinite where the branch does not turn.
    - `y`: the point at `-u`, as far behind the fold as the branch is before it.
    - `slope`: `dy/dh` there.
    """

    distance: Float[Array, ""]
    y: Float[Array, " n"]
    slope: Float[Array, " n"]


def fold_ahead(
    y: Float[Array, " n"],
    slope: Float[Array, " n"],
    curve: Float[Array, " n"],
    bend: Float[Array, " n"],
    taken: Float[Array, ""],
) -> Fold:
    """A fold, from a point of a branch and the one before it.

    **Arguments:**

    - `slope`, `curve`, `bend`: derivatives of the cubic that leads there, see `hermite`.
    - `taken`: how far behind in h the one before is.
    """
    change = taken * (slope - taken * (curve / 2.0 - taken * bend / 6.0))
    before = slope - taken * (curve - taken * bend / 2.0)
    # With a and b alone, `w = q (q - p)` where u was q and is p.
    sharper = slope - before
    w = jnp.sum(sharper * (taken * slope - change)) / jnp.sum(sharper**2)
    turns = (w < taken) & (2.0 * w > taken)
    distance = jnp.where(turns, (taken - w) ** 2 / (2.0 * w - taken), jnp.inf)
    p, q = jnp.sqrt(distance), jnp.sqrt(distance + taken)
    # In u it is smooth: the cubic through both points goes on across the fold.
    start, end, on = 2.0 * q * before, 2.0 * p * slope, 2.0 * p
    turn, twist = hermite(change, start, end, q - p)
    across = y + on * (end + on * (turn / 2.0 + on * twist / 6.0))
    return Fold(distance, across, -(end + on * (turn + on * twist / 2.0)) / on)


def is_fold(
    fold: Fold,
    y: Float[Array, " n"],
    slope: Float[Array, " n"],
    other: Float[Array, " n"],
    back: Float[Array, " n"],
    rest: Float[Array, ""],
) -> Bool[Array, ""]:
    """Whether two points at the same h lie on both sides of a fold that comes before a path ends.

    **Arguments:**

    - `y`, `slope`: the one, and `dy/dh` there.
    - `other`, `back`: the other.
    - `rest`: how far away the end of the path is.
    """
    speed = jnp.sqrt(jnp.sum(slope**2))
    towards = slope / speed
    apart, returning = jnp.sum((other - y) * towards), -jnp.sum(back * towards)
    missed = jnp.sqrt(jnp.sum((other - fold.y) ** 2))
    alike = (returning > _ALIKE * speed) & (returning < speed / _ALIKE)
    distance = apart / (2.0 * (speed + returning))
    return alike & (missed < _MISSED * apart) & (_CLEAR * distance < rest)


def hermite(change, before, after, length):
    """Second and third derivative, at its end, of a cubic with these slopes at both ends."""
    curve = (2.0 * before + 4.0 * after - 6.0 * change / length) / length
    bend = (6.0 * (before + after) - 12.0 * change / length) / length**2
    return curve, bend
