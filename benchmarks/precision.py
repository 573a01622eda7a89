"""Work against precision: time per sample at several accuracies, each by its own setting."""

import functools

from .monte_carlo import MANY
from .peers import Reached, field
from .result import Result, Table
from .timing import take_turns

ACCURACIES = (1e-6, 1e-8, 1e-10)
"""Largest errors of a platform coordinate, m."""

ROUNDS = 3


def run(quick: bool) -> Result:
    """Every program at every accuracy it reaches, by turns."""
    everyone = field(MANY // 5 if quick else MANY)
    reached: dict[str, tuple[str, float, Reached]] = {}
    for name, ladder in everyone.ladders.items():
        for accuracy in ACCURACIES:
            found = ladder.reach(accuracy)
            if found is not None:
                reached[f"{name} at {accuracy}"] = (name, accuracy, found)
    timings = take_turns(
        {
            key: functools.partial(found.contender.solve, everyone.rho[: found.contender.samples])
            for key, (_, _, found) in reached.items()
        },
        1 if quick else ROUNDS,
    )
    rows: list[list] = []
    curves: dict[str, list[tuple[float, float]]] = {}
    for key, (name, accuracy, found) in reached.items():
        wall = timings[key].wall / found.contender.samples
        rows.append([found.contender.name, accuracy, found.error, wall])
        curves.setdefault(name, []).append((found.error, wall))
    columns = [
        ("program and setting", "text"),
        ("accuracy", "error"),
        ("error", "error"),
        ("per sample", "time"),
    ]
    table = Table("The fastest setting of each program at three accuracies", columns, rows)
    return Result([table], [], {"precision": curves}, list(everyone.missing))
