"""The paper's robot with CasADi: Runge-Kutta 4 unrolled by `mapaccum`, its Newton root finder."""

from collections.abc import Callable

import numpy as np

from . import scipy_peer


def make(nominal: np.ndarray, slope: np.ndarray, steps: int) -> Callable[[np.ndarray], np.ndarray]:
    """Returns `solve(rho)` for `p_P`, m, mapped over the samples."""
    import casadi as ca

    peer = scipy_peer
    units, rows = peer._UNITS[2:], peer._ROWS
    h = peer.LENGTH / steps

    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 4)  # (y, z, θ, m) and (n_y, n_z, 1/k_b, 1/r_c)

    def field(x):
        c, s = ca.cos(x[2]), ca.sin(x[2])
        return ca.vertcat(c, s, x[3] * p[2] + p[3], p[0] * s - p[1] * c)

    k_1 = field(x)
    k_2 = field(x + 0.5 * h * k_1)
    k_3 = field(x + 0.5 * h * k_2)
    k_4 = field(x + h * k_3)
    step = ca.Function("step", [x, p], [x + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)])
    rod = step.fold(steps)

    scaled, rho = ca.MX.sym("y", 8), ca.MX.sym("rho", 4)
    y = scaled * units

    def leg(q, motor, mu, k_b, r_c):
        base = ca.vertcat(motor + peer.BEFORE * np.cos(q), peer.BEFORE * np.sin(q), q, mu[2])
        tip = rod(base, ca.repmat(ca.vertcat(mu[0], mu[1], 1 / k_b, 1 / r_c), 1, steps))
        b = peer.AFTER * ca.vertcat(ca.cos(tip[2]), ca.sin(tip[2]))
        return tip[:2] + b, tip[3] - (b[0] * mu[1] - b[1] * mu[0])

    pivot_1, moment_1 = leg(nominal[0], -0.5 * peer.DISTANCE, y[2:5], rho[0], rho[1])
    pivot_2, moment_2 = leg(nominal[1], 0.5 * peer.DISTANCE, y[5:8], rho[2], rho[3])
    balance = peer.F_P - y[2:4] - y[5:7]
    residual = ca.vertcat(balance, moment_1, moment_2, y[:2] - pivot_1, y[:2] - pivot_2) / rows
    system = {"x": scaled, "p": rho, "g": residual}
    finder = ca.rootfinder("finder", "newton", system, {"abstol": 1e-9})
    mapped: dict[int, ca.Function] = {}

    def solve(samples: np.ndarray) -> np.ndarray:
        starts = nominal[2:] + (samples - peer.RHO) @ slope[2:].T
        many = mapped.setdefault(len(samples), finder.map(len(samples)))
        found = np.array(many(starts.T / units[:, None], samples.T))
        return (found * units[:, None])[:2].T

    return solve
