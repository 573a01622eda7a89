"""The RFRFR robot as chains of rigid links and springs: energy, equilibrium, stability.

A rod becomes N links of length h that point along the mean of the angles at their ends, and the
potential energy `Σ k_b h / 2 ((θ_{j+1} - θ_j) / h - κ)² - f_P · p` is stationary under the
constraint that both legs end at the same point. Every result converges like h².
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg

from .planar_shooting import PlanarRobot, integrate


class Equilibrium(NamedTuple):
    """A stationary point of the discretised energy with the motors held.

    **Attributes:**

    - `energy`: elastic energy of the rods minus the work of the force on the platform, J.
    - `point`: end-effector, m.
    - `force`: `n_2(l_2)`, the force transmitted at the tip of leg 2, N.
    - `torques`: by the motors, the derivative of the energy in their angles, N·m.
    - `index`: negative directions of the energy among the motions that the joints allow.
    """

    energy: float
    point: np.ndarray
    force: np.ndarray
    torques: np.ndarray
    index: int


def angles_along(robot: PlanarRobot, y: np.ndarray, links: int) -> np.ndarray:
    """Angles at the `links + 1` nodes of both rods at the unknowns `y` of the shooting model."""
    rows = []
    for leg in range(2):
        s = np.linspace(0.0, robot.l[leg], links + 1)
        rows.append(integrate(robot, leg, y[leg], y[4 + 3 * leg : 7 + 3 * leg], t_eval=s).y[2])
    return np.array(rows)


def equilibrium(robot: PlanarRobot, angles: np.ndarray) -> Equilibrium:
    """Newton's method on the energy and its constraint, motors held at `angles[:, 0]`."""
    links = angles.shape[1] - 1
    angles = angles.copy()
    multiplier = np.zeros(2)
    for _ in range(30):
        energy, ends, slope, end_slopes, hessian = _expand(robot, angles, multiplier)
        free = np.ones(2 * (links + 1), bool)
        free[[0, links + 1]] = False
        constraint = np.hstack([end_slopes[0], -end_slopes[1]])
        rows = constraint[:, free]
        gradient = slope + multiplier @ constraint
        size = rows.shape[1]
        kkt = np.zeros((size + 2, size + 2))
        kkt[:size, :size] = hessian[np.ix_(free, free)]
        kkt[:size, size:], kkt[size:, :size] = rows.T, rows
        step = np.linalg.solve(kkt, -np.concatenate([gradient[free], ends[0] - ends[1]]))
        angles.reshape(-1)[free] += step[:size]
        multiplier = multiplier + step[size:]
        if np.max(np.abs(step)) < 1e-11:
            break
    else:
        raise RuntimeError("The discretised robot found no equilibrium.")
    tangents = scipy.linalg.null_space(rows)
    reduced = tangents.T @ kkt[:size, :size] @ tangents
    index = int(np.sum(np.linalg.eigvalsh(reduced) < 0.0))
    return Equilibrium(energy, ends[0], multiplier, gradient[~free], index)


def _expand(robot, angles, multiplier):
    """Energy, ends of the legs, their gradients, and the Hessian of the Lagrangian."""
    count = angles.shape[1]
    total, slopes, ends, end_slopes, hessians = 0.0, [], [], [], []
    for leg, theta in enumerate(angles):
        h = robot.l[leg] / (count - 1)
        mean = np.zeros((count - 1, count))
        difference = np.zeros((count - 1, count))
        rows = np.arange(count - 1)
        mean[rows, rows] = mean[rows, rows + 1] = 0.5
        difference[rows, rows], difference[rows, rows + 1] = -1.0 / h, 1.0 / h
        strain = difference @ theta - robot.curvature[leg]
        total += 0.5 * robot.k_b[leg] * h * strain @ strain
        # Rigid segments are links of their own: at the first and at the last angle.
        first, last = np.eye(count)[[0]], np.eye(count)[[-1]]
        maps = np.vstack([mean, first, last])
        lengths = np.array([h] * (count - 1) + [robot.a[leg], robot.b[leg]])
        c, s = np.cos(maps @ theta) * lengths, np.sin(maps @ theta) * lengths
        ends.append(np.array([(-0.5 if leg == 0 else 0.5) * robot.d + c.sum(), s.sum()]))
        jacobian = np.vstack([-s @ maps, c @ maps])
        end_slopes.append(jacobian)
        # The load on the platform hangs on leg 1.
        pull = (multiplier if leg == 0 else -multiplier) - (
            np.array(robot.f_P) if leg == 0 else 0.0
        )
        slopes.append(
            robot.k_b[leg] * h * difference.T @ strain
            - (np.array(robot.f_P) @ jacobian if leg == 0 else 0.0)
        )
        second = maps.T @ ((-pull[0] * c - pull[1] * s)[:, None] * maps)
        hessians.append(robot.k_b[leg] * h * difference.T @ difference + second)
    total -= np.array(robot.f_P) @ ends[0]
    hessian = scipy.linalg.block_diag(*hessians)
    return total, ends, np.concatenate(slopes), end_slopes, hessian
