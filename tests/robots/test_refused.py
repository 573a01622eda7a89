"""Numbers that make no robot: each is refused where it is given, and named."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE, SPACE


def rod(**changes):
    given = {"length": 0.3, "k_b": 0.1} | changes
    return cpr.kirchhoff_rod(SPACE, **given)


def leg(base=(0.1, 0.0, 0.0), **changes):
    given = {"rod": rod(), "joint": cpr.spherical(SPACE)} | changes
    return cpr.make_leg(SPACE, base, **given)


def robot(legs=None, **changes):
    legs = [leg()] * 3 if legs is None else legs
    return cpr.make_robot(SPACE, legs, oriented=True, **changes)


def sectioned(radius=1e-3, E=2e11, gravity=None):
    return cpr.section_rod(SPACE, 0.3, cpr.circle(radius), cpr.Material(E), gravity=gravity)


def planar_leg():
    return cpr.make_leg(PLANE, (0.0, 0.0), cpr.kirchhoff_rod(PLANE, 0.3, 0.1))


MISTAKES = {
    "length": lambda: rod(length=-0.3),
    "k_b": lambda: rod(k_b=(0.1, 0.2)),
    "k_b` must be positive": lambda: rod(k_b=0.0),
    "precurvature": lambda: rod(precurvature=(1.0, 2.0)),
    "force": lambda: rod(force=-9.81),
    "moment": lambda: rod(moment=(0.0, 0.1)),
    "material.E": lambda: sectioned(E=-2e11),
    "radius": lambda: sectioned(radius=-1e-3),
    "width": lambda: cpr.rectangle(0.0, 1e-3),
    "height": lambda: cpr.rectangle(1e-3, -1e-3),
    "gravity": lambda: sectioned(gravity=-9.81),
    "base_position": lambda: leg(base=(0.1, 0.0)),
    "base_rotation": lambda: leg(base_rotation=0.1),
    "attachment_position": lambda: leg(attachment_position=(0.1, 0.0)),
    "attachment_rotation": lambda: leg(attachment_rotation=(0.1, 0.0)),
    "screw": lambda: leg(screw=cpr.revolute_screw(PLANE)),
    "stroke": lambda: leg(stroke=(0.1, 0.0)),
    "a": lambda: leg(a=(0.1, 0.0)),
    "rod": lambda: leg(rod=cpr.kirchhoff_rod(PLANE, 0.3, 0.1)),
    "joint": lambda: leg(joint=cpr.pivot(PLANE)),
    "base_joint": lambda: leg(base_joint=cpr.passive(PLANE, cpr.pivot(PLANE))),
    "legs": lambda: robot(legs=[leg(), planar_leg()]),
    "f_P": lambda: robot(f_P=(0.0, -1.0)),
    "m_P": lambda: robot(m_P=0.1),
    "loads[0]": lambda: robot(loads=[((0.0, 0.0), (0.0, 0.0, -1.0))]),
    "transmission": lambda: robot(transmission=np.eye(2)),
    "home": lambda: robot(home=(np.zeros(3), np.zeros(3), np.zeros(3))),
    "home[0]": lambda: robot(home=(np.zeros(2), np.zeros(6))),
    "home[1]": lambda: robot(home=(np.zeros(3), np.zeros(3))),
    "home[1]` must be finite": lambda: robot(home=(np.zeros(3), np.full(6, np.nan))),
    "f_P` must be finite": lambda: robot(f_P=(0.0, np.nan, 0.0)),
    "legs.base_position": lambda: robot(legs=[leg(), leg(base=(0.0, np.nan, 0.0))]),
    "material.nu": lambda: cpr.Material(2e11, nu=0.9),
    "material.density": lambda: cpr.Material(2e11, density=-1.0),
    "radius` must be positive": lambda: cpr.circle(np.nan),
    "radius` must be a number": lambda: cpr.circle("1 mm"),
    "m_P` must be left out": lambda: cpr.make_robot(
        PLANE, [planar_leg()] * 2, oriented=False, m_P=(0.1,)
    ),
    "legs` must have joints": lambda: cpr.make_robot(
        SPACE, [leg(joint=cpr.universal(SPACE))] * 3, oriented=False
    ),
    "transmission` must be finite": lambda: robot(transmission=np.full((3, 3), np.nan)),
    "loads[0]` must be finite": lambda: robot(loads=[((0.0, 0.0, np.inf), (0.0, 0.0, -1.0))]),
    "uncertainty['l1']` must be finite": lambda: robot(uncertainty={"l1": np.inf}),
    "axis": lambda: cpr.slider(PLANE, axis=2),
    "axis` must be an integer": lambda: cpr.prismatic_screw(SPACE, axis=-1),
    "position": lambda: cpr.passive(SPACE, cpr.universal(SPACE), position=0.1),
    "rotation": lambda: cpr.passive(SPACE, cpr.universal(SPACE), rotation=(0.0, np.pi)),
    "joint` must be a joint, such": lambda: cpr.passive(SPACE, "universal"),
    "geometry": lambda: cpr.kirchhoff_rod("plane", 0.3, 0.1),
    "joint` must be a joint": lambda: cpr.make_leg(SPACE, (0, 0, 0), rod(), joint=cpr.pivot),
    "base_joint` must be a joint": lambda: leg(base_joint=cpr.spherical(SPACE)),
    "rod` must be a rod": lambda: leg(rod=0.3),
    "robot": lambda: cpr.in_space(robot()),
    "motors": lambda: cpr.Limits(motors=(3.0, -3.0)),
    "material.density` must be positive": lambda: sectioned(gravity=(0.0, 0.0, -9.81)),
    "shear_factor": lambda: cpr.circle(1e-3, shear_factor=-0.9),
    "legs` must have no `attachment_position` at a point": lambda: cpr.make_robot(
        SPACE,
        [leg(joint=cpr.spherical(SPACE), attachment_position=(0.1, 0.0, 0.0))],
        oriented=False,
    ),
    "legs` must be a list": lambda: robot(legs=leg()),
    "uncertainty` must be half ranges": lambda: robot(uncertainty=["k_b1"]),
    "f_P` must be numbers": lambda: robot(f_P=("1 N", "0", "0")),
    "feed` must have shape": lambda: leg(feed=(1.0, 2.0)),
    "rods` must hold rods of one geometry": lambda: cpr.segmented_rod(
        [rod(), cpr.kirchhoff_rod(PLANE, 0.3, 0.1)]
    ),
    "rods` must be a list": lambda: cpr.segmented_rod(rod()),
    "motors` must be a lowest and a highest position": lambda: cpr.Limits(motors=(3.0,)),
    "motors` must be a lowest and": lambda: cpr.Limits(motors=([0.0, 1.0], [1.0, np.nan])),
    "torque` must be one number, or one for each": lambda: cpr.Limits(torque=np.ones((2, 2))),
    "moment` must be one number": lambda: cpr.Limits(moment=(1.0, 2.0)),
    "limits.torque": lambda: cpr.Limits(torque=(1.0, 2.0)).check_fits(robot()),
    "torque": lambda: cpr.Limits(torque=-1.0),
    "curvature": lambda: cpr.Limits(curvature=np.nan),
    "legs` must have one rod at least that bends": lambda: robot(legs=[leg(rod=rod(k_b=np.inf))]),
    "uncertainty['l1']": lambda: robot(uncertainty={"l1": -1e-3}),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_named(name):
    with pytest.raises(InputError, match=r"^Argument") as raised:
        MISTAKES[name]()
    assert f"`{name.partition('`')[0]}`" in str(raised.value)
    assert "\n" not in str(raised.value)


def test_traced_numbers_are_known_by_their_shapes():
    """Their signs are not: a design may pass through them while it is optimised."""

    def stiffness(length):
        made = cpr.kirchhoff_rod(SPACE, length, [length, 2.0 * length, 1.0])
        return jnp.sum(1.0 / made.curvature_compliance) * made.length

    slope = jax.jit(jax.grad(stiffness))
    assert slope(-0.5) == pytest.approx(1.0 - 3.0)

    def shaped(numbers):
        return cpr.kirchhoff_rod(SPACE, 0.3, numbers).length

    with pytest.raises(InputError, match=r"`k_b` must have shape \(\) or \(3,\)"):
        jax.jit(shaped)(jnp.ones(2))
