"""A Cosserat rod in space with rotation matrices, integrated by scipy.

The state is `(p, R, n, m)` in the axes of the base, with the strains and curvatures of linear
elasticity. A planar rod is the one whose forces have no third component and whose moments have
only that.
"""

import dataclasses

import numpy as np
from scipy.integrate import solve_ivp


@dataclasses.dataclass(frozen=True)
class SpatialRod:
    """The numbers of a rod, SI units, three components in each array.

    **Attributes:**

    - `bend`, `stretch`: compliances in local axes, the tangent first.
    - `rest`: curvature at rest.
    - `load`, `couple`: distributed dead force and moment.
    """

    length: float
    bend: np.ndarray
    rest: np.ndarray
    stretch: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))
    load: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))
    couple: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))


def skew(v: np.ndarray) -> np.ndarray:
    """The matrix of `v ×`."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def integrate(rod: SpatialRod, force: np.ndarray, moment: np.ndarray, s=None, rtol=1e-13):
    """Positions, matrices, forces, moments, elastic energy and `∫ p ds` at arc lengths `s`."""

    def field(_, x):
        p, R, n, m = x[:3], x[3:12].reshape(3, 3), x[12:15], x[15:18]
        local_n, local_m = R.T @ n, R.T @ m
        direction = R @ (np.array([1.0, 0.0, 0.0]) + rod.stretch * local_n)
        turn = R @ skew(rod.bend * local_m + rod.rest)
        energy = 0.5 * (local_m @ (rod.bend * local_m) + local_n @ (rod.stretch * local_n))
        lever = -np.cross(direction, n) - rod.couple
        return np.concatenate([direction, turn.ravel(), -rod.load, lever, [energy], p])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel(), force, moment, np.zeros(4)])
    x = solve_ivp(
        field,
        (0.0, rod.length),
        start,
        method="DOP853",
        rtol=rtol,
        atol=rtol,
        t_eval=[rod.length] if s is None else s,
    ).y.T
    return x[:, :3], x[:, 3:12].reshape(-1, 3, 3), x[:, 12:15], x[:, 15:18], x[:, 18], x[:, 19:]


def integrate_segments(rods, force: np.ndarray, moment: np.ndarray, rtol=1e-13):
    """Ends of rods that are joined one after the other, in the axes of the first base.

    **Returns:** of each rod the position, matrix, force, moment at its end, its elastic energy and
    its `∫ p ds`.
    """
    place, turn, ends = np.zeros(3), np.eye(3), []
    for rod in rods:
        local = dataclasses.replace(rod, load=turn.T @ rod.load, couple=turn.T @ rod.couple)
        p, R, n, m, energy, mean = (
            part[-1] for part in integrate(local, turn.T @ force, turn.T @ moment, rtol=rtol)
        )
        mean = place * rod.length + turn @ mean
        place, force, moment, turn = place + turn @ p, turn @ n, turn @ m, turn @ R
        ends.append((place, turn, force, moment, energy, mean))
    return [np.array(part) for part in zip(*ends, strict=True)]
