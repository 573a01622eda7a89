"""The programs of a map, compiled side by side when they are first needed."""

import threading
from typing import Any

import jax
import numpy as np

from ..analysis.parameters import Selection
from ..analysis.singularity import compile_tracing
from ..programs import started
from .cells import look_at_cells
from .follower import Follower

_known: set[Any] = set()


def compile_ahead(
    follower: Follower,
    selection: Selection,
    delta: jax.Array,
    places: tuple[int, ...],
    steps: int,
    chunk: int,
) -> "Ahead":
    """Starts to compile what a map needs, in threads, while its seed is still being solved.

    Compilation leaves cores idle; done in turn it is most of a first map's time. The programs
    run once on NaN, on which every iteration stops at once. Later calls find all of it done.
    """
    robot, _, axes, _, many = follower
    leaves, structure = jax.tree.flatten(robot)
    shapes = tuple(np.shape(leaf) for leaf in leaves)
    key = (structure, shapes, selection, axes, places, steps, many, chunk)
    if key in _known:
        return Ahead()
    _known.add(key)
    cells = np.full((chunk, robot.n_y), np.nan)

    def look() -> None:
        look_at_cells(robot, selection, delta, cells, places, steps)

    def lines() -> None:
        first.join()
        compile_tracing(robot, axes, places, steps)

    first = started(follower.compile)
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
