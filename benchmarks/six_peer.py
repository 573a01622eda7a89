"""The six-leg robot in C++ by hand: see `native/six.cpp`."""

import ctypes
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

import cpr_jax as cpr

from .building import built


class Problem(NamedTuple):
    """Paths of the platform.

    **Attributes:**

    - `q_a`, `mu`: motor positions, m, and base wrenches `(6, 6)` where all paths start.
    - `q_p`: the pose there.
    - `poses`: those along the paths, `(paths, poses, 6)`.
    """

    q_a: np.ndarray
    mu: np.ndarray
    q_p: np.ndarray
    poses: np.ndarray


Solve = Callable[..., np.ndarray]


def make(robot: cpr.Robot, problem: Problem) -> tuple[Solve, Solve]:
    """Compiles the program; returns the published algorithm and the lean one.

    Both give the lengths of all legs, m, `(paths, poses, 6)`. The first is called with its
    integration steps, its tolerance on the sum of squares and its damping at first, the second
    with its steps and its Newton iterations at each pose.
    """
    native = built("six.cpp")
    rod = robot.legs.rod
    stretch, shear, _ = np.asarray(rod.strain_compliance)[0]
    weight = -np.asarray(rod.force)[0, 2]
    numbers = [
        [shear, stretch, np.asarray(rod.curvature_compliance)[0, 1], weight],
        [-np.asarray(robot.loads.force)[0, 2]],
        np.ravel(robot.legs.base_position),
        np.ravel(robot.legs.attachment_position),
    ]
    lengths = np.asarray(rod.length) + problem.q_a
    paths, count = problem.poses.shape[:2]
    given = [
        np.ascontiguousarray(part, float)
        for part in (
            np.concatenate(numbers),
            np.concatenate([problem.mu[:, :5].ravel(), lengths]),
            _placed(problem.q_p),
            _placed(problem.poses),
        )
    ]

    def called(function, *setting) -> np.ndarray:
        out = np.empty((paths, count, 6))
        arrays = [part.ctypes.data_as(ctypes.c_void_p) for part in (*given, out)]
        function.restype = ctypes.c_long
        failed = function(*arrays, ctypes.c_long(paths), ctypes.c_long(count), *setting)
        if failed:
            raise RuntimeError(f"{failed} poses are not solved.")
        return out

    def printed(steps: int, tolerance: float, damping: float) -> np.ndarray:
        numbers = ctypes.c_double(tolerance), ctypes.c_double(damping)
        return called(native.solve_printed, steps, *numbers)

    def lean(steps: int, iterations: int) -> np.ndarray:
        return called(native.solve_lean, steps, iterations)

    return printed, lean


def _placed(q_p: np.ndarray) -> np.ndarray:
    """Positions and rotation matrices, row by row, of poses."""
    turns = Rotation.from_rotvec(np.array(q_p[..., 3:]).reshape(-1, 3)).as_matrix()
    return np.concatenate([q_p[..., :3], turns.reshape(*q_p.shape[:-1], 9)], axis=-1)
