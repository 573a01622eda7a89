"""Limits of motors and rods."""

import dataclasses

import numpy as np

from .cells import Cell


@dataclasses.dataclass(frozen=True)
class Limits:
    """What the robot may be asked for; cells beyond are marked, and still have their numbers.

    **Attributes** (SI units; `None` for no limit):

    - `motors`: lowest and highest position, of all motors alike, rad or m.
    - `torque`: largest motor torque, N·m (N where motors slide).
    - `moment`: largest internal moment of a rod, N·m.
    - `curvature`: largest curvature of a rod, 1/m.
    """

    motors: tuple[float, float] | None = None
    torque: float | None = None
    moment: float | None = None
    curvature: float | None = None

    def beyond(self, cells: Cell) -> np.ndarray:
        """Whether each cell is beyond some limit."""
        out = np.zeros(len(cells.energy), bool)
        if self.motors is not None:
            low, high = self.motors
            out |= np.any((cells.q_a < low) | (cells.q_a > high), axis=1)
        if self.torque is not None:
            out |= np.any(np.abs(cells.motor_torques) > self.torque, axis=1)
        if self.moment is not None:
            out |= np.asarray(cells.moment) > self.moment
        if self.curvature is not None:
            out |= np.asarray(cells.curvature) > self.curvature
        return out
