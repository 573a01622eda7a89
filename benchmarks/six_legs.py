"""Solves per second of a six-leg robot on one core, along many paths of its platform.

The lengths of the legs of the continuum Stewart–Gough robot, whose platform starts where the
speed test of Till's examples does and goes as far with each pose, straight in many directions of
the same plane. C++ takes path after path, cpr_jax all of them abreast.
"""

import itertools
import time
from collections.abc import Callable, Iterable
from typing import Any

import jax
import numpy as np

import cpr_jax as cpr
from cpr_jax.statics.accuracy import MENU
from cpr_jax.statics.advance import advance_many
from cpr_jax.statics.problem import inverse_rows
from cpr_jax.statics.unknowns import unknown_scales

from . import six_peer
from .building import compiler
from .child import measured_apart
from .peers import in_words
from .result import Result, Table, at_least
from .timing import FirstCall, first_call, take_turns

ACCURACY = 1e-6
"""Largest error of a length that counts as accurate, m."""

REFERENCE = cpr.Scheme(20)
"""What cpr_jax integrates with for the solutions that all errors are measured against."""

_START = (0.0, 0.02, 0.48)
_POSE = 1e-3 * np.sqrt(2.0)
_PATHS, _POSES = 512, 20
_PUBLISHED = (40, 1e-6, 1e-4)
"""Steps, tolerance on the sum of squares and damping at first of Till's examples."""


def run(quick: bool) -> Result:
    """Each program at its fastest accurate setting."""
    if compiler() is None:
        return Result([], [], {}, ["The six-leg peer is left out: there is no C++ compiler."])
    found = measured_apart("six_legs", "measure", {"rounds": 1 if quick else 3}, cores=1)
    rows = [[name, *row] for name, row in found["rows"].items()]
    columns = [
        ("program and setting", "text"),
        ("compilation", "time"),
        ("per solve", "time"),
        ("solves per second", "rate"),
        ("error of a length", "error"),
    ]
    title = (
        f"Six legs on one core, {found['paths']} paths of {found['poses']} poses, errors of at "
        f"most {ACCURACY:.0e} m but for the first row"
    )
    rate = {name: row[2] for name, row in found["rows"].items()}
    own = next(value for name, value in rate.items() if name.startswith("cpr_jax"))
    verdicts = [
        at_least(f"six legs: solves per second beside {name}, ratio", own / rate[setting], 1.0)
        for name, setting in found["peers"].items()
    ]
    series = {"six legs": {name: [(0.0, row[1])] for name, row in found["rows"].items()}}
    return Result([Table(title, columns, rows)], verdicts, series, [])


def measure(rounds: int) -> dict[str, Any]:
    """Rows by program: compilation, s, a solve, s, solves a second, error, m."""
    robot = cpr.stewart_gough()
    start = cpr.solve_inverse(robot, (*_START, 0.0, 0.0, 0.0))
    q_a, mu, q_p = (np.asarray(part) for part in (start.q_a, start.mu, start.q_p))
    problem = six_peer.Problem(q_a, mu, q_p, _poses())
    begin = time.perf_counter()
    printed, lean = six_peer.make(robot, problem)
    building = time.perf_counter() - begin

    scheme, call, error, exact = _own_setting(robot, problem)
    menu = itertools.product((14, 16, 20, 28), 10.0 ** -np.arange(9.0, 14.0), (1e-4, 1e-8))
    best = _fastest(printed, menu, exact)
    spared = _fastest(lean, itertools.product((12, 14, 16, 20, 28), (1, 2)), exact)

    def name(setting: tuple) -> str:
        return "C++, the published algorithm: {} steps, {:.0e}, damping {:.0e}".format(*setting)

    programs: dict[str, Callable[[], np.ndarray]] = {
        name(_PUBLISHED): lambda: printed(*_PUBLISHED),
        f"cpr_jax, {in_words(scheme)}, {_PATHS} paths abreast": (
            lambda: _along(robot, problem, scheme)
        ),
        name(best): lambda: printed(*best),
        f"C++, lean: {spared[0]} steps, Newton steps a pose: {spared[1]}": lambda: lean(*spared),
    }
    as_published, own, accurate, leanest = programs
    errors = {key: _error(programs[key](), exact) for key in (as_published, accurate, leanest)}
    errors[own] = error
    timings = take_turns(programs, rounds)
    rows = {}
    for key in programs:
        seconds = timings[key].wall / (_PATHS * _POSES)
        compilation = call.compile if key == own else building
        rows[key] = [compilation, seconds, 1.0 / seconds, errors[key]]
    peers = {"the published algorithm in C++": accurate, "lean C++": leanest}
    return {"rows": rows, "peers": peers, "paths": _PATHS, "poses": _POSES}


