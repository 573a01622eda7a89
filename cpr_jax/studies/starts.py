"""Where the search for all equilibria of a robot starts."""

import numpy as np
from scipy.stats import qmc

from ..robots.robot import Robot
from ..statics.periods import motor_periods, motor_spans

_FORCES = (10.0, 10.0, 20.0)
"""Largest base forces of the starts, in units of `k_b / l²`: a clamped rod buckles at 20."""

_MOMENTS = 0.4
"""Their base moments in units of force times length, for a force of one."""

_MIXED = 1536
"""How many new starts are made at once from the legs of what was found."""


def even_starts(robot: Robot, target, places, units, count: int, seed: int) -> np.ndarray:
    """Starting unknowns in SI units."""
    cube = qmc.Sobol(units.size, rng=seed).random(2 ** int(np.ceil(np.log2(count))))[:count]
    spread = 2.0 * cube - 1.0
    n_a, d = robot.n_a, robot.geometry.d
    n_q = n_a + robot.n_p
    spread[:, :n_a] *= motor_spans(robot) / units[:n_a]
    spread[:, n_a + d : n_q] *= np.pi
    wrenches = spread[:, n_q:].reshape(count, robot.n, -1)
    wrenches *= np.array(_FORCES)[np.arange(count) % len(_FORCES), None, None]
    wrenches[..., d:] *= _MOMENTS
    # The last leg carries what the others leave of the load.
    load = np.asarray(robot.f_P) / units[n_q : n_q + d]
    wrenches[:, -1, :d] = load - np.sum(wrenches[:, :-1, :d], axis=1)
    spread[:, n_q:] = wrenches.reshape(count, -1)
    middle = np.zeros(units.size)
    middle[n_a : n_a + d] = np.mean(np.asarray(robot.legs.base_position), axis=0)
    y = middle + units * spread
    held = [place for place in places if place >= n_a]
    y[:, held] = target[held]
    return y


def recombined(robot: Robot, y, units, seed: tuple[int, int]) -> np.ndarray:
    """Starts with the legs of different solutions, their wrenches grown: towards higher modes.

    Solutions with strongly buckled rods attract few of the even starts.
    """
    rng = np.random.default_rng(seed)
    size = robot.geometry.freedoms
    rows = rng.integers(len(y), size=(_MIXED, robot.n))
    mixed = y[rows[:, 0]].copy()
    n_q = robot.n_a + robot.n_p
    for leg in range(robot.n):
        moves = np.asarray(robot.transmission)[leg] != 0.0
        mixed[:, : robot.n_a] = np.where(moves, y[rows[:, leg], : robot.n_a], mixed[:, : robot.n_a])
        part = slice(n_q + leg * size, n_q + (leg + 1) * size)
        mixed[:, part] = y[rows[:, leg], part]
    wrenches = mixed[:, n_q:].reshape(_MIXED, robot.n, size)
    wrenches = wrenches * rng.uniform(0.5, 5.0, (_MIXED, 1, 1))
    mixed[:, n_q:] = wrenches.reshape(_MIXED, -1)
    periods = motor_periods(robot)
    aside = np.where(np.isfinite(periods), periods / (4.0 * np.pi), 0.5 * units[: robot.n_a])
    mixed[:, : robot.n_a] += rng.normal(size=(_MIXED, robot.n_a)) * aside
    mixed[:, n_q:] += rng.normal(size=(_MIXED, robot.n * size)) * units[n_q:]
    return mixed
