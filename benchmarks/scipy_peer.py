"""The paper's robot as one would write it with scipy: plain shooting, sample by sample.

The rods are (14) in the angle θ, integrated by `solve_ivp` with DOP853; the residual is (15) with
the moment at the pivot; `scipy.optimize.root` with `hybr` solves it. What saves scipy time is
done: unknowns and rows are scaled, the held motors are no unknowns, the right-hand side is made
of Python floats, the constant internal force is not integrated, and each sample starts at the
tangent prediction from the nominal solution.
"""

import dataclasses
import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

LENGTH, BEFORE, AFTER, DISTANCE = 0.25, 0.045, 0.035, 0.2
"""l, a, b and d of Table 1, m."""

F_P = np.array([0.0, 1.0])
"""Force on the platform, N."""

RHO = np.array([0.0183, -1.0, 0.0183, 1.0])
"""Nominal (k_b1, r_c1, k_b2, r_c2), N·m² and m."""

_FORCE = 0.0183 / LENGTH**2
_UNITS = np.array([LENGTH, LENGTH, *[_FORCE, _FORCE, _FORCE * LENGTH] * 2])
_ROWS = np.array([_FORCE, _FORCE, *[_FORCE * LENGTH] * 2, *[LENGTH] * 4])


@dataclasses.dataclass(frozen=True)
class Tolerance:
    """How exactly scipy works.

    **Attributes:**

    - `rtol`: relative tolerance of `solve_ivp`; the absolute one is a hundredth of it.
    - `xtol`: relative tolerance of `root`.
    """

    rtol: float
    xtol: float


REFERENCE = Tolerance(1e-13, 1e-13)


def leg(q: float, motor: float, mu, k_b: float, r_c: float, tolerance: Tolerance):
    """Pivot of a leg, m, and the moment there, N·m, from the base wrench `(n_y, n_z, m)`."""
    n_y, n_z, m = (float(c) for c in mu)
    compliance, rest = 1.0 / float(k_b), 1.0 / float(r_c)

    def field(s, x):
        c, sine = math.cos(x[2]), math.sin(x[2])
        return [c, sine, compliance * x[3] + rest, n_y * sine - n_z * c]

    start = [motor + BEFORE * math.cos(q), BEFORE * math.sin(q), q, m]
    tip = solve_ivp(
        field,
        (0.0, LENGTH),
        start,
        method="DOP853",
        rtol=tolerance.rtol,
        atol=0.01 * tolerance.rtol,
    ).y[:, -1]
    b_y, b_z = AFTER * math.cos(tip[2]), AFTER * math.sin(tip[2])
    return (tip[0] + b_y, tip[1] + b_z), tip[3] - (b_y * n_z - b_z * n_y)


def residual(unknowns: np.ndarray, q, rho, tolerance: Tolerance) -> np.ndarray:
    """The rows of (15) without the imposed one at `(p_P, μ_1, μ_2)`, all dimensionless."""
    x = unknowns * _UNITS
    end, first, second = x[:2], x[2:5], x[5:]
    pivot_1, moment_1 = leg(q[0], -0.5 * DISTANCE, first, rho[0], rho[1], tolerance)
    pivot_2, moment_2 = leg(q[1], 0.5 * DISTANCE, second, rho[2], rho[3], tolerance)
    rows = [F_P - first[:2] - second[:2], (moment_1, moment_2), end - pivot_1, end - pivot_2]
    return np.concatenate(rows) / _ROWS


def solve(q, rho, guess: np.ndarray, tolerance: Tolerance) -> np.ndarray:
    """`(p_P, μ_1, μ_2)` in SI units with the motors held at `q`."""
    found = root(
        residual,
        guess / _UNITS,
        args=(q, rho, tolerance),
        method="hybr",
        options={"xtol": tolerance.xtol, "eps": tolerance.rtol},
    )
    if np.max(np.abs(found.fun)) > 1e-6:
        raise RuntimeError(f"scipy found no equilibrium: {found.message}")
    return found.x * _UNITS


def tangent(q, nominal: np.ndarray) -> np.ndarray:
    """`∂(p_P, μ)/∂ρ` by central differences of solutions, for the prediction (12)."""
    columns = []
    for j, value in enumerate(RHO):
        step = np.zeros(RHO.size)
        step[j] = 1e-4 * value
        ends = [solve(q, RHO + sign * step, nominal, REFERENCE) for sign in (1.0, -1.0)]
        columns.append((ends[0] - ends[1]) / (2.0 * step[j]))
    return np.stack(columns, axis=1)


def solve_samples(q, nominal, slope, samples, tolerance: Tolerance) -> np.ndarray:
    """`p_P` of each sample of ρ, m, from the tangent prediction; shape `(samples, 2)`."""
    ends = [solve(q, rho, nominal + slope @ (rho - RHO), tolerance)[:2] for rho in samples]
    return np.array(ends)
