"""Newton's method for many cases at once: few Jacobians, each used for several corrections."""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, ArrayLike, Bool, Float, Int

from ..lanes import over_lanes
from ..queue import queued_loop
from ..robots.robot import Robot
from ..rods.solver import Scheme, Steps, as_scheme
from .arrow import Parts, System
from .continuation import DEVIATION
from .linear import solve_many_with_sign
from .problem import Problem
from .residual import units_of
from .unknowns import unknown_scales

_ITERATIONS = 6

_CLOSE = 1e-9
"""Residual below which a last step of Newton's method, which squares the error, is added."""

_SLACK = 1e-3
"""How far from a solution its slopes and its sign may be taken, in dimensionless unknowns."""


class Settled(NamedTuple):
    """Where a prediction has led, in dimensionless unknowns.

    **Attributes:**

    - `y`: the unknowns.
    - `converged`: whether they solve the equations, wherever they are.
    - `deviation`: largest distance of an unknown from its prediction.
    - `sign`: of `det ∂R/∂y`.
    - `slope`: `(∂R/∂y)⁻¹` times the right-hand sides that were given.
    """

    y: Float[Array, " n_y"]
    converged: Bool[Array, ""]
    deviation: Float[Array, ""]
    sign: Float[Array, ""]
    slope: Float[Array, "n_y k"]


def settle(
    problem: Problem,
    guess: Float[Array, " n_y"],
    rights: Float[Array, "n_y k"],
    steps: Steps,
    chords: int = 0,
    slots: int = 32,
    reach: ArrayLike = DEVIATION,
) -> Settled:
    """Newton's method from a prediction, undamped.

    **Arguments:**

    - `guess`: dimensionless unknowns.
    - `rights`: right-hand sides for `slope`, in the order of R.
    - `chords`: corrections that use a Jacobian again: they make batches faster, programs larger.
        Without them the whole Jacobian is eliminated, with them leg by leg, from an integration
        that is only as accurate as they need it.
    - `slots`: of a batch, how many lanes are worked on at a time: the fewer, the less they wait for
        each other, and the less is done in vain where there are few.
    - `reach`: distance from the prediction beyond which it is given up.
    """

    def unfinished(state):
        now, moved, count = state
        near = jnp.max(jnp.abs(now.y - guess)) < reach
        return (count < _ITERATIONS) & ((now.residual > _CLOSE) | (moved > _SLACK)) & near

    def newton(state):
        before, _, count = state
        now = _correct(problem, before.y, rights, steps, chords)
        return now, jnp.max(jnp.abs(now.y - before.y)), count + 1

    one = jnp.ones((), guess.dtype)
    first = _Corrected(guess, jnp.inf * one, one, jnp.zeros(rights.shape, guess.dtype))
    begin = first, jnp.inf * one, jnp.array(0)
    now, _, _ = queued_loop(unfinished, newton, begin, slots=slots)
    # Below the tolerance, the last change of y has squared the error once more.
    converged = (now.residual <= _CLOSE) & jnp.all(jnp.isfinite(now.y))
    return Settled(now.y, converged, jnp.max(jnp.abs(now.y - guess)), now.sign, now.slope)


def linearised(
    problem: Problem, y: Float[Array, " n_y"], steps: Steps, units: Robot | None = None
) -> tuple[Float[Array, " n_y"], Float[Array, "n_y n_y"]]:
    """As `values`, by default in units of the robot's own, and `∂R/∂y`; not differentiated."""
    units = problem.robot if units is None else units
    scaling = unknown_scales(units), units_of(units)
    return _linearised(problem, scaling, y, jnp.asarray(as_scheme(steps)))


def values(
    problem: Problem, y: Float[Array, " n_y"], steps: Steps, units: Robot
) -> Float[Array, " n_y"]:
    """`R(y, ρ)` at unknowns, and in rows, whose units are those of the robot `units`.

    Batches run with their lanes last in memory; derivatives are those of a single case.
    """
    scaling = unknown_scales(units), units_of(units)
    return _values(problem, scaling, y, jnp.asarray(as_scheme(steps)))


