"""A planar robot at an equilibrium."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from ..errors import InputError
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.shape import Shape, shape
from .style import BLACK, BLUE, GREY, VERMILION


def plot_robot(
    robot: Robot,
    equilibrium: Equilibrium,
    ax: Axes,
    *,
    color: str = BLUE,
    alpha: float = 1.0,
    unit: float = 1e3,
) -> Shape:
    """Draws rods, rigid segments, motors and platform of a planar robot.

    **Arguments:**

    - `ax`: matplotlib axes.
    - `unit`: factor from m to the unit of the axes; 1000 draws millimetres.

    **Returns:** the shape that was drawn, in m.
    """
    if robot.geometry.d != 2:
        raise InputError("Argument `robot` must be planar to be drawn here, but it is spatial.")
    drawn = shape(robot, equilibrium)
    rods = np.asarray(drawn.rods.position) * unit
    motors, joints = np.asarray(drawn.motors) * unit, np.asarray(drawn.joints) * unit
    for rod, motor, joint in zip(rods, motors, joints, strict=True):
        for start, end in ((motor, rod[0]), (rod[-1], joint)):
            ax.plot(
                *zip(start, end, strict=True),
                color=BLACK,
                lw=2.4,
                alpha=alpha,
                solid_capstyle="round",
            )
        ax.plot(*rod.T, color=color, lw=1.6, alpha=alpha, zorder=2)
        ax.plot(*motor, "o", ms=7, mfc="white", mec=BLACK, mew=1.2, alpha=alpha, zorder=3)
        ax.plot(*motor, ".", ms=3, color=BLACK, alpha=alpha, zorder=4)
    if robot.oriented:
        ax.add_patch(Polygon(joints, closed=True, fc=GREY, ec=BLACK, alpha=0.35 * alpha, zorder=1))
    for joint in joints:
        ax.plot(*joint, "o", ms=5, mfc="white", mec=BLACK, mew=1.0, alpha=alpha, zorder=5)
    end_effector = np.asarray(equilibrium.q_p)[:2] * unit
    ax.plot(*end_effector, "o", ms=3, color=VERMILION, alpha=alpha, zorder=6)
    ax.set_aspect("equal")
    return drawn
