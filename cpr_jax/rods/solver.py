"""The integrator that diffrax steps along a rod."""

from typing import Any, ClassVar, NamedTuple, TypeAlias

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..errors import InputError, check_integer
from ..geometry import namespace

_MOST = 8
"""Rules that a step may combine."""


class Scheme(NamedTuple):
    """How a rod, or each segment of one, is crossed.

    **Attributes:**

    - `steps`: number of equal steps.
    - `order`: of a step, even, at most 16: half as many midpoint rules are combined.
    - `least`: substeps of the coarsest rule, even; each further one has two more.
    """

    steps: int
    order: int = 10
    least: int = 4

    @property
    def work(self) -> int:
        """Evaluations of the right-hand side along a rod."""
        rules = self.order // 2
        return self.steps * (1 + rules * (self.least + rules - 1))


Steps: TypeAlias = int | Scheme | Int[Array | np.ndarray, ""] | Int[Array | np.ndarray, "3"]
"""A number of steps of order 10, or a `Scheme`; an array is not compiled into a program, which then
serves any of them."""


def checked_scheme(name: str, steps: int | Scheme) -> Scheme:
    """A number of steps of order 10, or a scheme, as a user gave it.

    **Raises:** `InputError` where a number does not fit.
    """
    if not isinstance(steps, Scheme):
        check_integer(name, steps)
        return Scheme(steps)
    check_integer(f"{name}.steps", steps.steps)
    for part, most in (("order", 2 * _MOST), ("least", None)):
        number = getattr(steps, part)
        check_integer(f"{name}.{part}", number, least=2, most=most)
        if number % 2:
            raise InputError(f"Argument `{name}.{part}` must be even, but it is {number}.")
    return steps


def as_scheme(steps: Steps) -> Int[Array, "3"]:
    """The numbers of a scheme."""
    xp = namespace(steps)
    numbers = xp.asarray(steps)
    return numbers if numbers.ndim else xp.stack([numbers, *Scheme(0)[1:]])


class ExtrapolatedMidpoint(diffrax.AbstractSolver):
    """Gragg's modified midpoint rule, extrapolated with fixed numbers of substeps.

    A step of order 10 crosses `[t0, t1]` with 4, 6, 8, 10 and 12 leapfrog substeps and combines the
    ends (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, II.9). A substep
    reads and writes two states in place, and the loops keep the compiled program small. In
    batches on the CPU, beside Dormand–Prince 8 written out straight at equal accuracy, it runs
    twice as fast in the plane, and its tangents in space compile ten times faster.

    **Attributes:**

    - `rules`: how many are combined, half of the order.
    - `least`: substeps of the coarsest.
    - `weights`: of their ends.
    - `compact`: one copy of the right-hand side in the compiled program, in the place of three.
        It moves what a substep has read, which takes a fifth of the time of a batch.
    """

    rules: int | Int[Array, ""]
    least: int | Int[Array, ""]
    weights: Float[Array | np.ndarray, " most"]
    compact: bool

    term_structure: ClassVar = diffrax.ODETerm
    interpolation_cls: ClassVar = diffrax.LocalLinearInterpolation

    def __init__(self, order: Any = 10, least: Any = 4, compact: bool = False):
        self.rules, self.least, self.compact = order // 2, least, compact
        self.weights = _weights(self.rules, least)

    def order(self, terms):
        return 2 * self.rules

    def init(self, terms, t0, t1, y0, args):
        return None

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        weights = jnp.asarray(self.weights)

        def field(t, y):
            return terms.vf(t, y, args)

        slope = None if self.compact else field(t0, y0)

        # Not written out: the compiled program does not grow with the number of rules.
        def add_rule(k, y1):
            n = self.least + 2 * k
            end = _midpoint(field, t0, (t1 - t0) / n, y0, slope, n)
            return _axpy(y1, jax.lax.dynamic_index_in_dim(weights, k, keepdims=False), end)

        y1 = jax.lax.fori_loop(0, self.rules, add_rule, jax.tree.map(jnp.zeros_like, y0))
        return y1, None, dict(y0=y0, y1=y1), None, diffrax.RESULTS.successful

    def func(self, terms, t0, y0, args):
        return terms.vf(t0, y0, args)


def _weights(rules, least):
    """Weights that cancel the errors in h², h⁴, … of the midpoint rule (Aitken–Neville)."""
    xp = namespace(rules, least)
    squares = (least + 2.0 * np.arange(_MOST)) ** 2
    others = (np.arange(_MOST) < rules) & ~np.eye(_MOST, dtype=bool)
    apart = xp.where(others, squares[:, None] - squares, 1.0)
    return xp.prod(xp.where(others, squares[:, None] / apart, 1.0), axis=1)


def _midpoint(field, t0, h, y0, slope, n):
    """`n` leapfrog substeps of length `h`, `n` even."""
    if slope is None:

        def substep(k, carry):
            before, now = carry
            reach = jnp.where(k == 0, h, 2.0 * h)
            return now, _axpy(before, reach, field(t0 + k * h, now))

        _, end = jax.lax.fori_loop(0, n, substep, (y0, y0))
        return end

    def two_substeps(k, carry):
        even, odd = carry
        t = t0 + 2 * k * h
        even = _axpy(even, 2.0 * h, field(t + h, odd))
        odd = _axpy(odd, 2.0 * h, field(t + 2.0 * h, even))
        return even, odd

    even, _ = jax.lax.fori_loop(0, n // 2, two_substeps, (y0, _axpy(y0, h, slope)))
    return even


def _axpy(y, factor, x):
    return jax.tree.map(lambda y, x: y + factor * x, y, x)
