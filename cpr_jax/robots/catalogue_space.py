"""Spatial robots of papers and of common kinds."""

from typing import TypeAlias

import numpy as np

from ..geometry import SPACE
from ..rods.rod import Rod, section_rod
from ..rods.section import Material, circle
from .joint import Joint, clamped, passive, spherical, swivel, universal
from .leg import make_leg, prismatic_screw
from .robot import Robot, make_robot

_Vector: TypeAlias = tuple[float, float, float] | np.ndarray

GRAVITY = 9.81
"""m/s², along -z."""

_UPWARD = (0.0, -np.pi / 2.0, 0.0)
"""Turns the first local axis, the tangent, from x to z."""


def _ring(radius: float, angle: float, height: float = 0.0) -> tuple[float, float, float]:
    """A point on a horizontal circle; the angle in degrees from x."""
    turn = np.deg2rad(angle)
    return (radius * np.cos(turn), radius * np.sin(turn), height)


def _frame(first: _Vector, third: _Vector) -> np.ndarray:
    """The rotation vector of axes of which the first and the third are given, orthonormal."""
    columns = np.stack([np.asarray(v) for v in (first, np.cross(third, first), third)], axis=1)
    across = columns - columns.T
    # Twice the sine of the angle along the axis; twice the cosine, and one, are the trace.
    axis = 0.5 * np.array([across[2, 1], across[0, 2], across[1, 0]])
    sine = np.linalg.norm(axis)
    angle = np.arctan2(sine, 0.5 * (np.trace(columns) - 1.0))
    return axis * (angle / sine if sine > 0.0 else 1.0)


def _uncertain(legs: int, rod: Rod) -> dict[str, float]:
    """Half ranges of 5 % of both bending stiffnesses and of 0.5 mm of the length of each rod."""
    stiffness = 0.05 / float(np.asarray(rod.curvature_compliance)[-1])
    return {
        f"{name}{i}": value
        for i in range(1, legs + 1)
        for name, value in (("k_2", stiffness), ("k_3", stiffness), ("l", 5e-4))
    }


def _spring_steel(length: float, radius: float, precurvature: float = 0.0) -> Rod:
    """A round rod under its weight."""
    steel = Material(E=200e9, nu=0.3, density=7850.0)
    gravity = (0.0, 0.0, -GRAVITY)
    return section_rod(SPACE, length, circle(radius), steel, precurvature, gravity=gravity)


def _weight(mass: float, height: float = 0.0) -> list[tuple[_Vector, _Vector]]:
    """The load of a platform's mass, kg, above `p_P` by a height, m."""
    return [((0.0, 0.0, height), (0.0, 0.0, -mass * GRAVITY))]


def stewart_gough(*, extensible: bool = True) -> Robot:
    """The length-fed continuum Stewart–Gough robot of Till's examples.

    From J. Till, *ContinuumRobotExamples*, 02_CSG_Inverse_Kinematics: six steel rods of 1 mm
    radius and a platform of 0.1 kg under gravity. The rods are clamped upright in the base and
    clamped to the platform but for a free twist, so that none of them carries torsion. Motor
    positions are lengths fed beyond 0.4 m.

    **Arguments:**

    - `extensible`: whether the rods stretch and shear, as they do in the source.
    """
    section = circle(0.001, shear_factor=1.0)
    steel = Material(E=200e9, nu=0.25, density=8000.0)
    rod = section_rod(
        SPACE, 0.4, section, steel, extensible=extensible, gravity=(0.0, 0.0, -GRAVITY)
    )
    return make_robot(
        SPACE,
        _fed_legs(
            rod,
            swivel(SPACE),
            [(_ring(0.087, angle), _UPWARD) for angle in (-10, 10, 110, 130, 230, 250)],
            [_ring(0.087, angle) for angle in (-50, 50, 70, 170, 190, 290)],
        ),
        oriented=True,
        loads=_weight(0.1),
        home=(np.full(6, 0.01), (0.0, 0.0, 0.4, 0.0, 0.0, 0.0)),
        uncertainty=_uncertain(6, rod),
        name="continuum Stewart–Gough",
    )


