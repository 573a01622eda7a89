"""Surfaces of robots and ellipsoids in space: what the figures and the interactive view draw.

Planar robots lie in the plane x = 0. Surfaces are in m; figures have their own unit.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from ..analysis.ellipsoid import Ellipsoid
from ..errors import InputError, shown
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.shape import Shape, shape
from ..statics.status import Status

SIDES = 16
"""Corners of the cross-sections of what is drawn round."""

_RADIUS = 0.005
"""Radius of a drawn rod in diagonals of the box around the robot: thin, but visible."""


class Solids(NamedTuple):
    """The surfaces of a robot, each a grid of vertices, m, shape `(rows, sides, 3)`.

    A row goes round a cross-section. The first and the last row are one point each, which
    closes the surface.

    **Attributes:**

    - `rods`: the rows between the first and the last are those of `Shape.s`.
    - `segments`: rigid ones, cranks, and the ways that sliding motors have gone.
    - `motors`: cylinders about the motors' axes.
    - `joints`: balls, at the platform and where there is a passive joint at the base.
    """

    rods: list[np.ndarray]
    segments: list[np.ndarray]
    motors: list[np.ndarray]
    joints: list[np.ndarray]


def solved_shape(robot: Robot, equilibrium: Equilibrium) -> Shape:
    """The shape of a robot, which must be in equilibrium."""
    status = Status(int(equilibrium.status))
    if status != Status.SOLVED:
        raise InputError(
            f"Argument `equilibrium` must be solved to be drawn, but its status is {status.name}."
        )
    return shape(robot, equilibrium)


def robot_solids(robot: Robot, drawn: Shape, radius: float | None = None) -> Solids:
    """The surfaces of a robot of which rods are drawn with a radius, m."""
    rods, motors, pivots, joints = (
        world(places) for places in (drawn.rods.position, drawn.motors, drawn.pivots, drawn.joints)
    )
    bases = world(robot.legs.base_position)
    everything = np.concatenate([rods.reshape(-1, 3), motors, pivots, joints, bases])
    size = float(np.linalg.norm(np.ptp(everything, axis=0)))
    if radius is None:
        radius = _RADIUS * size
    if not radius > 0.0:
        raise InputError(f"Argument `radius` must be positive, but it is {shown(radius)}.")
    frames = _frames(drawn.rods.rotation)
    starts = np.concatenate([bases, motors, pivots, rods[:, -1]])
    ends = np.concatenate([motors, pivots, rods[:, 0], joints])
    apart = np.linalg.norm(ends - starts, axis=1) > 1e-6 * size
    axes = _motor_axes(robot, frames[:, 0, :, 0])
    base_joint = robot.legs.base_joint
    passive: Any = () if base_joint is None else pivots[np.any(np.asarray(base_joint.free), axis=1)]
    return Solids(
        rods=[
            _swept(line, frame[..., 1:], radius) for line, frame in zip(rods, frames, strict=True)
        ],
        segments=[
            _bar(start, end, 1.3 * radius)
            for start, end in zip(starts[apart], ends[apart], strict=True)
        ],
        motors=[
            _bar(motor - 3.0 * radius * axis, motor + 3.0 * radius * axis, 2.4 * radius)
            for motor, axis in zip(motors, axes, strict=True)
        ],
        joints=[_ball(place, 2.0 * radius) for place in (*joints, *passive)],
    )


def outline(points: np.ndarray) -> np.ndarray:
    """The corners of the convex outline of points in their own plane, in order, `(k, 3)`."""
    centred = points - points.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred)
    if len(points) < 3 or sizes[1] <= 1e-9 * sizes[0]:
        return points
    return points[ConvexHull(centred @ axes[:2].T).vertices]


def ellipsoid_surface(ellipsoid: Ellipsoid, scale: float = 1.0) -> np.ndarray:
    """Points of an ellipsoid of a position magnified about its centre, m, `(25, 48, 3)`."""
    if ellipsoid.labels not in (("p_P_x", "p_P_y", "p_P_z"), ("p_P_y", "p_P_z")):
        raise InputError(
            "Argument `ellipsoid` must be of a position to be drawn, but it is of "
            f"{shown(', '.join(ellipsoid.labels))}."
        )
    polar, turn = np.linspace(0.0, np.pi, 25)[:, None], 2.0 * np.pi * np.arange(48) / 48
    sphere = [np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar) + 0 * turn]
    # An ellipse in the plane takes two of the three coordinates and is flat.
    directions, center = np.asarray(ellipsoid.directions), np.asarray(ellipsoid.center)
    local = np.stack(sphere[: len(center)], axis=-1) * np.asarray(ellipsoid.semi_axes)
    # Rows go round as those of a swept surface do, also where the axes are left-handed.
    local[..., -1] *= -np.sign(np.linalg.det(directions))
    return world(magnified(center + local @ directions, center, scale))


def magnified(points: Any, center: Any, scale: float) -> np.ndarray:
    """Points moved away from a centre by a factor."""
    if not scale > 0.0:
        raise InputError(f"Argument `scale` must be positive, but it is {shown(scale)}.")
    return np.asarray(center) + scale * (np.asarray(points) - np.asarray(center))


def world(vectors: Any) -> np.ndarray:
    """Vectors of space; those of the plane get an x of zero in front."""
    vectors = np.asarray(vectors, float)
    if vectors.shape[-1] == 3:
        return vectors
    return np.concatenate([np.zeros((*vectors.shape[:-1], 1)), vectors], axis=-1)


def faces(grid: np.ndarray) -> np.ndarray:
    """The quadrilaterals of a surface, counter-clockwise from outside, shape `(m, 4, 3)`."""
    after = np.roll(grid, -1, axis=1)
    corners = [grid[:-1], after[:-1], after[1:], grid[1:]]
    return np.stack(corners, axis=2).reshape(-1, 4, grid.shape[-1])


def unit_name(unit: float) -> str:
    """The unit of an axis on which a metre is so long; empty where it has no name."""
    return {1.0: "m", 100.0: "cm", 1e3: "mm"}.get(unit, "")


def _frames(rotation) -> np.ndarray:
    """Rotations of a shape as matrices, the tangent first, shape `(n, points, 3, 3)`."""
    rotation = np.asarray(rotation)
    if rotation.shape[-1] == 4:
        turns = Rotation.from_quat(rotation.reshape(-1, 4), scalar_first=True)
        return turns.as_matrix().reshape(*rotation.shape[:-1], 3, 3)
    c, s = np.moveaxis(rotation, -1, 0)
    tangent, normal = world(np.stack([c, s], -1)), world(np.stack([-s, c], -1))
    return np.stack([tangent, normal, np.cross(tangent, normal)], axis=-1)


def _motor_axes(robot: Robot, tangents: np.ndarray) -> np.ndarray:
    """Unit vectors about or along which motors move; along the rod if they feed it."""
    d = robot.geometry.d
    screw, base = np.array(robot.legs.screw), np.array(robot.legs.base_rotation)
    slide, turn = world(screw[:, :d]), screw[:, d:]
    if d == 2:
        turn, base = (np.pad(angles, ((0, 0), (0, 2))) for angles in (turn, base))
    axes = np.where(np.any(turn, axis=1, keepdims=True), turn, slide)
    axes = Rotation.from_rotvec(base).apply(axes)
    axes = np.where(np.any(axes, axis=1, keepdims=True), axes, tangents)
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


def _swept(centres: np.ndarray, across: np.ndarray, radii) -> np.ndarray:
    """Circles about points `(k, 3)`, in planes of columns `(k, 3, 2)`, closed at both ends."""
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    circles = np.moveaxis(across @ np.stack([np.cos(angle), np.sin(angle)]), -1, -2)
    grid = centres[:, None] + np.broadcast_to(radii, len(centres))[:, None, None] * circles
    first, last = (np.broadcast_to(centres[i], (1, SIDES, 3)) for i in (0, -1))
    return np.concatenate([first, grid, last])


def _bar(start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """A cylinder."""
    direction = (end - start) / np.linalg.norm(end - start)
    normal = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    normal /= np.linalg.norm(normal)
    across = np.stack([normal, np.cross(direction, normal)], axis=-1)
    return _swept(np.stack([start, end]), np.stack([across, across]), radius)


def _ball(center: np.ndarray, radius: float) -> np.ndarray:
    polar = np.linspace(0.0, np.pi, 9)[1:-1]
    rows = center - radius * np.cos(polar)[:, None] * np.eye(3)[2]
    return _swept(rows, np.broadcast_to(np.eye(3)[:, :2], (7, 3, 2)), radius * np.sin(polar))
