"""Programs of a solve, compiled before they are called."""

import threading
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from ..background import not_a_number, started
from ..robots.robot import Robot
from ..rods.solver import Steps
from .accuracy import BALANCED
from .assembly import at_rest, from_home
from .equilibrium import polish
from .status import Status

_compiled: set[Any] = set()


def compile_polish(robot, imposed, target, branch, steps) -> threading.Thread | None:
    """Starts to compile `polish` while the way to a solution is compiled and followed."""
    leaves, structure = jax.tree.flatten((robot, imposed, target))
    key = structure, tuple(np.shape(leaf) for leaf in leaves), branch
    if key in _compiled:
        return None
    _compiled.add(key)

    def compile_it() -> None:
        nowhere = not_a_number(robot.n_y), np.asarray(int(Status.LOST))
        polish(robot, imposed, target, *nowhere, np.asarray(BALANCED), branch, steps)

    return started(compile_it)


def compile_from_home(
    robot: Robot, imposed: Float[Array, "n_a n_q"], steps: Steps
) -> list[threading.Thread]:
    """Starts to compile what finds the equilibrium at any target of a robot with a home."""
    robot, target = robot.unnamed, not_a_number(robot.n_a + robot.n_p)
    steps = np.asarray(steps)
    moving = started(lambda: from_home(robot, imposed, at_rest(robot), target, steps))
    ending = compile_polish(robot, imposed, target, "home", steps)
    return [moving] if ending is None else [moving, ending]
