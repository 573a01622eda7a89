"""A branch followed along a path that is looked at in many places."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..programs import program
from ..robots.robot import Robot
from ..rods.solver import Steps
from .continuation import Corrected, follow
from .correction import settle
from .problem import Problem
from .status import Status
from .unknowns import unknown_scales

_CHUNK = 64
"""Stops in one call: paths of any length share a program."""


class Visited(NamedTuple):
    """What was met along a path.

    **Attributes:**

    - `y`: unknowns at the stops that were reached, SI units.
    - `status`: `SOLVED`, or why the next one was not.
    - `progress`: how much of the way to that one the branch goes.
    """

    y: Float[np.ndarray, "reached n_y"]
    status: Status
    progress: float


def visit(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    start: Float[np.ndarray, " n_y"],
    stops: Float[np.ndarray, "stops n_q"],
    steps: Steps,
) -> Visited:
    """Follows an equilibrium from stop to stop, along straight lines, until the branch ends.

    **Arguments:**

    - `imposed`: see `Problem`.
    - `start`: an equilibrium; the first line begins there.
    - `stops`: values of `(q_a, q_p)`, of which the imposed ones count.
    """
    y, reached = start, [np.empty((0, robot.n_y))]
    for k in range(0, len(stops), _CHUNK):
        some = stops[k : k + _CHUNK]
        rest = np.broadcast_to(some[-1], (_CHUNK - len(some), some.shape[1]))
        found = follow_stops(robot, imposed, y, np.concatenate([some, rest]), np.asarray(steps))
        ways, ends, progress = (np.asarray(part)[: len(some)] for part in found)
        missed = np.flatnonzero(ends != Status.SOLVED)
        if len(missed):
            first = missed[0]
            reached.append(ways[:first])
            return Visited(
                np.concatenate(reached), Status(int(ends[first])), float(progress[first])
            )
        reached.append(ways)
        y = ways[-1]
    return Visited(np.concatenate(reached), Status.SOLVED, 1.0)


def compile_visit(robot: Robot, imposed: Float[Array, "n_a n_q"], steps: Steps) -> None:
    """Compiles what `visit` needs: on NaN it stops at once."""
    nowhere = np.full(robot.n_y, np.nan)
    visit(robot, imposed, nowhere, nowhere[None, : robot.n_a + robot.n_p], steps)


class _Stops(NamedTuple):
    y: Float[Array, "stops n_y"]
    status: Int[Array, " stops"]
    progress: Float[Array, " stops"]


@program
def follow_stops(robot, imposed, start, stops, steps) -> _Stops:
    """As `visit`, for a given number of stops; those behind the end of the branch are NaN."""
    units = unknown_scales(robot)
    n_q = robot.n_a + robot.n_p

    def correct(predicted, _, h, dh, reach):
        along = imposed @ (dh / units[:n_q])
        shift = jnp.concatenate([jnp.zeros(robot.n_y - robot.n_a), along])
        problem = Problem(robot, imposed, h)
        found = settle(problem, predicted, shift[:, None], steps, reach=reach)
        return Corrected(found.y, found.converged, found.sign, found.slope[:, 0])

    def go(y, stop):
        line = jnp.stack([y[:n_q], stop])
        # Stops are close together: most are reached in one step.
        track = follow(correct, y / units, line, first_step=1.0)
        arrived = jnp.where(track.status == Status.SOLVED, track.y * units, jnp.nan)
        return arrived, _Stops(arrived, track.status, track.progress)

    _, stops_found = jax.lax.scan(go, start, stops)
    return stops_found
