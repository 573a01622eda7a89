"""An equilibrium and the inverse of its Jacobian, expanded in the robot's parameters."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..background import not_a_number
from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Steps
from ..statics.accuracy import MENU, least_scheme, tip_errors
from ..statics.correction import linearised, values
from ..statics.linear import inverse
from ..statics.problem import Problem, forward_rows
from ..statics.unknowns import unknown_scales
from .parameters import Selection

_REACH = 0.02
"""Share of the parameters' half ranges over which the expansion's differences are taken."""

_ROUGH = 1e-8
"""Error of a rod's tip that an expansion may have, in lengths of the rod."""

_LARGEST = 10_000
"""Numbers that a second order of the inverse may have; beyond that it costs more than it spares."""


class Expansion(eqx.Module):
    """Predictions around an equilibrium whose motors are held, in `y / unknown_scales`.

    The motors are left out of y: it is `(q_p, μ)`. Only a root find starts from an expansion, so
    that its small errors cost time and no accuracy.

    **Attributes:**

    - `y`, `rho`: where it is expanded.
    - `first`: `∂y/∂ρ`, shape `(n_r, n_ρ)`; `second`: `∂²y/∂ρ²`, shape `(n_r, n_ρ, n_ρ)`.
    - `inverse`: `M = (∂R₀/∂y)⁻¹`, shape `(n_r, n_r)`.
    - `axes`: an orthonormal basis as columns, in which T, see `turned`, is nearly triangular.
    - `turn`: T by powers of what parameters differ by: shape `(powers, n_r, n_r)`.
    - `weights`: positive `w` that make `Σ_j |T_ij| w_j / w_i` small over the parameters' ranges.
    - `errors`: `tip_errors`, the largest over the ranges of the parameters.
    """

    y: Float[Array, " n_r"]
    rho: Float[Array, " n_rho"]
    first: Float[Array, "n_r n_rho"]
    second: Float[Array, "n_r n_rho n_rho"]
    inverse: Float[Array, "n_r n_r"]
    axes: Float[Array, "n_r n_r"]
    turn: Float[Array, "powers n_r n_r"]
    weights: Float[Array, " n_r"]
    errors: Float[Array, " schemes"]

    @classmethod
    def unknown(cls, robot: Robot, n_rho: int) -> "Expansion":
        """One that is not a number, for programs that are compiled before there is another."""
        n_r = robot.n_y - robot.n_a
        powers = n_rho + _pairs(n_rho, n_r)[0].size
        return cls(
            y=not_a_number(n_r),
            rho=not_a_number(n_rho),
            first=not_a_number(n_r, n_rho),
            second=not_a_number(n_r, n_rho, n_rho),
            inverse=not_a_number(n_r, n_r),
            axes=not_a_number(n_r, n_r),
            turn=not_a_number(powers, n_r, n_r),
            weights=not_a_number(n_r),
            errors=not_a_number(len(MENU) + 1),
        )

    def turned(self, away: Float[Array, " n_rho"]) -> Float[Array, "n_r n_r"]:
        """T at the parameters `rho + away`, in `axes` A: `A (1 + T) Aᵀ M` is the inverse there."""
        return jnp.tensordot(_powers(away, self.y.size), self.turn, axes=1)

    def is_regular(self, turned: Float[Array, "n_r n_r"]) -> Bool[Array, ""]:
        """Whether `det(1 + T) > 0` is plain to see: Gershgorin's discs lie right of zero."""
        diagonal = jnp.diagonal(turned)
        reach = jnp.abs(turned) @ self.weights / self.weights - jnp.abs(diagonal)
        return jnp.all(1.0 + diagonal > reach)


class HeldEquations:
    """`R₀(y, ρ)` with the motors held where `y` (SI units) has them.

    A function of the unknowns `(q_p, μ)` and of the parameters; unknowns and rows are in units of
    the nominal robot's.
    """

    def __init__(self, robot: Robot, selection: Selection, y: Float[Array, " n_y"], steps: Steps):
        self._robot, self._selection, self._steps = robot, selection, steps
        self._rows, self._target = forward_rows(robot), y[: robot.n_a + robot.n_p]
        self._motors = y[: robot.n_a] / unknown_scales(robot)[: robot.n_a]

    def _posed(self, scaled, rho) -> tuple[Problem, Float[Array, " n_y"]]:
        problem = Problem(self._selection.set(self._robot, rho), self._rows, self._target)
        return problem, jnp.concatenate([self._motors, scaled])

    def __call__(self, scaled, rho) -> Float[Array, " n_r"]:
        R = values(*self._posed(scaled, rho), self._steps, self._robot)
        return R[: scaled.size]

    def linearised(self, scaled, rho) -> tuple[Float[Array, " n_r"], Float[Array, "n_r n_r"]]:
        """R₀ and its derivative in the unknowns; neither is differentiated."""
        R, by_y = linearised(*self._posed(scaled, rho), self._steps, self._robot)
        return R[: scaled.size], by_y[: scaled.size, self._robot.n_a :]


