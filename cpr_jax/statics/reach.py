"""What a leg can reach, and how far its rod can be drawn in."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ..geometry import namespace
from ..robots.robot import Robot
from ..rods.segments import first_length
from .unknowns import scales

_FAR = 30.0
"""Rod lengths from which a position looks like one in millimetres."""


def reaches(robot: Robot) -> Float[np.ndarray, " n"]:
    """How far the far end of each leg can be from its base, m; infinite where nothing limits it."""
    legs = robot.legs
    d = robot.geometry.d
    straight = [np.linalg.norm(np.asarray(part), axis=-1) for part in (legs.a, legs.b)]
    reach = np.asarray(legs.rod.length) + straight[0] + straight[1]
    limited = np.all(np.asarray(legs.screw)[:, :d] == 0.0, axis=1)
    if legs.stroke is not None:
        limited &= np.all(np.asarray(legs.stroke) == 0.0, axis=1)
    if legs.base_joint is not None:
        reach = reach + np.linalg.norm(np.asarray(legs.base_joint.position), axis=-1)
        limited &= np.all(np.asarray(legs.base_joint.free)[:, :d] == 0.0, axis=1)
    if legs.feed is not None:
        limited &= np.asarray(legs.feed) == 0.0
    if legs.rod.strain_compliance is not None:
        limited &= np.all(np.asarray(legs.rod.strain_compliance) == 0.0, axis=-1)
        if legs.rod.further is not None:
            beyond = np.asarray(legs.rod.further.strain_compliance)
            limited &= np.all(beyond == 0.0, axis=(-2, -1))
    limited &= np.all(np.asarray(legs.joint.free)[:, :d] == 0.0, axis=1)
    return np.where(limited, reach, np.inf)


def hardly_metres(robot: Robot, positions: Float[np.ndarray, "*k"]) -> str:
    """A sentence on positions that are too far away to be in metres, or nothing."""
    length = float(scales(robot).length)
    if np.any(np.abs(positions) > _FAR * length):
        return f"Positions are in metres, which these hardly are: its rods are {length:.3g} m long."
    return ""


def out_of_reach(
    robot: Robot,
    targets: Float[np.ndarray, "k n_q"],
    imposed: Sequence[int],
    share: float = 1.0 + 1e-12,
) -> np.ndarray:
    """Whether some leg is shorter than the way from its base to its joint, shape `(k,)`.

    Nobody knows of targets whose position is not imposed.

    **Arguments:**

    - `share`: of its reach, from which a leg counts as too short.
    """
    d, n_a = robot.geometry.d, robot.n_a
    q_p = targets[:, n_a:]
    if not set(range(n_a, n_a + d)) <= set(imposed):
        return np.zeros(len(q_p), bool)
    turns = set(range(n_a + d, n_a + robot.n_p)) <= set(imposed)
    arms = np.asarray(robot.legs.attachment_position)
    slack = np.zeros(robot.n)
    if not turns:
        # A turn that is not imposed may be any.
        arms, slack = np.zeros_like(arms), np.linalg.norm(arms, axis=-1)
    orientation: Any = [np.asarray(part)[..., None] for part in robot.orientation(q_p.T)]
    rows = robot.geometry.rows(orientation)
    turned: Any = robot.geometry.rotate(rows, tuple(arms.T))
    ends = q_p[:, None, :d] + np.stack(turned, axis=-1)
    ways = np.linalg.norm(ends - np.asarray(robot.legs.base_position), axis=-1)
    return np.any(ways - slack > reaches(robot) * share, axis=1)


def used_up(robot: Robot, q_a: Float[Any, "*cases n_a"]) -> Bool[Any, "*cases"]:
    """Whether motors have drawn in all of a rod, or of its first segment.

    The equations go on there, with a rod of negative length; the robot does not.
    """
    numbers = robot.legs.feed, robot.transmission, first_length(robot.legs.rod)
    xp = namespace(numbers, q_a)
    if numbers[0] is None:
        return xp.zeros(xp.shape(q_a)[:-1], bool)
    feed, transmission, lengths = (xp.asarray(part) for part in numbers)
    return xp.any(lengths + feed * (xp.asarray(q_a) @ transmission.T) <= 0.0, axis=-1)
