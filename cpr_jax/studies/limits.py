"""Limits of motors and rods."""

import dataclasses

import numpy as np

from ..checks import check_positive, check_shape
from ..errors import InputError
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

    def __post_init__(self) -> None:
        if self.motors is not None:
            check_shape("motors", self.motors, (2,))
            low, high = self.motors
            if not low < high:
                raise InputError(
                    "Argument `motors` must be a lowest and a highest position, but it is "
                    f"({low}, {high})."
                )
            object.__setattr__(self, "motors", (float(low), float(high)))
        for name in ("torque", "moment", "curvature"):
            if getattr(self, name) is not None:
                check_positive(name, getattr(self, name))
                # A map keeps its limits as JSON.
                object.__setattr__(self, name, float(getattr(self, name)))

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
