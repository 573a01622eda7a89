"""The Monte Carlo study as cpr_jax and others run it, each in settings from coarse to fine."""

import functools
import importlib.util
import itertools
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

import cpr_jax as cpr
from cpr_jax.statics.accuracy import MENU

from . import casadi_peer, jax_peer, native_peer, numba_peer, scipy_peer
from .building import compiler
from .child import available_cores

POINT = (0.0, 0.2)
"""End-effector, m."""

REFERENCE_STEPS = 40
"""Integration steps of cpr_jax whose solutions all errors are measured against."""

SCIPY_SAMPLES = 20

Study = Callable[[np.ndarray], np.ndarray]


class Contender(NamedTuple):
    """A program with a setting: the platforms `p_P`, m, of parameters, so many in a call."""

    name: str
    solve: Study
    samples: int


class Reached(NamedTuple):
    """The coarsest setting that is accurate enough.

    **Attributes:**

    - `first`: the longest first call of a setting, with what it takes to make it, s.
    - `error`: the largest of a platform coordinate, m.
    """

    contender: Contender
    first: float
    error: float


class Ladder:
    """A program's settings from fast to slow, tried until one is accurate enough."""

    def __init__(self, settings: Iterator[Contender], rho: np.ndarray, exact: np.ndarray):
        self._settings, self._rho, self._exact = settings, rho, exact
        self._tried: list[Reached] = []

    def reach(self, accuracy: float) -> Reached | None:
        """The first setting with at most this error."""
        while True:
            for reached in self._tried:
                if reached.error <= accuracy:
                    return reached
            begin = time.perf_counter()
            contender = next(self._settings, None)
            if contender is None:
                return None
            ends = contender.solve(self._rho[: contender.samples])
            first = max([time.perf_counter() - begin, *(found.first for found in self._tried)])
            error = float(np.max(np.abs(ends - self._exact[: len(ends)])))
            self._tried.append(Reached(contender, first, error if np.isfinite(error) else np.inf))


class Field(NamedTuple):
    """All programs on the same samples.

    **Attributes:**

    - `rho`, `exact`: parameters and their platforms.
    - `ladders`: by the programs' names; `missing`: why others are left out.
    - `agreement`: largest distance between the reference and scipy's best, m.
    """

    robot: cpr.Robot
    equilibrium: cpr.Equilibrium
    rho: np.ndarray
    exact: np.ndarray
    ladders: dict[str, Ladder]
    missing: list[str]
    agreement: float


@functools.cache
def field(samples: int) -> Field:
    """Programs that are installed, with samples for the fast ones; slow ones solve fewer."""
    robot = cpr.rfrfr()
    equilibrium = cpr.solve_inverse(robot, POINT)
    reference = cpr.monte_carlo(robot, equilibrium, samples, steps=REFERENCE_STEPS, keep=samples)
    rho, exact = reference.rho, reference.q_p
    nominal = scipy_peer.solve(
        scipy_peer.LEAN, scipy_peer.RHO, np.asarray(equilibrium.y), scipy_peer.REFERENCE
    )
    slope = scipy_peer.tangent(nominal)
    few = rho[:SCIPY_SAMPLES]
    best = scipy_peer.solve_samples(scipy_peer.LEAN, nominal, slope, few, scipy_peer.REFERENCE)
    ladders, missing = {}, []
    own = "cpr_jax", None, _own(robot, equilibrium, samples)
    for name, needs, settings in (own, *_others(nominal, slope, samples)):
        if needs is None:
            ladders[name] = Ladder(settings, rho, exact)
        else:
            missing.append(f"{name} is left out: {needs}.")
    agreement = float(np.max(np.abs(best - exact[:SCIPY_SAMPLES])))
    return Field(robot, equilibrium, rho, exact, ladders, missing, agreement)


def _own(robot, equilibrium, samples: int) -> Iterator[Contender]:
    for scheme in MENU:

        def study(rho: np.ndarray, scheme: cpr.Scheme = scheme) -> np.ndarray:
            # Its samples are those of the reference, drawn once more.
            return cpr.monte_carlo(robot, equilibrium, len(rho), steps=scheme, keep=len(rho)).q_p

        yield Contender(f"cpr_jax, {in_words(scheme)}", study, samples)


def in_words(scheme: cpr.Scheme) -> str:
    """As the tables name it."""
    return f"{scheme.steps} steps of order {scheme.order}"


def _others(
    nominal: np.ndarray, slope: np.ndarray, samples: int
) -> Iterator[tuple[str, str | None, Iterator[Contender]]]:
    """Each peer, what it lacks if it cannot run, and its settings."""

    def absent(module: str) -> str | None:
        return None if importlib.util.find_spec(module) else f"{module} is not installed"

    def by_scipy(peer: scipy_peer.Peer) -> Iterator[Contender]:
        for exponent in np.arange(4.0, 13.0, 0.5):
            tolerance = 10.0**-exponent

            def solve(rho: np.ndarray, tolerance: float = tolerance) -> np.ndarray:
                return scipy_peer.solve_samples(peer, nominal, slope, rho, tolerance)

            yield Contender(f"{peer.name}, {tolerance:.0e}", solve, SCIPY_SAMPLES)

    def native(threads: int) -> Iterator[Contender]:
        solve = native_peer.make(nominal, slope)
        for iterations, steps in _cheapest_first(
            (2, 3, 4, 5), (2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 17, 20)
        ):
            yield Contender(
                f"C++, {_threads(threads)}, {steps} steps, {iterations} iterations",
                lambda rho, n=steps, k=iterations: solve(rho, n, k, threads),
                samples,
            )

    def numba() -> Iterator[Contender]:
        solve = numba_peer.make(nominal, slope)
        menu = (14, 20, 28, 40, 56, 80, 110, 160, 220, 320, 450, 640)
        for iterations, steps in _cheapest_first((2, 3, 4), menu):
            yield Contender(
                f"numba, RK4, {steps} steps, {iterations} iterations",
                lambda rho, n=steps, k=iterations: solve(rho, n, k),
                samples // 10,
            )

    def casadi() -> Iterator[Contender]:
        for steps in (14, 20, 28, 40, 56, 80, 110, 160, 220, 320):
            solve = casadi_peer.make(nominal, slope, steps)
            yield Contender(f"CasADi, RK4, {steps} steps", solve, samples // 100)

    def plain() -> Iterator[Contender]:
        for exponent in (3, 4, 5, 6, 7, 8, 9, 10, 11):
            solve = jax_peer.make(nominal, slope, 10.0**-exponent)
            name = f"diffrax and optimistix, 1e-{exponent}"
            yield Contender(name, solve, samples // 25)

    yield "scipy, as printed", None, by_scipy(scipy_peer.PRINTED)
    yield "scipy, lean", None, by_scipy(scipy_peer.LEAN)
    without = None if compiler() else "there is no C++ compiler"
    for threads in sorted({1, len(available_cores())}):
        yield f"C++, {_threads(threads)}", without, native(threads)
    yield "numba", absent("numba"), numba()
    yield "CasADi", absent("casadi"), casadi()
    yield "diffrax and optimistix", None, plain()


def _threads(count: int) -> str:
    return "1 thread" if count == 1 else f"{count} threads"


def _cheapest_first(iterations, steps) -> list[tuple[int, int]]:
    return sorted(itertools.product(iterations, steps), key=lambda pair: pair[0] * pair[1])