def stewart_gough_clamped(*, length: float = 0.6) -> Robot:
    """Six rods that spin freely in their base and are clamped to the platform.

    From the parallel robot scripts of Kuntz Lab's *bendier*: rods of 0.75 mm radius without
    weight, whose tips end 0.1 m below the platform's reference point. They stretch and shear, with
    all of their section, as they do in the source.

    **Arguments:**

    - `length`: of the rods with the motors at zero, m.
    """
    section = circle(0.00075, shear_factor=1.0)
    material = Material(E=207e9, nu=207.0 / 79.3 / 2.0 - 1.0)
    rod = section_rod(SPACE, length, section, material, extensible=True)
    spin = passive(SPACE, swivel(SPACE))
    legs = _fed_legs(
        rod,
        clamped(SPACE),
        [(_ring(0.1, angle), _UPWARD) for angle in (10, 110, 130, 230, 250, 350)],
        [_ring(0.1, angle, -0.1) for angle in (50, 70, 170, 190, 290, 310)],
        base_joint=spin,
    )
    return make_robot(
        SPACE,
        legs,
        oriented=True,
        home=(np.zeros(6), (0.0, 0.0, 0.1 + 0.99 * length, 0.0, 0.0, 0.0)),
        uncertainty=_uncertain(6, rod),
        name="clamped Stewart–Gough",
    )


def _fed_legs(rod, joint: Joint, bases, places, base_joint=None):
    """Upright legs whose motors feed rod."""
    return [
        make_leg(
            SPACE,
            base,
            rod,
            base_rotation=upright,
            screw=np.zeros(6),
            feed=1.0,
            joint=joint,
            base_joint=base_joint,
            attachment_position=place,
            attachment_rotation=_UPWARD,
        )
        for (base, upright), place in zip(bases, places, strict=True)
    ]


def stewart_gough_sliding() -> Robot:
    """A Stewart–Gough robot with linear motors: upright sliders push rods to spherical joints.

    Six spring steel rods of 0.8 mm radius, clamped to their sliders, and a platform of 0.05 kg.
    """
    rod = _spring_steel(0.3, 0.0008)
    legs = [
        make_leg(
            SPACE,
            _ring(0.1, base),
            rod,
            base_rotation=_UPWARD,
            screw=prismatic_screw(SPACE),
            joint=spherical(SPACE),
            attachment_position=_ring(0.07, place),
        )
        for base, place in zip(
            (-10, 10, 110, 130, 230, 250), (-50, 50, 70, 170, 190, 290), strict=True
        )
    ]
    return make_robot(
        SPACE,
        legs,
        oriented=True,
        loads=_weight(0.05),
        home=(np.zeros(6), (0.0, 0.0, 0.285, 0.0, 0.0, 0.0)),
        uncertainty=_uncertain(6, rod),
        name="6-PFS",
    )


def six_rus() -> Robot:
    """A 6-RUS robot: cranks move precurved rods on universal joints to spherical joints.

    Rods of 0.25 m and 1 mm radius with a radius of precurvature of 0.5 m, cranks of 50 mm, a
    platform of 0.1 kg whose centre of mass is 10 mm above the joints.
    """
    rod = _spring_steel(0.25, 0.001, 2.0)
    legs = []
    for base, place, turn in zip(
        (-15, 15, 105, 135, 225, 255),
        (-45, 45, 75, 165, 195, 285),
        (-90, 90, -90, 90, -90, 90),
        strict=True,
    ):
        # Cranks swing in planes along the circle; the rods begin upright.
        outward = np.asarray(_ring(1.0, base))
        crank = np.asarray(_ring(1.0, base + turn))
        legs.append(
            make_leg(
                SPACE,
                _ring(0.12, base),
                rod,
                base_rotation=_frame(crank, np.sign(turn) * outward),
                base_joint=passive(
                    SPACE, universal(SPACE), (0.05, 0.0, 0.0), (0.0, 0.0, np.pi / 2.0)
                ),
                joint=spherical(SPACE),
                attachment_position=_ring(0.09, place),
            )
        )
    return make_robot(
        SPACE,
        legs,
        oriented=True,
        loads=_weight(0.1, 0.01),
        home=(np.zeros(6), (0.0, 0.0, 0.24, 0.0, 0.0, 0.0)),
        uncertainty=_uncertain(6, rod),
        name="6-RUS",
    )


def three_rfs() -> Robot:
    """A 3-RFS robot: three motors bend a platform that has six freedoms.

    Rods of 0.3 m and 1 mm radius, clamped to motors that turn about the tangents of a circle,
    lead to spherical joints of a platform of 0.05 kg.
    """
    rod = _spring_steel(0.3, 0.001)
    legs = [
        make_leg(
            SPACE,
            _ring(0.12, angle),
            rod,
            # From outward at q = 0 a motor lifts its rod upward, then inward.
            base_rotation=_frame(_ring(1.0, angle), _ring(1.0, angle - 90.0)),
            joint=spherical(SPACE),
            attachment_position=_ring(0.06, angle),
        )
        for angle in (0, 120, 240)
    ]
    return make_robot(
        SPACE,
        legs,
        oriented=True,
        loads=_weight(0.05),
        home=(np.full(3, np.deg2rad(80.0)), (0.0, 0.0, 0.28, 0.0, 0.0, 0.0)),
        uncertainty=_uncertain(3, rod),
        name="3-RFS",
    )