@program
def expand(
    robot: Robot,
    selection: Selection,
    y: Float[Array, " n_y"],
    Pi_y: Float[Array, "n_y n_rho"],
    delta: Float[Array, " n_rho"],
    further: Steps = DEFAULT_STEPS,
) -> Expansion:
    """Expands the equilibrium at the unknowns `y` (SI units), its motors held.

    Second orders come from differences of exact first derivatives at predictions of the
    equilibria nearby: first on the tangent space, which gives `∂²y/∂ρ²`, then on its parabola.

    **Arguments:**

    - `Pi_y`: the sensitivity with the motors held, SI units.
    - `delta`: half ranges, over a small part of which the differences are taken.
    - `further`: a scheme whose error is told as well.
    """
    units = unknown_scales(robot)
    scaled, rho, first = y / units, selection.get(robot), Pi_y / units[:, None]
    scaled, first = scaled[robot.n_a :], first[robot.n_a :]
    n_rho = rho.size

    # A parameter that does not vary still has a derivative.
    size = jnp.where(rho == 0.0, 1e-3, jnp.abs(rho))
    reach = _REACH * jnp.where(delta > 0.0, delta, 1e-3 * size)
    pairs = _pairs(n_rho, scaled.size)
    both = np.eye(n_rho)[pairs[0]] + np.eye(n_rho)[pairs[1]]
    ways = reach * np.concatenate([np.eye(n_rho), both[pairs[0] != pairs[1]]])

    def at_end(way):
        shift = jnp.concatenate([jnp.zeros(robot.n_a), first @ way]) * units
        return selection.set(robot, rho + way), y + shift

    largest = jnp.diag(reach / _REACH)
    reached = jnp.concatenate([jnp.zeros((1, n_rho)), largest, -largest])
    varied, ends = jax.vmap(at_end)(reached)
    errors = tip_errors(varied, ends, further)
    scheme = jnp.array(MENU)[least_scheme(errors, _ROUGH)]
    equations = HeldEquations(robot, selection, y, scheme)
    linearise = jax.jacfwd(equations, argnums=(0, 1))

    def look(second, _):
        """At both ends of all ways, the equilibria there predicted with this second order."""

        def at(way):
            return linearise(scaled + first @ way + 0.5 * (second @ way) @ way, rho + way)

        by_y, by_rho = jax.vmap(at)(jnp.concatenate([jnp.zeros((1, n_rho)), ways, -ways]))

        def rate(values):
            ahead, behind = jnp.split(values[1:], 2)
            return (ahead - behind)[:n_rho] / (2.0 * reach[:, None, None])

        inverses = jax.vmap(inverse)(by_y)
        turn = -jnp.einsum("ij,kjl->kil", inverses[0], rate(by_y))
        bent = jnp.einsum("kij,jl->ilk", turn, first)
        second = bent - jnp.einsum("ij,kjl->ilk", inverses[0], rate(by_rho))
        return 0.5 * (second + second.swapaxes(1, 2)), (by_y[0], inverses, turn)

    straight = jnp.zeros((scaled.size, n_rho, n_rho))
    second, looks = jax.lax.scan(look, straight, length=2 if pairs[0].size else 1)
    matrix, inverses, turn = jax.tree.map(lambda leaf: leaf[-1], looks)
    ahead, behind = jnp.split(inverses[1:], 2)
    bends = (0.5 * (ahead + behind) - inverses[0]) @ matrix
    # What turns nothing goes first, so that T is nearly triangular.
    spread = (delta[:, None, None] * turn).reshape(-1, scaled.size)
    _, axes = jnp.linalg.eigh(spread.T @ spread)
    turn = axes.T @ jnp.concatenate([turn, _of_pairs(bends, pairs, reach)]) @ axes

    return Expansion(
        y=scaled,
        rho=rho,
        first=first,
        second=second,
        inverse=inverses[0],
        axes=axes,
        turn=turn,
        weights=_weights(jnp.tensordot(delta, jnp.abs(turn[:n_rho]), axes=1)),
        errors=errors,
    )


def _pairs(n_rho: int, n_r: int) -> tuple[np.ndarray, np.ndarray]:
    """The products of two parameters in `powers`; none where there would be too many numbers."""
    first, second = np.triu_indices(n_rho)
    kept = slice(first.size if first.size * n_r**2 <= _LARGEST else 0)
    return first[kept], second[kept]


def _powers(away: Float[Array, " n_rho"], n_r: int) -> Float[Array, " powers"]:
    """`Δρ`, and the products of its entries if they are not too many."""
    first, second = _pairs(away.size, n_r)
    # Products with units rather than indices: those are slow in batches.
    units = np.eye(away.size)
    return jnp.concatenate([away, (units[first] @ away) * (units[second] @ away)])


def _of_pairs(bends, pairs, reach):
    """Coefficients of products, from what their sum is along each axis and each sum of two."""
    n_rho, (first, second) = reach.size, pairs
    own, mixed = bends[:n_rho], bends[n_rho:]
    equal = first == second
    # The sum of two ways has what either has, and the product of both.
    place = np.where(equal, first, n_rho + np.cumsum(~equal) - 1)
    every = jnp.concatenate([own, mixed])[place]
    every = every - jnp.where(equal[:, None, None], 0.0, own[first] + own[second])
    return every / (reach[first] * reach[second])[:, None, None]


def _weights(matrix: Float[Array, "n n"]) -> Float[Array, " n"]:
    """The Perron vector of a nonnegative matrix, by power iteration, kept away from zero."""

    def turn(_, vector):
        vector = matrix @ vector
        return jnp.maximum(vector / jnp.max(vector), 1e-6)

    return jax.lax.fori_loop(0, 50, turn, jnp.ones(matrix.shape[0]))
