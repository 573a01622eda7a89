"""A planar robot at an equilibrium."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from ..errors import InputError
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.shape import Shape
from .solids import solved_shape
from .style import BLACK, BLUE, GREY, VERMILION, unit_name

_MOTOR, _JOINT = 7.0, 5.0
"""Sizes of markers, points."""


def plot_robot(
    robot: Robot,
    equilibrium: Equilibrium,
    ax: Axes,
    *,
    color: str = BLUE,
    alpha: float = 1.0,
    unit: float = 1e3,
) -> Shape:
    """Draws rods, rigid segments, motors, joints and platform of a planar robot.

    Motors that turn are round, others square; a grey line is the way that a slider has gone.

    **Arguments:**

    - `ax`: matplotlib axes.
    - `unit`: factor from m to the unit of the axes; 1000 draws millimetres.

    **Returns:** the shape that was drawn, in m.
    """
    if robot.geometry.d != 2:
        raise InputError("Argument `robot` must be planar to be drawn here, but it is spatial.")
    drawn = solved_shape(robot, equilibrium)
    rods = np.asarray(drawn.rods.position) * unit
    bases, motors, pivots, joints = (
        np.asarray(places) * unit
        for places in (robot.legs.base_position, drawn.motors, drawn.pivots, drawn.joints)
    )
    turning = np.any(np.asarray(robot.legs.screw)[:, 2:], axis=1)
    base_joint = robot.legs.base_joint
    passive = np.zeros(robot.n, bool)
    if base_joint is not None:
        passive = np.any(np.asarray(base_joint.free), axis=1)

    def bar(start, end) -> None:
        ends = np.stack([start, end])
        ax.plot(*ends.T, color=BLACK, lw=2.4, alpha=alpha, solid_capstyle="round")

    def ring(place, marker: str, size: float, edge: float, order: int) -> None:
        look: Any = {"mfc": "white", "mec": BLACK, "mew": edge, "alpha": alpha, "zorder": order}
        ax.plot(*place, marker, ms=size, **look)

    for i, rod in enumerate(rods):
        ax.plot(*np.stack([bases[i], motors[i]]).T, color=GREY, lw=1.0, alpha=alpha, zorder=1)
        bar(motors[i], pivots[i])
        bar(pivots[i], rod[0])
        bar(rod[-1], joints[i])
        ax.plot(*rod.T, color=color, lw=1.6, alpha=alpha, zorder=2)
        ring(motors[i], "o" if turning[i] else "s", _MOTOR, 1.2, 3)
        ax.plot(*motors[i], ".", ms=3, color=BLACK, alpha=alpha, zorder=4)
        if passive[i]:
            ring(pivots[i], "o", _JOINT, 1.0, 5)
    if robot.oriented:
        ax.add_patch(Polygon(joints, closed=True, fc=GREY, ec=BLACK, alpha=0.35 * alpha, zorder=1))
    for joint in joints:
        ring(joint, "o", _JOINT, 1.0, 5)
    end_effector = np.asarray(equilibrium.q_p)[:2] * unit
    ax.plot(*end_effector, "o", ms=3, color=VERMILION, alpha=alpha, zorder=6)
    ax.set_aspect("equal")
    across, up = robot.geometry.axes
    ax.set_xlabel(f"{across} ({unit_name(unit)})")
    ax.set_ylabel(f"{up} ({unit_name(unit)})")
    return drawn
