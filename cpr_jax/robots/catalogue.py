"""Robots that papers, tests and examples name."""

from collections.abc import Sequence

import numpy as np

from ..geometry import PLANE, floats, namespace
from ..rods.rod import kirchhoff_rod
from .joint import Joint, pivot
from .leg import make_leg, prismatic_screw
from .robot import Robot, make_robot


def rfrfr(
    *,
    l: float = 0.25,  # noqa: E741
    a: float = 0.045,
    b: float = 0.035,
    d: float = 0.2,
    k_b: float | Sequence[float] = 0.0183,
    r_c: Sequence[float] = (-1.0, 1.0),
    f_P: Sequence[float] = (0.0, 1.0),
    printed_moment_row: bool = False,
) -> Robot:
    """The planar RFRFR robot of the paper, with Table 1 as defaults (SI units).

    Two revolute motors at `(∓d/2, 0)` each turn a rigid segment `a`, a precurved rod and a rigid
    segment `b`; a pivot joins both at the end-effector. The first leg is the left one; it has
    the negative radius, so that the unloaded legs bow outward.

    **Arguments:**

    - `l`, `a`, `b`, `d`: length of the rods, of the rigid segments, distance of the motors, m.
    - `k_b`: bending stiffness, N·m², one or one a leg. Table 1 prints N·mm², which would make
        the rods 2.7 kPa soft.
    - `r_c`: radii of precurvature, m.
    - `f_P`: force on the end-effector, N.
    - `printed_moment_row`: use `m_x(l_i) = 0` at the rods' tips, as (15) is printed, instead of
        no moment at the pivot.
    """
    xp = namespace(k_b)
    stiffness = xp.broadcast_to(xp.asarray(k_b, float), (2,))
    joint = pivot(PLANE)
    if printed_moment_row:
        joint = Joint(free=joint.free, lever=floats(0.0))
    legs = [
        make_leg(
            PLANE,
            (side * d / 2.0, 0.0),
            kirchhoff_rod(PLANE, l, stiffness[i], 1.0 / r_c[i]),
            a=a,
            b=b,
            joint=joint,
        )
        for i, side in enumerate((-1.0, 1.0))
    ]
    return make_robot(
        PLANE,
        legs,
        oriented=False,
        f_P=f_P,
        home=((2.7, 0.44), (0.0, 0.2)),
        uncertainty={"k_b1": 4.73e-3, "r_c1": 0.1, "k_b2": 4.73e-3, "r_c2": 0.1},
        name="RFRFR",
    )


def rfrfr_straight(*, f_P: Sequence[float] = (0.0, 0.0)) -> Robot:
    """The RFRFR robot with straight rods of 1 m and no rigid segments.

    From Zaccaria's shooting code in *A Gazebo Simulator for Continuum Parallel Robots*: rods of
    1 mm radius and 200 GPa, motors 0.4 m apart.
    """
    legs = [
        make_leg(PLANE, (side * 0.2, 0.0), kirchhoff_rod(PLANE, 1.0, 0.1570796327))
        for side in (-1.0, 1.0)
    ]
    return make_robot(
        PLANE,
        legs,
        oriented=False,
        f_P=f_P,
        home=((np.deg2rad(120.0), np.deg2rad(60.0)), (0.0, 0.9275)),
        uncertainty={"k_b1": 0.0157, "k_b2": 0.0157},
        name="straight RFRFR",
    )


def three_rfr() -> Robot:
    """A planar 3-RFR robot: three precurved rods carry a triangular platform.

    Motors on a circle of 0.22 m, pivots on a circle of 0.06 m of the platform, each 60 degrees
    further on, so that the legs pass beside the centre and resist its rotation; rods of 0.25 m
    with the stiffness of the paper's robot.
    """
    third = np.sqrt(3.0) / 2.0
    around = np.array([(0.0, -1.0), (third, 0.5), (-third, 0.5)])
    further = np.array([(third, -0.5), (0.0, 1.0), (-third, -0.5)])
    legs = [
        make_leg(
            PLANE,
            0.22 * around[i],
            kirchhoff_rod(PLANE, 0.25, 0.0183, 2.0),
            attachment_position=0.06 * further[i],
        )
        for i in range(3)
    ]
    return make_robot(
        PLANE,
        legs,
        oriented=True,
        f_P=(0.0, -0.5),
        home=((-0.2, 1.85, 3.95), (0.0, 0.0, 0.0)),
        uncertainty={
            label: value
            for i in (1, 2, 3)
            for label, value in ((f"k_b{i}", 1.83e-3), (f"r_c{i}", 0.05))
        },
        name="3-RFR",
    )


def three_pfr() -> Robot:
    """A planar 3-PFR robot: sliders push three precurved rods to pivots of a triangular platform.

    The sliders move towards the centre from a circle of 0.275 m. Rods of 0.25 m with the
    stiffness of the paper's robot bend to the right, with a radius of 0.5 m, to pivots on a circle
    of 0.07 m of the platform, each 60 degrees further on: at home they are nearly at rest.
    """
    legs = []
    for angle in (-90.0, 30.0, 150.0):
        out, on = np.deg2rad(angle), np.deg2rad(angle + 60.0)
        legs.append(
            make_leg(
                PLANE,
                (0.275 * np.cos(out), 0.275 * np.sin(out)),
                kirchhoff_rod(PLANE, 0.25, 0.0183, -2.0),
                base_rotation=np.array([out + np.pi]),
                screw=prismatic_screw(PLANE),
                attachment_position=(0.07 * np.cos(on), 0.07 * np.sin(on)),
            )
        )
    return make_robot(
        PLANE,
        legs,
        oriented=True,
        f_P=(0.0, -0.5),
        home=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        uncertainty={
            label: value
            for i in (1, 2, 3)
            for label, value in ((f"k_b{i}", 1.83e-3), (f"r_c{i}", 0.05))
        },
        name="3-PFR",
    )
