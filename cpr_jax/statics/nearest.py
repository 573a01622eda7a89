"""Which of the rotation vectors of one orientation is nearest to where a robot is."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ..geometry import namespace
from ..robots.robot import Robot


def nearest_turn(
    robot: Robot, target: Float[Any, " n_q"], q_p: Float[Any, " n_p"]
) -> Float[Any, " n_q"]:
    """A target `(q_a, q_p)` with its orientation, whole turns about its axis closer to `q_p`.

    A body that hangs, turned by π, is close to all that is turned by π about axes close by, some
    of whose rotation vectors of less than π lie across all of the way round.
    """
    xp = namespace(target, q_p)
    first = robot.n_a + robot.geometry.d
    vector, start = xp.asarray(target)[first:], xp.asarray(q_p)[robot.geometry.d :]
    angle = xp.sqrt(xp.sum(vector**2))
    # No turn at all is one about any axis: that of the start leads to the nearest.
    away = xp.sqrt(xp.sum(start**2))
    along = start / xp.where(away > 0.0, away, 1.0)
    axis = xp.where(angle > 0.0, vector / xp.where(angle > 0.0, angle, 1.0), along)
    whole = 2.0 * np.pi * xp.round((xp.sum(axis * start) - angle) / (2.0 * np.pi))
    return xp.asarray(target) + xp.concatenate([np.zeros(first), whole * axis])
