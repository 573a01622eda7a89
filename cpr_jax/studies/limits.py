"""Limits of motors and rods."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ..checks import check_positive
from ..errors import InputError, shown
from ..robots.robot import Robot
from .cells import Cell


@dataclasses.dataclass(frozen=True)
class Limits:
    """What the robot may be asked for; cells beyond are marked, and still have their numbers.

    **Attributes** (SI units; `None` for no limit):

    - `motors`: lowest and highest position, rad or m. Each is one number for all motors, or one
        for each of them (`-inf` and `inf` where a motor has no limit).
    - `torque`: largest motor torque, N·m (N where motors slide), of all motors or of each.
    - `moment`: largest internal moment of a rod, N·m.
    - `curvature`: largest curvature of a rod, 1/m.
    """

    motors: tuple[float | Sequence[float], float | Sequence[float]] | None = None
    torque: float | Sequence[float] | None = None
    moment: float | None = None
    curvature: float | None = None

    def __post_init__(self) -> None:
        # A map keeps its limits as JSON.
        if self.motors is not None:
            object.__setattr__(self, "motors", _interval(self.motors))
        for name in ("torque", "moment", "curvature"):
            value = getattr(self, name)
            if value is None:
                continue
            check_positive(name, value)
            of_each = np.ndim(value) == 1 and name == "torque"
            if np.ndim(value) and not of_each:
                expected = "one number, or one for each motor" if name == "torque" else "one number"
                raise InputError(f"Argument `{name}` must be {expected}, but it is {shown(value)}.")
            object.__setattr__(self, name, _plain(value))

    def check_fits(self, robot: Robot) -> None:
        """Refuses limits for each motor of another number of motors."""
        named: dict[str, Any] = {"torque": self.torque}
        if self.motors is not None:
            named |= {"motors[0]": self.motors[0], "motors[1]": self.motors[1]}
        for name, value in named.items():
            if np.ndim(value) and np.size(value) != robot.n_a:
                raise InputError(
                    f"Argument `limits.{name}` must have a number for each of the {robot.n_a} "
                    f"motors, but it has {np.size(value)}."
                )

    def of_motors(self, n_a: int) -> Float[np.ndarray, "3 n_a"]:
        """Lowest and highest position and largest torque of each motor, infinite for no limit."""
        low, high = (-np.inf, np.inf) if self.motors is None else self.motors
        most = np.inf if self.torque is None else self.torque
        return np.stack([np.broadcast_to(np.asarray(x, float), n_a) for x in (low, high, most)])

    def beyond(self, cells: Cell) -> Bool[np.ndarray, " cells"]:
        """Whether each cell is beyond some limit."""
        low, high, most = self.of_motors(cells.q_a.shape[1])
        out = np.any((cells.q_a < low) | (cells.q_a > high), axis=1)
        out |= np.any(np.abs(cells.motor_torques) > most, axis=1)
        if self.moment is not None:
            out |= np.asarray(cells.moment) > self.moment
        if self.curvature is not None:
            out |= np.asarray(cells.curvature) > self.curvature
        return out


def _interval(motors):
    """Lowest and highest positions, as floats or tuples of them."""
    try:
        low, high = (np.asarray(end, float) for end in motors)
        fits = low.ndim < 2 and high.ndim < 2 and bool(np.all(low < high))
    except (TypeError, ValueError):
        fits = False
    if not fits:
        raise InputError(
            "Argument `motors` must be a lowest and a highest position, each one number or one for "
            f"each motor, but it is {shown(motors)}."
        )
    return _plain(low), _plain(high)


def _plain(value):
    return float(value) if np.ndim(value) == 0 else tuple(map(float, value))
