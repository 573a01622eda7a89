"""The paper's robot in C++ by hand, compiled for this machine: see `native.cpp`."""

import ctypes
import pathlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable

import numpy as np
from scipy.integrate._ivp import dop853_coefficients

from . import scipy_peer

_SOURCE = pathlib.Path(__file__).with_name("native.cpp")
_FLAGS = ("-O3", "-march=native", "-fopenmp-simd", "-ffast-math", "-std=c++17", "-shared", "-fPIC")
_STATES = [4, 5, 6, 9]
"""Of y: n_1, m_1 and m_2."""

Solve = Callable[[np.ndarray, int, int, int], np.ndarray]


def compiler() -> str | None:
    """A C++ compiler, if there is one."""
    return shutil.which("g++") or shutil.which("clang++")


def make(nominal: np.ndarray, slope: np.ndarray) -> Solve:
    """Compiles the program; returns `solve(rho, steps, iterations, threads)` for `p_P`, m.

    **Arguments:**

    - `nominal`, `slope`: the nominal `y` and `∂y/∂ρ`, from which samples are predicted.
    """
    path = compiler()
    assert path is not None
    with tempfile.TemporaryDirectory() as folder:
        _write_tableau(pathlib.Path(folder) / "tableau.h")
        library = pathlib.Path(folder) / "native.so"
        command = [path, *_FLAGS, f"-I{folder}", str(_SOURCE), "-o", str(library), "-lpthread"]
        subprocess.run(command, check=True)
        native = ctypes.CDLL(str(library))
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


def _write_tableau(path: pathlib.Path) -> None:
    def braces(row: np.ndarray) -> str:
        return "{" + ", ".join(f"{value:.17g}" for value in row) + "}"

    rows = ", ".join(braces(row) for row in dop853_coefficients.A[:12, :12])
    weights = braces(dop853_coefficients.B)
    path.write_text(
        f"constexpr double A[12][12] = {{{rows}}};\nconstexpr double B[12] = {weights};\n"
    )
