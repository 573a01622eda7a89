"""The paper's robot in C++ by hand: see `native/paper.cpp`."""

import ctypes
from collections.abc import Callable

import numpy as np
from scipy.integrate._ivp import dop853_coefficients

from . import scipy_peer
from .building import built

_STATES = [4, 5, 6, 9]
"""Of y: n_1, m_1 and m_2."""

Solve = Callable[[np.ndarray, int, int, int], np.ndarray]


def make(nominal: np.ndarray, slope: np.ndarray) -> Solve:
    """Compiles the program; returns `solve(rho, steps, iterations, threads)` for `p_P`, m.

    **Arguments:**

    - `nominal`, `slope`: the nominal `y` and `∂y/∂ρ`, from which samples are predicted.
    """
    native = built("paper.cpp", {"tableau.h": _tableau()})
    peer = scipy_peer
    robot = np.array([peer.LENGTH, peer.BEFORE, peer.AFTER, peer.DISTANCE, *peer.F_P])
    shared = [
        np.ascontiguousarray(part, float)
        for part in (robot, nominal[:2], nominal[_STATES], slope[_STATES], peer.RHO)
    ]

    def solve(rho: np.ndarray, steps: int, iterations: int, threads: int) -> np.ndarray:
        rho = np.ascontiguousarray(rho, float)
        ends = np.empty((len(rho), 2))
        arrays = (a.ctypes.data_as(ctypes.c_void_p) for a in (*shared, rho, ends))
        native.solve(*arrays, ctypes.c_long(len(rho)), steps, iterations, threads)
        return ends

    return solve


def _tableau() -> str:
    def braces(row: np.ndarray) -> str:
        return "{" + ", ".join(f"{value:.17g}" for value in row) + "}"

    rows = ", ".join(braces(row) for row in dop853_coefficients.A[:12, :12])
    weights = braces(dop853_coefficients.B)
    return f"constexpr double A[12][12] = {{{rows}}};\nconstexpr double B[12] = {weights};\n"
