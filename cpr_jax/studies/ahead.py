"""The programs of a study, compiled side by side when they are first needed."""

import threading
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from ..analysis.ellipsoid import Ellipsoid, ellipsoid
from ..analysis.expansion import Expansion, expand
from ..analysis.parameters import Selection
from ..analysis.sensitivity import named
from ..analysis.singularity import compile_tracing
from ..analysis.slopes import Hold, slopes_at
from ..background import not_a_number, started
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.accuracy import MENU, STEPS
from ..statics.chord import EXACT
from ..statics.solve_ahead import compile_from_home
from ..statics.stops import compile_visit
from ..statics.unknowns import unknown_labels
from .cells import look_at_cells
from .follower import Follower
from .samples import Options, Study, compile_following, compile_samples

_known: set[Any] = set()


class Ahead:
    """Programs on their way. As a context it waits for all of them in the end, come what may.

    They run once on NaN, on which every iteration stops at once. A program that is called before
    it is ready would be compiled twice on several devices: `wait` for it.
    """

    def __init__(self, *unnamed: threading.Thread, **named: threading.Thread):
        self._named = named
        self._threads = [*unnamed, *named.values()]

    def wait(self, name: str) -> None:
        """Until the programs of this name are there."""
        if name in self._named:
            self._named[name].join()

    def __enter__(self) -> "Ahead":
        return self

    def __exit__(self, *_: object) -> None:
        for thread in self._threads:
            thread.join()


def compile_map(
    follower: Follower,
    selection: Selection,
    delta: Float[Array, " n_rho"],
    places: tuple[int, ...],
    steps: int,
    chunk: int,
    from_home: bool,
) -> Ahead:
    """Starts to compile what a map needs, in threads, while its seed is still being solved.

    Compilation leaves cores idle; done in turn it is most of a first map's time. Its parts are
    named `follow` (the branch), `look` (at cells) and `lines` (to trace).

    **Arguments:**

    - `from_home`: whether the seed is solved from home.
    """
    robot, imposed, axes, _, many = follower
    if not _is_new("map", robot, selection, axes, places, steps, many, chunk):
        return Ahead()
    cells = not_a_number(chunk, robot.n_y)

    def look() -> None:
        look_at_cells(robot, selection, delta, cells, places, steps)

    def lines() -> None:
        first.join()
        compile_tracing(robot, axes, places, steps)

    # What is needed first is traced first.
    seed = compile_from_home(robot, imposed, STEPS[0]) if from_home else []
    first = started(follower.compile)
    return Ahead(*seed, follow=first, look=started(look), lines=started(lines))


def compile_trajectory(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    selection: Selection,
    delta: Float[Array, " n_rho"],
    places: tuple[int, ...],
    steps: int,
    chunk: int,
) -> Ahead:
    """Starts to compile what a trajectory needs: to `visit` its stops and to `look` at them."""
    if not _is_new("trajectory", robot, selection, places, steps, chunk):
        return Ahead()
    cells = not_a_number(chunk, robot.n_y)
    return Ahead(
        visit=started(lambda: compile_visit(robot, imposed, steps)),
        look=started(lambda: look_at_cells(robot, selection, delta, cells, places, steps)),
    )


def compile_study(
    robot: Robot, options: Options, delta: Float[Array, " n_rho"], followed: bool = False
) -> Ahead:
    """Starts to compile what a Monte Carlo study needs.

    **Arguments:**

    - `followed`: whether some samples are known to be doubtful, which most studies have none of.
    """
    selection = options.selection
    needed = _is_new("study", robot, options)
    followed = followed and _is_new("followed", robot, options)
    if not (needed or followed):
        return Ahead()
    d, n_rho = robot.geometry.d, len(selection.labels)
    y, slopes = not_a_number(robot.n_y), not_a_number(robot.n_y, n_rho)
    expansion = Expansion.unknown(robot, n_rho)
    study = Study(robot, y, delta, expansion, np.asarray(MENU[0]), np.asarray(EXACT))
    place, axes = not_a_number(d), not_a_number(d, d)
    labels = unknown_labels(robot)[robot.n_a : robot.n_a + d]
    bounds = Ellipsoid(place, axes, place, axes, labels)

    def linear() -> None:
        found = slopes_at(robot, y, selection, DEFAULT_STEPS)
        ellipsoid(named(robot, y, selection, delta, found, Hold.MOTORS))

    def expanding() -> None:
        expand(robot, selection, y, slopes, delta, np.asarray(MENU[0]))

    jobs = []
    if needed:
        jobs += [linear, expanding, lambda: compile_samples(study, options, bounds)]
    if followed:
        jobs.append(lambda: compile_following(study, options, bounds))
    return Ahead(*map(started, jobs))


def _is_new(kind: str, robot: Robot, *further: Any) -> bool:
    """Whether programs like these have not been asked for yet."""
    leaves, structure = jax.tree.flatten(robot)
    key = kind, structure, tuple(np.shape(leaf) for leaf in leaves), *further
    new = key not in _known
    _known.add(key)
    return new
