"""The paper's robot as one would write it with scipy: plain shooting, sample by sample.

The rods are (14) in the angle θ, integrated by `solve_ivp` with DOP853; the residual is (15) with
the moment at the pivot; `scipy.optimize.root` with `hybr` solves it, unknowns and rows scaled.
Each sample starts at the tangent prediction from the nominal solution. There are two of them:
`PRINTED` follows (14) and (15) to the letter, `LEAN` saves scipy what can be saved.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

LENGTH, BEFORE, AFTER, DISTANCE = 0.25, 0.045, 0.035, 0.2
"""l, a, b and d of Table 1, m."""

F_P = np.array([0.0, 1.0])
"""Force on the platform, N."""

RHO = np.array([0.0183, -1.0, 0.0183, 1.0])
"""Nominal (k_b1, r_c1, k_b2, r_c2), N·m² and m."""

REFERENCE = 1e-13
"""Tolerance of the solutions that errors are measured against."""

_FORCE = 0.0183 / LENGTH**2
_WRENCH = [_FORCE, _FORCE, _FORCE * LENGTH]
_UNITS = np.array([1.0, 1.0, LENGTH, LENGTH, *_WRENCH, *_WRENCH])
_ROWS = np.array([_FORCE, _FORCE, *[_FORCE * LENGTH] * 2, *[LENGTH] * 4])


def printed_leg(q: float, motor: float, mu, k_b: float, r_c: float, tolerance: float):
    """Pivot of a leg, m, and the moment there, N·m; the state is the `(ξ, μ)` of (14)."""

    def field(s, x):
        c, sine = np.cos(x[2]), np.sin(x[2])
        return np.array([c, sine, x[5] / k_b + 1.0 / r_c, 0.0, 0.0, x[3] * sine - x[4] * c])

    start = [motor + BEFORE * np.cos(q), BEFORE * np.sin(q), q, *mu]
    y, z, angle, n_y, n_z, m = _tip(field, start, tolerance)
    b_y, b_z = AFTER * np.cos(angle), AFTER * np.sin(angle)
    return (y + b_y, z + b_z), m - (b_y * n_z - b_z * n_y)


def lean_leg(q: float, motor: float, mu, k_b: float, r_c: float, tolerance: float):
    """As `printed_leg`, with Python floats and without integrating the constant force."""
    n_y, n_z, m = (float(c) for c in mu)
    compliance, rest = 1.0 / float(k_b), 1.0 / float(r_c)

    def field(s, x):
        c, sine = math.cos(x[2]), math.sin(x[2])
        return [c, sine, compliance * x[3] + rest, n_y * sine - n_z * c]

    start = [motor + BEFORE * math.cos(q), BEFORE * math.sin(q), q, m]
    y, z, angle, m = _tip(field, start, tolerance)
    b_y, b_z = AFTER * math.cos(angle), AFTER * math.sin(angle)
    return (y + b_y, z + b_z), m - (b_y * n_z - b_z * n_y)


def _tip(field, start, tolerance):
    options = {"method": "DOP853", "rtol": tolerance, "atol": 0.01 * tolerance}
    return solve_ivp(field, (0.0, LENGTH), start, **options).y[:, -1]


class Peer(NamedTuple):
    """One way to write it.

    **Attributes:**

    - `name`: for tables.
    - `leg`: as `printed_leg`.
    - `held`: leading entries of `y = (q_a, p_P, μ)` that are no unknowns: the held motors, or
        none, where rows `q_a - q_a^d` hold them.
    """

    name: str
    leg: Callable
    held: int


PRINTED = Peer("scipy, as printed", printed_leg, held=0)
LEAN = Peer("scipy, lean", lean_leg, held=2)


def residual(peer: Peer, y: np.ndarray, q: np.ndarray, rho, tolerance: float) -> np.ndarray:
    """(15) at `y` in SI units, its rows dimensionless, the imposed ones last."""
    end, first, second = y[2:4], y[4:7], y[7:]
    pivot_1, moment_1 = peer.leg(y[0], -0.5 * DISTANCE, first, rho[0], rho[1], tolerance)
    pivot_2, moment_2 = peer.leg(y[1], 0.5 * DISTANCE, second, rho[2], rho[3], tolerance)
    rows = [F_P - first[:2] - second[:2], (moment_1, moment_2), end - pivot_1, end - pivot_2]
    return np.concatenate([np.concatenate(rows) / _ROWS, (y[:2] - q)[peer.held :]])


def solve(peer: Peer, rho, guess: np.ndarray, tolerance: float) -> np.ndarray:
    """`y` with the motors held where `guess` has them."""
    q, held = guess[:2], peer.held

    def equations(scaled):
        y = np.concatenate([q[:held], scaled * _UNITS[held:]])
        return residual(peer, y, q, rho, tolerance)

    # Differences of the integration are no better than its tolerance.
    options = {"xtol": tolerance, "eps": tolerance}
    found = root(equations, (guess / _UNITS)[held:], method="hybr", options=options)
    if np.max(np.abs(found.fun)) > 1e-4:
        raise RuntimeError(f"scipy found no equilibrium: {found.message}")
    return np.concatenate([q[:held], found.x * _UNITS[held:]])


def tangent(nominal: np.ndarray) -> np.ndarray:
    """`∂y/∂ρ` by central differences of solutions, for the prediction (12)."""
    columns = []
    for j, value in enumerate(RHO):
        step = np.zeros(RHO.size)
        step[j] = 1e-4 * value
        plus, minus = (solve(LEAN, RHO + s * step, nominal, REFERENCE) for s in (1.0, -1.0))
        columns.append((plus - minus) / (2.0 * step[j]))
    return np.stack(columns, axis=1)


def solve_samples(peer: Peer, nominal, slope, samples, tolerance: float) -> np.ndarray:
    """`p_P` of each sample of ρ, m, from the tangent prediction; shape `(samples, 2)`."""
    starts = [nominal + slope @ (rho - RHO) for rho in samples]
    ends = [solve(peer, rho, start, tolerance) for rho, start in zip(samples, starts, strict=True)]
    return np.array(ends)[:, 2:4]