def _poses() -> np.ndarray:
    turns = np.linspace(0.0, 2.0 * np.pi, _PATHS, endpoint=False)
    way = np.stack([0.0 * turns, np.cos(turns), np.sin(turns)], axis=-1)
    along = _POSE * np.arange(1.0, _POSES + 1.0)
    places = np.asarray(_START) + along[:, None] * way[:, None, :]
    return np.concatenate([places, np.zeros_like(places)], axis=-1)


def _along(robot: cpr.Robot, problem: six_peer.Problem, scheme: cpr.Scheme) -> np.ndarray:
    """Lengths of the legs, m, by `advance`, each pose predicted by slopes at the two before."""
    units = np.asarray(unknown_scales(robot))
    start = np.concatenate([problem.q_a, problem.q_p, problem.mu.ravel()])
    y = np.tile(start / units, (_PATHS, 1))
    lengths = np.empty((_PATHS, _POSES, 6))
    before = np.broadcast_to(problem.q_p, (_PATHS, 6))
    slope = earlier = np.asarray(_advanced(robot, y, before, scheme).slope)
    for k in range(_POSES):
        pose = problem.poses[:, k]
        # The poses are equally far apart: to second order the slope goes on as it came.
        ahead = slope + 0.5 * (slope - earlier)
        guess = y + np.einsum("lny,ly->ln", ahead, (pose - before)[:, 1:3])
        found = _advanced(robot, guess, pose, scheme)
        y, earlier, slope, before = np.asarray(found.y), slope, np.asarray(found.slope), pose
        if np.any(np.asarray(found.status) != cpr.Status.SOLVED):
            raise RuntimeError("A pose is not solved.")
        lengths[:, k] = y[:, :6] * units[:6] + np.asarray(robot.legs.rod.length)
    return lengths


def _advanced(robot, guess, pose, scheme):
    goal = np.concatenate([np.zeros_like(pose), pose], axis=1)
    axes = (robot.n_a + 1, robot.n_a + 2)
    rows, numbers = inverse_rows(robot), np.asarray(scheme)
    return jax.block_until_ready(advance_many(robot, rows, axes, guess, goal, numbers))


def _own_setting(robot, problem) -> tuple[cpr.Scheme, FirstCall, float, np.ndarray]:
    """The scheme of least work that is accurate, its error, m, the first call and the reference."""
    found: list[np.ndarray] = []
    call = first_call(lambda: found.append(_along(robot, problem, REFERENCE)))
    (exact,) = found
    for scheme in MENU:
        error = _error(_along(robot, problem, scheme), exact)
        if error <= ACCURACY:
            return scheme, call, error, exact
    raise RuntimeError("No scheme is accurate enough.")


def _error(lengths: np.ndarray, exact: np.ndarray) -> float:
    return float(np.max(np.abs(lengths - exact)))


def _fastest(solve: Callable, settings: Iterable[tuple], exact: np.ndarray) -> tuple:
    """The setting that takes the least time of those that are accurate."""
    taken = {}
    for setting in settings:
        begin = time.perf_counter()
        lengths = solve(*setting)
        seconds = time.perf_counter() - begin
        if _error(lengths, exact) <= ACCURACY:
            taken[setting] = seconds
    return min(taken, key=lambda setting: taken[setting])
