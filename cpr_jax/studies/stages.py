"""The stages of a map: its cells are found, then looked at."""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float
from tqdm import tqdm

from ..analysis.parameters import Selection
from ..parallel import in_parallel, on_devices, padded
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.unknowns import unknown_scales
from .ahead import Ahead
from .cells import Cell, look_at_cells, polished
from .follower import Follower
from .front import Front
from .grid import Grid
from .limits import Limits
from .parts import Parts
from .seam import seam_of

_SAVE_EVERY = 2.0
"""Seconds between two states of the front that are kept."""


class Job(NamedTuple):
    """What a map is made of."""

    robot: Robot
    seed: Equilibrium
    grid: Grid
    imposed: tuple[int, ...]
    selection: Selection
    delta: Float[Array, " n_rho"]
    limits: Limits | None
    steps: int
    refine: int
    parts: Parts
    follower: Follower
    ahead: Ahead
    chunk: int

    def stride(self, level: int) -> int:
        """Of the lattice that is solved on a level of refinement."""
        return 2 ** (self.refine - level)


def follow(job: Job, front: Front, bar: tqdm, level: int) -> None:
    """Spreads the front on the lattice of a level, or takes up what is known of it."""
    name, parts = f"front-{level}", job.parts
    known = parts.load(name)
    if known is not None:
        front.restore(known)
    saved = time.monotonic()

    def report(solved: int) -> None:
        # Half of the work is to find the cells, half to look at them.
        bar.update(solved // 2 - bar.n)

    def keep() -> None:
        nonlocal saved
        if time.monotonic() - saved > _SAVE_EVERY:
            parts.save(name, front.state())
            saved = time.monotonic()

    front.spread(report, keep, job.stride(level))
    parts.save(name, front.state())


def cells_and_seam(
    job: Job, front: Front, new: Bool[np.ndarray, "n_0 n_1"], bar: tqdm, level: int
) -> tuple[Cell | None, Bool[np.ndarray, "n_0 n_1"]]:
    """The numbers of the cells that are new, if any, and the seam among all that are solved."""

    def look() -> Cell | None:
        y = front.y[new] * np.asarray(unknown_scales(job.robot))
        return _looked_at(job, y, bar, level) if len(y) else None

    def join() -> Bool[np.ndarray, "n_0 n_1"]:
        return seam_of(front, job.stride(level))

    # Side by side: the seam by itself leaves cores idle.
    works: list[Callable[[], Any]] = [look, join]
    cells, seam = in_parallel(lambda work: work(), works)
    return cells, seam


def _looked_at(job: Job, y, bar: tqdm, level: int) -> Cell:
    """The numbers of all cells, chunk by chunk; what is not solved well enough is polished."""
    robot, parts = job.robot, job.parts

    places = on_devices((robot, job.delta))

    def look(name: str, y, turn: int) -> Cell:
        known = parts.load(name)
        if known is not None:
            return Cell(**known)
        here, half_ranges = places[turn % len(places)]
        looked = look_at_cells(
            here, job.selection, half_ranges, padded(y, job.chunk), job.imposed, job.steps
        )
        chunk = Cell(*(np.array(leaf)[: len(y)] for leaf in looked))
        parts.save(name, chunk._asdict())
        return chunk

    def look_at_all(name: str, y) -> Cell:
        def one(k: int) -> Cell:
            chunk = look(f"{name}-{k // job.chunk:05}", y[k : k + job.chunk], k // job.chunk)
            bar.update(len(chunk.residual) // 2 if name.startswith("cells") else 0)
            return chunk

        chunks = in_parallel(one, range(0, len(y), job.chunk))
        return Cell(*(np.concatenate(leaves) for leaves in zip(*chunks, strict=True)))

    cells = look_at_all(f"cells-{level}", y)
    return polished(lambda y, turn: look_at_all(f"polished-{level}-{turn}", y), cells)
