"""Robots that are their own mirror images, and others that only look like it."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select
from cpr_jax.statics.problem import imposed_coordinates, imposed_rows
from cpr_jax.studies.follower import Follower
from cpr_jax.studies.grid import make_grid
from cpr_jax.studies.symmetry import is_mirror_symmetric


def judged(robot, imposed=None, names=None, box=None, target=None, delta=None, limits=None):
    """What a map of the robot would take it for."""
    target = robot.home.q_p if target is None else np.asarray(target)
    seed = cpr.solve_inverse(robot, target, imposed=imposed)
    begin = np.concatenate([seed.q_a, seed.q_p])
    grid = make_grid(robot, begin, None, box, names)
    places = imposed_coordinates(robot, imposed)
    follower = Follower(robot, imposed_rows(robot, places), grid.axes, 20)
    varied = () if delta is None else (select(robot, tuple(delta)), np.array([*delta.values()]))
    return is_mirror_symmetric(follower, seed, grid, places, *(varied or (None, None)), limits)


def held_body(f_P=(0.0, -0.3), k_b=(0.0183, 0.0183)):
    """Two mirrored cranks carry a body that slides along a third, which turns it."""
    low = [
        cpr.make_leg(
            cpr.PLANE,
            (side * 0.1, 0.0),
            cpr.kirchhoff_rod(cpr.PLANE, 0.25, k_b[k], 2.0 * side),
            attachment_position=(side * 0.03, 0.0),
        )
        for k, side in enumerate((-1.0, 1.0))
    ]
    high = cpr.make_leg(
        cpr.PLANE,
        (0.0, 0.45),
        cpr.kirchhoff_rod(cpr.PLANE, 0.2, 0.0183),
        base_rotation=(-np.pi / 2.0,),
        joint=cpr.slider(cpr.PLANE),
        attachment_position=(0.0, 0.03),
        attachment_rotation=(-np.pi / 2.0,),
    )
    home = ((2.48, 0.66, 0.0), (0.0, 0.2, 0.0))
    return cpr.make_robot(cpr.PLANE, [*low, high], oriented=True, f_P=f_P, home=home)


@pytest.fixture(scope="module")
def body():
    return held_body()


@pytest.mark.parametrize(
    ("change", "symmetric"),
    [
        ({}, True),
        ({"f_P": (0.0, -0.2)}, True),
        ({"f_P": (0.01, 0.0)}, False),
        ({"k_b": (0.0183, 0.0184)}, False),
        ({"r_c": (-0.5, 0.51)}, False),
    ],
)
def test_of_the_papers_robot(change, symmetric):
    assert judged(cpr.rfrfr(**change)) == symmetric


def test_of_a_body(body):
    assert judged(body)
    assert not judged(held_body(f_P=(0.01, -0.3)))
    assert not judged(held_body(k_b=(0.0183, 0.0184)))
    # A turn that is held is not mirrored; one that varies is.
    assert not judged(body, target=(0.0, 0.2, 0.05))
    assert judged(body, names=("y", "phi_P_x"), box=np.array([[-0.06, -0.3], [0.06, 0.3]]))
    # Half of a map is no half of the other side where that reaches further.
    assert not judged(body, box=np.array([[-0.02, 0.15], [0.06, 0.25]]))


def test_other_axes_than_the_mirrors(body):
    assert not judged(body, names=("z", "y"))
    assert not judged(body, names=("phi_P_x", "y"))


@pytest.mark.parametrize(
    ("delta", "symmetric"),
    [
        ({"k_b1": 1e-3, "k_b2": 1e-3}, True),
        ({"k_b1": 1e-3, "k_b2": 2e-3}, False),
        ({"k_b1": 1e-3, "r_c2": 1e-2}, False),
        ({"k_b1": 1e-3}, False),
        ({"k_b1": 0.0, "f_P_y": 0.1}, True),
        ({"base1_y": 1e-3, "base2_y": 1e-3, "base3_z": 1e-3}, True),
        ({"base3_z": 1e-3, "base1_z": 1e-3}, False),
    ],
    ids=str,
)
def test_ranges_are_mirrored_too(body, delta, symmetric):
    assert judged(body, delta=delta) == symmetric


def test_gears_are_mirrored_too():
    """Behind a gear a motor has another position and another torque."""
    robot = cpr.rfrfr()
    assert judged(robot)
    screw = robot.legs.screw.at[1].multiply(2.0)
    home = dataclasses.replace(robot.home, q_a=robot.home.q_a.at[1].divide(2.0))
    legs = dataclasses.replace(robot.legs, screw=screw)
    assert not judged(dataclasses.replace(robot, legs=legs, home=home))


def test_limits_of_motors_are_mirrored_where_motors_are(body):
    """Cranks stand at mirrored angles, sliding motors at equal positions."""
    limits = cpr.Limits(motors=(0.0, 3.0))
    assert not judged(body, limits=limits)
    assert judged(body, limits=cpr.Limits(torque=0.3))
    # The first two mirror each other, the third itself.
    assert judged(body, limits=cpr.Limits(torque=(0.3, 0.3, 0.4)))
    assert not judged(body, limits=cpr.Limits(torque=(0.3, 0.4, 0.4)))


def test_a_map_of_uneven_ranges_has_both_halves():
    """The half that a map of even ranges leaves out differs from the other one."""
    robot, labels = cpr.rfrfr(), ("k_b1", "r_c1")
    uneven = cpr.workspace_map(robot, spacing=0.06, parameters=labels)
    assert float(uneven.y[0]) < 0.0
    axes = uneven["semi_axis_max"].values
    both = np.isfinite(axes) & np.isfinite(axes[::-1])
    assert np.max(np.abs(axes / axes[::-1] - 1.0)[both]) > 0.1
    assert float(cpr.workspace_map(robot, spacing=0.06).y[0]) == 0.0


@pytest.mark.parametrize(("k_b", "symmetric"), [(0.0183, True), ((0.0183, 0.0184), False)])
def test_of_a_robot_in_space(k_b, symmetric):
    """Nothing imposes how far its platform is from the plane of its motors."""
    robot = cpr.in_space(cpr.rfrfr(k_b=k_b))
    assert judged(robot, imposed=("y", "z"), target=(0.0, 0.2)) == symmetric


def test_both_halves_of_a_map_agree(body):
    """The half that a map of a symmetric body leaves out, and moments about its mirror."""
    box = ((-0.05, 0.17), (0.05, 0.23))
    delta = {"k_b1": 1e-3, "k_b2": 1e-3}
    whole = cpr.workspace_map(
        body, spacing=0.025, box=box, parameters=list(delta), delta=delta, symmetry=False
    )
    solved = whole["status"].values == int(cpr.Status.SOLVED)
    np.testing.assert_array_equal(solved, solved[::-1])
    assert np.sum(solved) > 12
    for name in ("semi_axis_max", "energy"):
        values = whole[name].values
        np.testing.assert_allclose(values, values[::-1], rtol=1e-7)
    q_1, q_2 = (whole["q_a"].values[..., k] for k in range(2))
    np.testing.assert_allclose(q_1, np.pi - q_2[::-1], rtol=1e-9)


@pytest.mark.parametrize(("spin", "symmetric"), [(0.0, True), (np.pi / 4.0, False)])
def test_frames_of_round_rods_may_lie_anywhere(spin, symmetric):
    """Three upright rods of one kind, all as stiff in all directions; but what varies is not."""
    up = Rotation.from_rotvec([0.0, -np.pi / 2.0, 0.0]) * Rotation.from_rotvec([spin, 0.0, 0.0])
    rod = cpr.kirchhoff_rod(cpr.SPACE, 0.4, (0.1, 0.16, 0.16))

    def ring(radius, angle):
        return radius * np.cos(angle), radius * np.sin(angle), 0.0

    legs = [
        cpr.make_leg(
            cpr.SPACE,
            ring(0.1, angle),
            rod,
            base_rotation=up.as_rotvec(),
            feed=1.0,
            joint=cpr.spherical(cpr.SPACE),
            attachment_position=ring(0.06, angle),
        )
        for angle in np.deg2rad([0.0, 120.0, 240.0])
    ]
    load, home = ((0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), (np.zeros(3), (0.0, 0.0, 0.39, 0, 0, 0))
    robot = cpr.make_robot(cpr.SPACE, legs, oriented=True, loads=[load], home=home)
    needs = {"imposed": ("x", "y", "z"), "names": ("y", "x"), "target": (0.0, 0.0, 0.37)}
    assert judged(robot, **needs)
    assert judged(robot, delta={f"k_2{i}": 0.016 for i in (1, 2, 3)}, **needs) == symmetric
    assert judged(robot, delta={f"l{i}": 1e-3 for i in (1, 2, 3)}, **needs)
