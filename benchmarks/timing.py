"""Clocks: compilation apart from running, and repeats that take turns."""

import contextlib
import importlib.metadata
import os
import pathlib
import platform
import re
import statistics
import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax

from cpr_jax.programs import forget_all
from cpr_jax.studies.versions import versions

from .child import available_cores

_TURN = 0.1
"""How long a turn is filled with calls of a quick function, s."""


class Timing(NamedTuple):
    """Medians of repeated calls, s.

    **Attributes:**

    - `wall`: by the clock on the wall.
    - `cpu`: of all threads of the process.
    """

    wall: float
    cpu: float


class CompileClock:
    """Time that JAX spends on tracing, lowering and compiling in a `with` block.

    JAX reports each of these when it ends, and they nest: what counts is the union of their
    intervals.
    """

    def __enter__(self) -> "CompileClock":
        self.seconds = 0.0
        self._intervals: list[tuple[float, float]] = []
        jax.monitoring.register_event_duration_secs_listener(self._listen)
        return self

    def __exit__(self, *_) -> None:
        jax.monitoring.unregister_event_duration_listener(self._listen)
        covered = float("-inf")
        for start, end in sorted(self._intervals):
            self.seconds += max(0.0, end - max(start, covered))
            covered = max(covered, end)

    def _listen(self, event: str, duration: float, **_) -> None:
        if event.startswith("/jax/core/compile/"):
            now = time.perf_counter()
            self._intervals.append((now - duration, now))


class FirstCall(NamedTuple):
    """A call that compiles.

    **Attributes:**

    - `compile`: tracing and compilation, s.
    - `total`: the whole call, s.
    """

    compile: float
    total: float


def first_call(function: Callable[[], object]) -> FirstCall:
    """Calls a function with nothing compiled before, in memory or on disk."""
    jax.config.update("jax_enable_compilation_cache", False)
    forget_all()
    jax.clear_caches()
    start = time.perf_counter()
    with CompileClock() as clock:
        jax.block_until_ready(function())
    return FirstCall(clock.seconds, time.perf_counter() - start)


def take_turns(functions: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, Timing]:
    """Times functions A B C A B C …, so that what else the machine does hits all of them.

    A quick function is called several times in its turn: right after another program, which has
    filled the caches and put threads to sleep, no call is a warm one.
    """
    taken: dict[str, list[Timing]] = {name: [] for name in functions}
    for _ in range(rounds):
        for name, function in functions.items():
            taken[name].append(_turn(function))
    return {name: _medians(turns) for name, turns in taken.items()}


def _turn(function: Callable[[], object]) -> Timing:
    calls: list[Timing] = []
    begin = time.perf_counter()
    while not calls or time.perf_counter() - begin < _TURN:
        wall, cpu = time.perf_counter(), time.process_time()
        jax.block_until_ready(function())
        calls.append(Timing(time.perf_counter() - wall, time.process_time() - cpu))
    return _medians(calls)


def _medians(timings: list[Timing]) -> Timing:
    return Timing(*(statistics.median(values) for values in zip(*timings, strict=True)))


def load() -> list[float]:
    """Load average over 1, 5 and 15 minutes."""
    return [round(value, 2) for value in os.getloadavg()] if hasattr(os, "getloadavg") else []


def environment() -> dict[str, object]:
    """Where a run takes place: cores, processor, versions."""
    found = {"python": platform.python_version(), **versions()}
    for name in ("scipy", "numba", "casadi"):
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return {"cores": len(available_cores()), "processor": _processor(), "versions": found}


def _processor() -> str:
    info = pathlib.Path("/proc/cpuinfo")
    names = re.findall(r"model name\s*: (.*)", info.read_text()) if info.exists() else []
    return names[0] if names else platform.machine()
