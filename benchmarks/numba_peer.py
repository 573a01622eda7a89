"""The paper's robot with numba: RK4 with tangents by hand, Newton's method, sample by sample."""

from collections.abc import Callable

import numpy as np

from . import scipy_peer


def make(nominal: np.ndarray, slope: np.ndarray) -> Callable[[np.ndarray, int, int], np.ndarray]:
    """Returns `solve(rho, steps, iterations)` for `p_P`, m."""
    import numba

    peer = scipy_peer
    length, before, after, distance = peer.LENGTH, peer.BEFORE, peer.AFTER, peer.DISTANCE
    f_y, f_z = float(peer.F_P[0]), float(peer.F_P[1])
    centre = peer.RHO
    q, start, tangent = nominal[:2].copy(), nominal[[4, 5, 6, 9]], slope[[4, 5, 6, 9]]

    @numba.njit(fastmath=True)
    def rates(x, compliance, rest, n_y, n_z, m_0, out):
        y, z, c, s = x[0], x[1], x[2], x[3]
        u = compliance * (m_0 - (y * n_z - z * n_y)) + rest
        out[0], out[1], out[2], out[3] = c, s, -s * u, c * u
        for k in range(3):
            dy, dz, turn = x[4 + k], x[7 + k], x[10 + k]
            dm = -(dy * n_z - dz * n_y) + (z if k == 0 else (-y if k == 1 else 1.0))
            out[4 + k], out[7 + k], out[10 + k] = -s * turn, c * turn, compliance * dm

    @numba.njit(fastmath=True)
    def leg(motor, q, compliance, rest, n_y, n_z, m_0, steps, work, out):
        # `out`: pivot, moment, then their tangents in (n_y, n_z, m), row by row.
        x, k_1, k_2, k_3, k_4, stage = work
        c_0, s_0, h = np.cos(q), np.sin(q), length / steps
        x[:] = 0.0
        x[2], x[3] = c_0, s_0
        for _ in range(steps):
            rates(x, compliance, rest, n_y, n_z, m_0, k_1)
            for i in range(13):
                stage[i] = x[i] + 0.5 * h * k_1[i]
            rates(stage, compliance, rest, n_y, n_z, m_0, k_2)
            for i in range(13):
                stage[i] = x[i] + 0.5 * h * k_2[i]
            rates(stage, compliance, rest, n_y, n_z, m_0, k_3)
            for i in range(13):
                stage[i] = x[i] + h * k_3[i]
            rates(stage, compliance, rest, n_y, n_z, m_0, k_4)
            for i in range(13):
                x[i] += h / 6.0 * (k_1[i] + 2.0 * (k_2[i] + k_3[i]) + k_4[i])
        y, z = x[0] + after * x[2], x[1] + after * x[3]
        out[0] = motor + before * c_0 + y
        out[1] = before * s_0 + z
        out[2] = m_0 - (y * n_z - z * n_y)
        for k in range(3):
            dy = x[4 + k] - after * x[3] * x[10 + k]
            dz = x[7 + k] + after * x[2] * x[10 + k]
            out[3 + k], out[6 + k] = dy, dz
            out[9 + k] = -(dy * n_z - dz * n_y) + (z if k == 0 else (-y if k == 1 else 1.0))

    @numba.njit(fastmath=True)
    def solve(rho, steps, iterations):
        ends = np.empty((len(rho), 2))
        work, one, two = np.empty((6, 13)), np.empty(12), np.empty(12)
        system, right = np.empty((4, 4)), np.empty(4)
        for sample in range(len(rho)):
            p = rho[sample]
            x = start + tangent @ (p - centre)
            for _ in range(iterations):
                leg(-0.5 * distance, q[0], 1 / p[0], 1 / p[1], x[0], x[1], x[2], steps, work, one)
                n_y, n_z = f_y - x[0], f_z - x[1]
                leg(0.5 * distance, q[1], 1 / p[2], 1 / p[3], n_y, n_z, x[3], steps, work, two)
                for i in range(2):
                    row = 3 + 3 * i
                    system[i, 0], system[i, 1] = one[row] + two[row], one[row + 1] + two[row + 1]
                    system[i, 2], system[i, 3] = one[row + 2], -two[row + 2]
                    right[i] = two[i] - one[i]
                system[2:] = 0.0
                for k in range(2):
                    system[2, k], system[3, k] = one[9 + k], -two[9 + k]
                system[2, 2], system[3, 3] = one[11], two[11]
                right[2], right[3] = -one[2], -two[2]
                change = np.linalg.solve(system, right)
                x += change
            for i in range(2):
                row = 3 + 3 * i
                ends[sample, i] = one[i]
                for k in range(3):
                    ends[sample, i] += one[row + k] * change[k]
        return ends

    return lambda rho, steps, iterations: solve(np.ascontiguousarray(rho), steps, iterations)
