"""A chord iteration to the equilibrium at other parameters, with evidence of its branch."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, ArrayLike, Bool, Float

from ..analysis.expansion import Expansion
from ..statics.chord import CONTRACTING, EXACT, Chord


class ChordIteration:
    """Corrections by a matrix M, the inverse of the Jacobian J expanded in the parameters.

    M differs from sample to sample: it needs no derivative of a rod and still gains two digits or
    more at each turn. Each change is combined with the one before it (Anderson, 1965).

    Where `1 - M J` contracts, both determinants have the same sign, which is that of the branch
    as long as that of M does not change: see `turn`.

    **Attributes:**

    - `slope`, `curve`: first and second derivative of the unknowns on the way to the parameters.
    - `guess`: where they lead, and the iteration starts.
    - `turn`: T, see `Expansion.turned`; where `det(1 + T) > 0`, M has the sign of the nominal one.
    """

    def __init__(
        self,
        expansion: Expansion,
        equations: Callable[[Float[Array, " n_r"], Float[Array, " n_rho"]], Float[Array, " n_r"]],
        rho: Float[Array, " n_rho"],
        second_order: bool,
        enough: ArrayLike = EXACT,
    ):
        away = rho - expansion.rho
        self.slope = expansion.first @ away
        self.curve = jnp.zeros_like(expansion.y)
        if second_order:
            self.curve = (expansion.second @ away) @ away
        shift = self.slope + 0.5 * self.curve
        self.guess = expansion.y + shift
        self.turn = expansion.turned(away)
        self._largest = jnp.max(jnp.abs(shift))
        self._expansion, self._equations, self._rho = expansion, equations, rho
        self._enough = enough

    def _change(self, y):
        f = self._equations(y, self._rho)
        axes = self._expansion.axes
        chord = (axes.T @ self._expansion.inverse) @ f
        return -axes @ (chord + self.turn @ chord), jnp.max(jnp.abs(f))

    def start(self) -> Chord:
        """Before the first correction."""
        return Chord.start(self.guess, self._enough)

    def advance(self, now: Chord) -> Chord:
        """After one more."""
        return now.advanced(*self._change(now.y))

    def is_sure(self, now: Chord) -> Bool[Array, ""]:
        """Whether it has converged, always contracting, near its prediction."""
        near = jnp.max(jnp.abs(now.y - self.guess)) <= 0.02 + 0.3 * self._largest
        return now.converged & (now.worst < CONTRACTING) & near
