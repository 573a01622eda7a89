"""Motor positions at which a robot is what it was before."""

import numpy as np
from jaxtyping import Float

from ..robots.robot import Robot
from .unknowns import scales, slides

_MOST = 64
"""Turns of the slowest leg within which several legs of one motor must come back together."""


def motor_periods(robot: Robot) -> Float[np.ndarray, " n_a"]:
    """How far each motor turns until all of its legs are where they were, rad.

    `2π` for a motor that turns its legs directly, more or less behind a gear. Infinite where legs
    never come back: where a motor slides or feeds, or turns legs at rates without a common
    multiple.
    """
    legs, d = robot.legs, robot.geometry.d
    screw = np.asarray(legs.screw)
    slides = np.any(screw[:, :d] != 0.0, axis=1)
    for way in (legs.stroke, legs.feed):
        if way is not None:
            slides |= np.any(np.asarray(way).reshape(robot.n, -1) != 0.0, axis=1)
    rates = np.abs(np.asarray(robot.transmission)) * np.linalg.norm(screw[:, d:], axis=1)[:, None]
    slides = np.any(slides[:, None] & (np.asarray(robot.transmission) != 0.0), axis=0)
    return np.array([np.inf if s else _period(of) for s, of in zip(slides, rates.T, strict=True)])


def _period(rates: Float[np.ndarray, " n"]) -> float:
    rates = rates[rates > 0.0]
    if len(rates) == 0:
        return np.inf
    slowest = 2.0 * np.pi / np.min(rates) * np.arange(1, _MOST + 1)
    turns = slowest[:, None] * rates / (2.0 * np.pi)
    back = np.all(np.abs(turns - np.round(turns)) < 1e-9, axis=1)
    return float(slowest[np.argmax(back)]) if np.any(back) else np.inf


def motor_spans(robot: Robot) -> Float[np.ndarray, " n_a"]:
    """How far to either side of zero motors are searched: half a period where there is one, else
    half a turn, or half a rod length where they slide; rad or m."""
    units, periods = np.asarray(scales(robot).motors(robot)), motor_periods(robot)
    return np.where(
        np.isfinite(periods), periods / 2.0, np.where(slides(robot), units / 2.0, np.pi)
    )
