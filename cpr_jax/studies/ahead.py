"""The programs of a map, compiled side by side when they are first needed."""

import threading
from typing import Any

import jax
import numpy as np

from ..analysis.parameters import Selection
from ..analysis.singularity import compile_tracing
from ..programs import started
from ..robots.robot import Robot
from ..rods.solver import Scheme
from ..statics.advance import advance
from ..statics.problem import imposed_rows
from .cells import look_at_cells
from .creeping import LANES

_known: set[Any] = set()


def compile_ahead(
    robot: Robot,
    selection: Selection,
    delta: jax.Array,
    axes: tuple[int, int],
    places: tuple[int, ...],
    steps: int,
    coarse: Scheme,
    chunk: int,
) -> "Ahead":
    """Starts to compile what a map needs, in threads, while its seed is still being solved.

    Compilation leaves cores idle; done in turn it is most of a first map's time. The programs
    run once on NaN, on which every iteration stops at once. Later calls find all of it done.
    """
    leaves, structure = jax.tree.flatten(robot)
    shapes = tuple(np.shape(leaf) for leaf in leaves)
    key = (structure, shapes, selection, axes, places, steps, coarse)
    if key in _known:
        return Ahead()
    _known.add(key)
    imposed = imposed_rows(robot, places)
    rows = (LANES, robot.n_y), (LANES, robot.n_a + robot.n_p), (chunk, robot.n_y)
    lanes, goals, cells = (np.full(shape, np.nan) for shape in rows)

    def follow() -> None:
        advance(robot, imposed, axes, lanes, goals, np.asarray(coarse))

    def look() -> None:
        look_at_cells(robot, selection, delta, cells, places, steps)

    def lines() -> None:
        first.join()
        compile_tracing(robot, axes, places, steps)

    first = started(follow)
    return Ahead(follow=first, look=started(look), lines=started(lines))


class Ahead:
    """Programs on their way. As a context it waits for all of them in the end, come what may.

    A program that is called before it is ready would be compiled twice: `wait` for it.
    """

    def __init__(self, **threads: threading.Thread):
        self._threads = threads

    def wait(self, name: str) -> None:
        """Until the programs to `follow` the branch, `look` at cells or trace `lines` are there."""
        if name in self._threads:
            self._threads[name].join()

    def __enter__(self) -> "Ahead":
        return self

    def __exit__(self, *_: object) -> None:
        for thread in self._threads.values():
            thread.join()
