"""Monte Carlo at (0, 0.2): cpr_jax and scipy on the same samples, at equal accuracy."""

from typing import NamedTuple

import numpy as np

import cpr_jax as cpr
from cpr_jax.rods.integration import DEFAULT_STEPS

from . import scipy_peer as peers
from .timing import FirstCall, first_call, take_turns

POINT = (0.0, 0.2)
"""End-effector, m."""

REQUIRED = 300.0
"""How many times faster per sample cpr_jax is to be, warm."""

COARSE_STEPS = 5
"""Integration steps that still give about 1e-8 m here."""

SCIPY_SAMPLES = 20
"""Samples that scipy solves in each repeat, and on which errors are measured."""

LADDER = tuple(10.0 ** (-k / 2) for k in range(10, 25))
"""Tolerances that scipy may take."""


class Row(NamedTuple):
    """One line of the table.

    **Attributes:**

    - `name`: the program and its setting.
    - `samples`: solved in one call.
    - `wall`, `cpu`: time per sample, s.
    - `error`: largest error of a platform coordinate, m.
    - `ratios`: how many times slower each scipy peer of equal accuracy is, by its name.
    """

    name: str
    samples: int
    wall: float
    cpu: float
    error: float
    ratios: dict[str, float]


class Outcome(NamedTuple):
    """What a run measured: rows, and the first calls of cpr_jax by name."""

    rows: list[Row]
    first_calls: dict[str, FirstCall]


def equal_tolerance(peer, nominal, slope, samples, exact, error: float) -> tuple[float, float]:
    """The loosest tolerance at which scipy's error is at most twice another, and that error."""
    for tolerance in LADDER:
        ends = peers.solve_samples(peer, nominal, slope, samples, tolerance)
        own = float(np.max(np.abs(ends - exact)))
        if own <= 2.0 * error:
            break
    return tolerance, own


def run(samples: int, rounds: int) -> Outcome:
    """Measures everything; needs float64."""
    robot = cpr.rfrfr()
    firsts = {"solve_inverse": first_call(lambda: cpr.solve_inverse(robot, POINT))}
    equilibrium = cpr.solve_inverse(robot, POINT)

    def study(count: int, steps: int):
        return cpr.monte_carlo(robot, equilibrium, count, steps=steps)

    settings = (DEFAULT_STEPS, COARSE_STEPS)
    for steps in settings:
        firsts[f"monte_carlo, {steps} steps"] = first_call(
            lambda steps=steps: study(samples, steps)
        )

    rho = study(SCIPY_SAMPLES, DEFAULT_STEPS).rho
    nominal = peers.solve(peers.LEAN, peers.RHO, np.asarray(equilibrium.y), peers.REFERENCE)
    slope = peers.tangent(nominal)
    exact = peers.solve_samples(peers.LEAN, nominal, slope, rho, peers.REFERENCE)

    calls, details, partners = {}, {}, {}
    for steps in settings:
        error = float(np.max(np.abs(study(SCIPY_SAMPLES, steps).q_p - exact)))
        mine, theirs = [], {}
        for count in (samples, 10 * samples):
            name = f"cpr_jax, {steps} steps, {count} samples"
            calls[name] = lambda count=count, steps=steps: study(count, steps)
            details[name] = (f"cpr_jax, {steps} steps", count, error)
            mine.append(name)
        for peer in (peers.PRINTED, peers.LEAN):
            tolerance, own = equal_tolerance(peer, nominal, slope, rho, exact, error)
            name = f"{peer.name}, {tolerance:.0e}"
            calls[name] = lambda peer=peer, tolerance=tolerance: peers.solve_samples(
                peer, nominal, slope, rho, tolerance
            )
            details[name] = (name, SCIPY_SAMPLES, own)
            theirs[peer.name] = name
        partners |= dict.fromkeys(mine, theirs)

    timings = take_turns(calls, rounds)
    rows = []
    for name, (title, count, error) in details.items():
        wall, cpu = (seconds / count for seconds in timings[name])
        ratios = {
            peer: timings[other].wall / SCIPY_SAMPLES / wall
            for peer, other in partners.get(name, {}).items()
        }
        rows.append(Row(title, count, wall, cpu, error, ratios))
    return Outcome(rows, firsts)
