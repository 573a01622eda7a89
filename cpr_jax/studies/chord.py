"""A chord iteration to the equilibrium at other parameters, with evidence of its branch."""

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..analysis.expansion import Expansion

_TOLERANCE = 1e-11
_CONTRACTING = 0.9
_LONGEST = 20


class Corrected(NamedTuple):
    """Unknowns after some corrections, in `y / unknown_scales`.

    **Attributes:**

    - `y`: the unknowns.
    - `chord`: what M made of the residual last; `moved`: the correction that came of it.
    - `left`: largest entry of that residual; `before`: of the one before it.
    - `worst`: slowest contraction of the corrections so far.
    - `corrections`: how many there were.
    """

    y: Float[Array, " n_r"]
    chord: Float[Array, " n_r"]
    moved: Float[Array, " n_r"]
    left: Float[Array, ""]
    before: Float[Array, ""]
    worst: Float[Array, ""]
    corrections: Int[Array, ""]


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

    def _change(self, y):
        f = self._equations(y, self._rho)
        axes = self._expansion.axes
        chord = (axes.T @ self._expansion.inverse) @ f
        return -axes @ (chord + self.turn @ chord), jnp.max(jnp.abs(f))

    def start(self) -> Corrected:
        """Before the first correction."""
        none, zero = jnp.zeros_like(self.guess), jnp.zeros_like(self._largest)
        return Corrected(self.guess, none, none, zero, zero, zero, jnp.array(0))

    def advance(self, now: Corrected) -> Corrected:
        """After one more."""
        new, left = self._change(now.y)
        first = now.corrections == 0
        bent = new - now.chord
        share = jnp.sum(new * bent) / jnp.maximum(jnp.sum(bent**2), 1e-300)
        step = new - jnp.where(first, 0.0, share) * (now.moved + bent)
        # What `1 - M J` makes of the last step; below the tolerance, of rounding errors.
        kept = jnp.sqrt(jnp.sum((now.moved + bent) ** 2) / jnp.sum(now.moved**2))
        tells = ~first & (left > _TOLERANCE)
        worst = jnp.where(tells, jnp.maximum(now.worst, kept), now.worst)
        return Corrected(now.y + step, new, step, left, now.left, worst, now.corrections + 1)

    def unfinished(self, now: Corrected) -> Bool[Array, ""]:
        """Whether more corrections may help."""
        return (now.corrections < _LONGEST) & ~_converged(now) & (now.worst < _CONTRACTING)

    def is_sure(self, now: Corrected) -> Bool[Array, ""]:
        """Whether it has converged, always contracting, near its prediction."""
        near = jnp.max(jnp.abs(now.y - self.guess)) <= 0.02 + 0.3 * self._largest
        return _converged(now) & (now.worst < _CONTRACTING) & near


def _converged(now: Corrected) -> Bool[Array, ""]:
    # A last correction, of which the residual before it tells what is left, is in y; the first
    # says nothing about how fast they contract.
    left = now.left * jnp.minimum(now.worst, now.left / now.before)
    return (now.corrections > 1) & (left < _TOLERANCE)
