"""Workspace maps of the paper's robot, sensitivities and all: time and peak memory."""

import pathlib
import re
import time
from typing import Any

import numpy as np

import cpr_jax as cpr

from .child import available_cores, measured_apart
from .result import Result, Table, at_most
from .timing import CompileClock

REQUIRED = 60.0
"""Time for a million cells, s."""

_HALF = 0.108
"""Half of the workspace, all within reach, m²."""


def run(quick: bool) -> Result:
    """Maps of 10,000 cells, first and warm, and of a million."""
    cells = [10_000, 10_000] + ([] if quick else [1_000_000])
    cores = len(available_cores())
    rows = measured_apart("maps", "measure", {"cells": cells}, cores=cores)
    columns = [
        ("map", "text"),
        ("cells within reach", "count"),
        ("solved", "count"),
        ("compilation", "time"),
        ("whole call", "time"),
        ("per cell", "time"),
        ("peak memory", "memory"),
    ]
    names = ["first call", "warm", "warm"]
    table = Table(
        "Half of the workspace with Π, singularities, stability and torques of every cell",
        columns,
        [[name, *row] for name, row in zip(names, rows, strict=False)],
    )
    verdicts = []
    if not quick:
        verdicts.append(at_most("1,000,000 map cells with Π, s", rows[-1][3], REQUIRED))
    return Result([table], verdicts, {}, [])


def measure(cells: list[int]) -> list[list[Any]]:
    """Maps of about so many cells, one after the other.

    **Returns:** cells within reach, solved cells, tracing and compilation, s, the whole call, s,
    time a cell, s, and the peak memory of the process until then, MB.
    """
    robot = cpr.rfrfr()
    rows = []
    for wanted in cells:
        begin = time.perf_counter()
        with CompileClock() as clock:
            dataset = cpr.workspace_map(robot, spacing=float(np.sqrt(_HALF / wanted)))
        seconds = time.perf_counter() - begin
        within = int(np.sum(dataset["status"].values != cpr.Status.OUT_OF_REACH))
        solved = int(np.sum(dataset["index"].values >= 0))
        rows.append([within, solved, clock.seconds, seconds, seconds / within, _peak_memory()])
    return rows


def _peak_memory() -> float | None:
    """Of this process until now, MB, where the system tells it."""
    status = pathlib.Path("/proc/self/status")
    if not status.exists():
        return None
    # Not `getrusage`, which counts what the process was forked from.
    found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
    return int(found[1]) / 1024.0 if found else None
