"""Monte Carlo beside programs that others would write, each as accurate as it must be."""

import importlib.util
import itertools
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

import cpr_jax as cpr

from . import casadi_peer, jax_peer, native_peer, numba_peer, scipy_peer
from .timing import take_turns

ACCURACY = 1e-8
"""Largest error of a platform coordinate that counts as accurate, m."""

REFERENCE_STEPS = 40

Study = Callable[[np.ndarray], np.ndarray]


class Contender(NamedTuple):
    """A program with its setting, and how many samples it takes in a repeat."""

    name: str
    solve: Study
    samples: int


class PeerRow(NamedTuple):
    """One line of the table: times in s, the error in m, and how many times slower it is."""

    name: str
    samples: int
    first: float
    wall: float
    error: float
    ratio: float


def run_peers(point: tuple[float, float], samples: int, rounds: int) -> tuple[list[PeerRow], list]:
    """Measures all that are installed; returns rows, and why the others are missing.

    **Arguments:**

    - `samples`: that the fast ones solve in a repeat; the slow ones solve fewer.
    """
    robot = cpr.rfrfr()
    equilibrium = cpr.solve_inverse(robot, point)
    reference = cpr.monte_carlo(robot, equilibrium, samples, steps=REFERENCE_STEPS, keep=samples)
    rho, exact = reference.rho, reference.q_p

    def study(_: np.ndarray) -> np.ndarray:
        return cpr.monte_carlo(robot, equilibrium, samples, keep=samples).q_p

    nominal = scipy_peer.solve(
        scipy_peer.LEAN, scipy_peer.RHO, np.asarray(equilibrium.y), scipy_peer.REFERENCE
    )
    slope = scipy_peer.tangent(nominal)
    contenders, missing, firsts, errors = [Contender("cpr_jax", study, samples)], [], {}, {}
    for name, needs, ladder in _ladders(nominal, slope, samples):
        if needs is not None:
            missing.append(f"{name} is left out: {needs}.")
            continue
        for contender in ladder:
            begin = time.perf_counter()
            ends = contender.solve(rho[: contender.samples])
            firsts[contender.name] = time.perf_counter() - begin
            error = float(np.max(np.abs(ends - exact[: contender.samples])))
            if error <= ACCURACY:
                contenders.append(contender)
                errors[contender.name] = error
                break
        else:
            missing.append(f"{name} is left out: none of its settings is accurate enough.")
    begin = time.perf_counter()
    errors["cpr_jax"] = float(np.max(np.abs(study(rho) - exact)))
    firsts["cpr_jax"] = time.perf_counter() - begin

    timings = take_turns(
        {c.name: lambda c=c: c.solve(rho[: c.samples]) for c in contenders}, rounds
    )
    own = timings["cpr_jax"].wall / samples
    rows = []
    for name, _, count in contenders:
        wall = timings[name].wall / count
        rows.append(PeerRow(name, count, firsts[name], wall, errors[name], wall / own))
    return rows, missing


def _ladders(
    nominal: np.ndarray, slope: np.ndarray, samples: int
) -> Iterator[tuple[str, str | None, Iterator[Contender]]]:
    """Each peer from coarse to fine, and what it lacks if it cannot run."""

    def absent(module: str) -> str | None:
        return None if importlib.util.find_spec(module) else f"{module} is not installed"

    def native(threads: int) -> Iterator[Contender]:
        solve = native_peer.make(nominal, slope)
        for iterations, steps in itertools.product((3, 4), (5, 6, 7, 8)):
            yield Contender(
                f"C++, {threads} threads, {steps} steps, {iterations} iterations",
                lambda rho, n=steps, k=iterations: solve(rho, n, k, threads),
                samples,
            )

    def numba() -> Iterator[Contender]:
        solve = numba_peer.make(nominal, slope)
        for steps in (50, 70, 100, 140, 200):
            yield Contender(
                f"numba, RK4, {steps} steps", lambda rho, n=steps: solve(rho, n, 3), samples // 10
            )

    def casadi() -> Iterator[Contender]:
        for steps in (25, 35, 50, 70, 100, 140, 200):
            solve = casadi_peer.make(nominal, slope, steps)
            yield Contender(f"CasADi, RK4, {steps} steps", solve, samples // 100)

    def plain() -> Iterator[Contender]:
        for exponent in (5, 6, 7, 8, 9):
            solve = jax_peer.make(nominal, slope, 10.0**-exponent)
            name = f"diffrax and optimistix, tolerance 1e-{exponent}"
            yield Contender(name, solve, samples // 100)

    compiler = None if native_peer.compiler() else "there is no C++ compiler"
    yield "C++", compiler, native(1)
    yield "C++ with two threads", compiler, native(2)
    yield "numba", absent("numba"), numba()
    yield "CasADi", absent("casadi"), casadi()
    yield "the plain composition", None, plain()