class _Corrected(NamedTuple):
    """As `Settled`, after one iteration; `residual` is from before the last change of y."""

    y: Float[Array, " n_y"]
    residual: Float[Array, ""]
    sign: Float[Array, ""]
    slope: Float[Array, "n_y k"]


def _correct(problem: Problem, y, rights, steps: Steps, chords: int) -> _Corrected:
    if chords == 0:
        # A Jacobian that is used once is hardly worth its elimination by leg.
        values, matrix = linearised(problem, y, steps)
        both = jnp.column_stack([values, rights])
        solved, sign = solve_many_with_sign(matrix, both)
        return _Corrected(y - solved[:, 0], jnp.max(jnp.abs(values)), sign, solved[:, 1:])
    robot = problem.robot
    scaling = unknown_scales(robot), units_of(robot)
    scheme = jnp.asarray(as_scheme(steps))
    return _correction(chords)(problem, scaling, y, rights, scheme, _rough(scheme))


@functools.cache
def _correction(chords: int):
    @over_lanes
    def kernel(problem, scaling, y, rights, steps, rough):
        """One Jacobian and what follows from it."""
        system, start = _posed(problem, scaling, y, rough)
        values, inverse = system.inverted(start)
        system, _ = _posed(problem, scaling, y, steps)

        def unfinished(state):
            count, _, left = state
            return (count <= chords) & jnp.any(left > _CLOSE)

        def correct(state):
            count, now, left = state
            values = system.values(now)
            going = left > _CLOSE
            now = _changed(now, inverse.of(values), going)
            return count + 1, now, jnp.where(going, values.largest(), left)

        # Where it is not that rough, the first correction has its values already.
        same = jnp.all(rough == steps)
        far = jnp.where(same, values.largest(), jnp.inf)
        begin = _changed(start, inverse.of(values), jnp.broadcast_to(same, far.shape))
        first = same.astype(int), begin, far
        _, now, left = lax.while_loop(unfinished, correct, first)
        slope = jax.vmap(
            lambda right: inverse.of(system.rows(right)).flat(), in_axes=1, out_axes=1
        )(rights)
        return _Corrected(now.flat(), left, inverse.sign, slope)

    return kernel


def _rough(scheme: Int[Array, "3"]) -> Int[Array, "3"]:
    """Enough for a Jacobian of chords, in half of the work; with less many do not contract.

    Where a scheme is less work itself, the scheme.
    """
    steps = jnp.maximum(2, jnp.round(0.4 * scheme[0]).astype(scheme.dtype))
    rough = jnp.stack([steps, 8, 8])
    return jnp.where(Scheme(*rough).work < Scheme(*scheme).work, rough, scheme)


def _posed(problem, scaling, y, steps) -> tuple[System, Parts]:
    """The equations and y; with y for each lane, all that is calculated varies among them."""
    scale, units = scaling
    system = System(problem, scale, units, steps)
    lanes = max(leaf.shape[-1] for leaf in jax.tree.leaves((y, problem)))
    return system, system.unknowns(jnp.broadcast_to(y, (len(y), lanes)))


def _changed(y: Parts, change: Parts, where: Bool[Array, " lanes"]) -> Parts:
    return jax.tree.map(lambda y, dy: jnp.where(where, y - dy, y), y, change)


@jax.custom_jvp
def _values(*args):
    return over_lanes(_values_of_lanes)(*args)


@_values.defjvp
def _values_and_slope(args, tangents):
    # A batch by `over_lanes` has no derivative of its own.
    def single(*args):
        return _values_of_lanes(*jax.tree.map(lambda leaf: leaf[..., None], args))[..., 0]

    return jax.jvp(single, args, tangents)


def _values_of_lanes(problem, scaling, y, steps):
    system, start = _posed(problem, scaling, y, steps)
    return system.in_rows(system.values(start))


@over_lanes
def _linearised(problem, scaling, y, steps):
    system, start = _posed(problem, scaling, y, steps)
    values, blocks = system.linearised(start)
    return system.in_rows(values), system.matrix(blocks)
