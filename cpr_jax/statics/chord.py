"""Corrections by a matrix that stays: each costs a residual and no derivative."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, ArrayLike, Bool, Float, Int

from .continuation import Corrected, Corrector
from .linear import inverse_with_sign

CONTRACTING = 0.9
"""Rate of convergence that a chord iteration must have to be continued."""

EXACT = 1e-11
"""Residual of a root, in dimensionless rows, where nothing else is asked for."""

_LONGEST = 20

_SURE = 0.5
"""Rate of convergence from which a root has the determinant's sign of where the matrix is from."""

_ASIDE = 1e-4
"""Share of a segment over which a difference tells the slope of a branch."""

_ROUGH = 1e-2
"""Share of a slope that its last correction may have: contracting, it leaves less."""

_TURNS = 4
"""Most corrections of a slope."""


class Chord(NamedTuple):
    """Unknowns after some corrections `-M f`, f the residual; M is nearly `(∂f/∂y)⁻¹`.

    **Attributes:**

    - `y`: the unknowns.
    - `change`: what M made of the residual last; `moved`: the correction that came of it.
    - `left`: largest entry of that residual; `before`: of the one before it.
    - `worst`: slowest contraction of the corrections so far.
    - `corrections`: how many there were.
    - `enough`: residual that a root may have.
    """

    y: Float[Array, " n"]
    change: Float[Array, " n"]
    moved: Float[Array, " n"]
    left: Float[Array, ""]
    before: Float[Array, ""]
    worst: Float[Array, ""]
    corrections: Int[Array, ""]
    enough: Float[Array, ""]

    @classmethod
    def start(cls, y: Float[Array, " n"], enough: ArrayLike = EXACT) -> "Chord":
        """Before the first correction."""
        none, zero = jnp.zeros_like(y), jnp.zeros((), y.dtype)
        return cls(y, none, none, zero, zero, zero, jnp.array(0), jnp.asarray(enough, y.dtype))

    def advanced(self, change: Float[Array, " n"], left: Float[Array, ""]) -> "Chord":
        """After one more, combined with the one before it (Anderson, 1965).

        **Arguments:**

        - `change`: `-M f` at y; `left`: the largest entry of f.
        """
        first = self.corrections == 0
        bent = change - self.change
        share = jnp.sum(change * bent) / jnp.maximum(jnp.sum(bent**2), 1e-300)
        step = change - jnp.where(first, 0.0, share) * (self.moved + bent)
        # What `1 - M J` makes of the last step; below the tolerance, of rounding errors.
        kept = jnp.sqrt(jnp.sum((self.moved + bent) ** 2) / jnp.sum(self.moved**2))
        tells = ~first & (left > EXACT)
        worst = jnp.where(tells, jnp.maximum(self.worst, kept), self.worst)
        count = self.corrections + 1
        return Chord(self.y + step, change, step, left, self.left, worst, count, self.enough)

    @property
    def converged(self) -> Bool[Array, ""]:
        """Whether y is a root."""
        # A last correction, of which the residual before it tells what is left, is in y; the first
        # says nothing about how fast they contract.
        left = self.left * jnp.minimum(self.worst, self.left / jnp.maximum(self.before, 1e-300))
        return (self.corrections > 1) & (left < self.enough)

    @property
    def unfinished(self) -> Bool[Array, ""]:
        """Whether more corrections may help."""
        going = (self.corrections < _LONGEST) & (self.worst < CONTRACTING)
        return going & ~self.converged


def chord_corrector(
    values: Callable[[Float[Array, " n"], Float[Array, " k"]], Float[Array, " n"]],
    linearised: Callable[
        [Float[Array, " n"], Float[Array, " k"]], tuple[Float[Array, " n"], Float[Array, "n n"]]
    ],
) -> Corrector:
    """Corrections for `values(y, h) = 0`, dimensionless, by its Jacobian at the prediction.

    Away from its prediction a correction counts as failed, wherever it may lead; so does one that
    contracts so slowly that the determinant might have another sign than at the prediction.

    **Arguments:**

    - `linearised`: the values, and their derivative in y.
    """

    def correct(predicted, slope, h, dh, reach):
        f, jacobian = linearised(predicted, h)
        inverse, sign = inverse_with_sign(jacobian)

        def advanced(now: Chord, f) -> Chord:
            return now.advanced(-inverse @ f, jnp.max(jnp.abs(f)))

        def unfinished(now: Chord):
            near = jnp.max(jnp.abs(now.y - predicted)) < reach
            return now.unfinished & near & (now.worst < _SURE)

        def sure(now: Chord):
            return now.converged & (now.worst < _SURE)

        def lacks(now: Chord, turned: Chord):
            moved = jnp.max(jnp.abs(turned.moved))
            rough = (turned.corrections == 0) | (moved > _ROUGH * jnp.max(jnp.abs(turned.y)))
            return sure(now) & rough & (turned.corrections < _TURNS)

        def going(state: tuple[Chord, Chord]):
            return unfinished(state[0]) | lacks(*state)

        def advance(state: tuple[Chord, Chord]):
            """The root first, then its slope: the program has one copy of the equations."""
            now, turned = state
            root = unfinished(now)
            # At a root all that the difference sees is what the slope lacks.
            aside = jnp.where(root, 0.0, _ASIDE)
            f = values(now.y + aside * turned.y, h + aside * dh) / jnp.where(root, 1.0, _ASIDE)
            new = advanced(_either(root, now, turned), f)
            return _either(root, new, now), _either(root, turned, new)

        begin = advanced(Chord.start(predicted), f), Chord.start(slope)
        now, turned = jax.lax.while_loop(going, advance, begin)
        return Corrected(now.y, sure(now), sign, turned.y)

    return correct


def _either(which: Bool[Array, ""], one: Chord, other: Chord) -> Chord:
    return jax.tree.map(lambda a, b: jnp.where(which, a, b), one, other)
