"""All equilibria at a point, beside an independent solver."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cpr_jax as cpr
from cpr_jax.errors import InputError
from cpr_jax.robots.catalogue import rfrfr_straight, three_rfr
from cpr_jax.statics.residual import residual as residual_of
from cpr_jax.statics.solve import solve_inverse
from cpr_jax.statics.status import Status
from cpr_jax.statics.unknowns import unravel
from cpr_jax.studies.equilibria import (
    _principal,
    _within_half,
    _within_half_a_turn,
    find_equilibria,
)
from cpr_jax.studies.starts import recombined
from tests.oracles.planar_shooting import PlanarRobot, energy, inverse, residual

pytestmark = pytest.mark.optimised

POINT = (0.1, 0.8)

# Motor angles (rad) of the inverse solutions that MINPACK's hybrid method finds from 2,000 random
# starts with motors at any angle and dimensionless base wrenches up to 10, the last two of them
# from one and from three of the starts.
KNOWN = (
    (-0.1114, 2.9961),
    (2.5367, 0.2021),
    (-0.3682, 1.0014),
    (1.6256, -2.6967),
    (-0.7484, 0.8244),
    (1.9986, -2.2832),
)


@pytest.fixture(scope="module")
def robot():
    return rfrfr_straight()


@pytest.fixture(scope="module")
def found(robot):
    return find_equilibria(robot, POINT)


def straight():
    return PlanarRobot(
        l=(1.0, 1.0),
        a=(0.0, 0.0),
        b=(0.0, 0.0),
        d=0.4,
        k_b=(0.1570796327,) * 2,
        curvature=(0.0, 0.0),
        f_P=(0.0, 0.0),
    )


def test_all_that_random_starts_of_another_solver_find(found):
    for angles in KNOWN:
        gaps = np.max(np.abs(found.y[:, :2] - angles), axis=1)
        assert np.min(gaps) < 2e-4, angles


def test_each_is_an_equilibrium_with_its_energy_and_told_apart(found):
    for y, joule in zip(found.y, found.energy, strict=True):
        np.testing.assert_allclose(residual(straight(), y), 0.0, atol=1e-6)
        np.testing.assert_allclose(energy(straight(), y), joule, rtol=1e-7)
        np.testing.assert_allclose(y[2:4], POINT, atol=1e-12)
    assert np.all(np.diff(found.energy) > 0.0)
    gaps = np.max(np.abs(found.y[:, None] - found.y), axis=2)
    assert np.min(gaps[~np.eye(len(gaps), dtype=bool)]) > 1e-3
    assert np.all(found.hits >= 1)
    assert np.all(np.abs(found.y[:, :2]) <= np.pi)


def test_the_branch_of_the_robot_is_among_them_and_can_be_gone_on_with(robot, found):
    home = solve_inverse(robot, POINT)
    gaps = np.max(np.abs(found.y - np.asarray(home.y)), axis=1)
    k = int(np.argmin(gaps))
    assert gaps[k] < 1e-9
    again = found.equilibrium(robot, k)
    assert int(again.status) == Status.SOLVED
    np.testing.assert_allclose(again.y, home.y, rtol=0, atol=1e-9)


def test_forward_solutions(robot, found):
    """With the motors of one inverse solution held, that solution is found again."""
    y = found.y[2]
    forward = find_equilibria(robot, q_a=y[:2], starts=1024)
    gaps = np.max(np.abs(forward.y - y), axis=1)
    assert np.min(gaps) < 1e-9
    np.testing.assert_allclose(inverse(straight(), forward.y[0][2:4], forward.y[0]), forward.y[0])


def test_motors_beyond_half_a_turn_are_held_where_they_are(robot, found):
    y = np.array(found.y[2])
    y[0] += 2.0 * np.pi
    forward = find_equilibria(robot, q_a=y[:2], starts=1024)
    np.testing.assert_allclose(forward.y[:, :2], np.tile(y[:2], (len(forward.y), 1)), atol=1e-12)
    assert np.min(np.max(np.abs(forward.y - y), axis=1)) < 1e-9


def test_a_gear_changes_motors_and_nothing_else():
    """Behind a gear of two to one, a motor turns twice as far to the same configurations."""
    direct = cpr.rfrfr()
    twice = 2.0 * direct.home.q_a
    legs = dataclasses.replace(direct.legs, screw=0.5 * direct.legs.screw)
    geared = dataclasses.replace(
        direct, legs=legs, home=dataclasses.replace(direct.home, q_a=twice)
    )
    ones, others = (find_equilibria(r, (0.03, 0.2)) for r in (direct, geared))
    assert len(ones.y) == len(others.y)
    np.testing.assert_allclose(others.energy, ones.energy, rtol=1e-9)
    np.testing.assert_allclose(others.y[:, 2:], ones.y[:, 2:], atol=1e-7)
    turned = np.sin(others.y[:, :2] / 2.0 - ones.y[:, :2])
    np.testing.assert_allclose(turned, 0.0, atol=1e-7)


def test_the_branch_of_the_home_is_found_however_few_the_starts():
    """Two motors that put a body where they like, but not how it is turned; a leg has none."""
    three = three_rfr()
    turned = three.legs.base_rotation.at[2].add(three.home.q_a[2])
    body = dataclasses.replace(
        three,
        legs=dataclasses.replace(three.legs, base_rotation=turned),
        transmission=three.transmission[:, :2],
        home=dataclasses.replace(three.home, q_a=three.home.q_a[:2]),
    )
    point = np.asarray(three.home.q_p[:2]) + np.array([0.01, 0.02])
    found = find_equilibria(body, point, imposed=("y", "z"), starts=4)
    home = solve_inverse(body, point, imposed=("y", "z"))
    gaps = np.max(np.abs(found.y - np.asarray(home.y)), axis=1)
    assert np.min(gaps) < 1e-8
    assert found.unstable[np.argmin(gaps)] == 0


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({}, "point"),
        ({"point": (0.1, 0.8), "imposed": ("y", "x")}, "imposed"),
        ({"point": (0.0, 0.1), "q_a": (0.0, 0.1)}, "q_a"),
        ({"point": (0.0,)}, "point"),
        ({"point": (0.1, 0.8), "starts": 0}, "starts"),
        ({"point": (0.1, 0.8), "seed": 0.5}, "seed"),
        ({"point": (0.1, 0.8), "steps": True}, "steps"),
    ],
)
def test_mistakes_are_named(robot, options, field):
    with pytest.raises(InputError, match=f"`{field}`"):
        find_equilibria(robot, **options)


def test_half_a_period_has_one_sign():
    half = np.array([[np.pi - 1e-12], [-np.pi + 1e-12], [3.0 * np.pi]])
    np.testing.assert_allclose(_within_half(half, np.array([2.0 * np.pi])), np.pi, atol=1e-11)


@pytest.mark.parametrize("name", ["six_rus", "stewart_gough_clamped"])
def test_whole_turns_of_passive_joints_make_no_other_equilibrium(name):
    robot = getattr(cpr, name)()
    y = np.random.default_rng(0).uniform(-0.4, 0.4, robot.n_y)
    n_q, d, size = robot.n_a + robot.n_p, robot.geometry.d, robot.geometry.freedoms
    turned = y.copy()
    for leg, free in enumerate(np.asarray(robot.legs.base_joint.free)):
        turns = n_q + leg * size + d + np.flatnonzero(free[d:])
        turned[turns] += 2.0 * np.pi * (-1.0) ** leg
    rows, same = (residual_of(robot, unravel(robot, jnp.asarray(each))) for each in (y, turned))
    np.testing.assert_allclose(rows, same, rtol=0, atol=1e-9)
    back = _principal(robot, np.stack([y, turned]), range(robot.n_a))
    np.testing.assert_allclose(back[1], back[0], rtol=0, atol=1e-12)
    assert np.max(np.abs(turned - y)) > 6.0


def test_each_round_has_starts_of_its_own():
    """Otherwise what one round has found would count as found again."""
    robot = rfrfr_straight()
    y = np.random.default_rng(1).uniform(-1.0, 1.0, (3, robot.n_y))
    units = np.ones(robot.n_y)
    first, second, again = (recombined(robot, y, units, (0, k)) for k in (0, 1, 0))
    assert np.min(np.max(np.abs(first - second), axis=1)) > 1e-3
    np.testing.assert_array_equal(first, again)


@pytest.mark.parametrize("axes", [1, 3])
def test_half_a_turn_has_one_axis(axes):
    """As a robot has that is its own mirror image: rounding decides which of the two is found."""
    first = np.array([[1e-9, 2.9, 1.2]])[:, -axes:]
    for turn in (first / np.linalg.norm(first) * (np.pi + off) for off in (1e-12, 0.0, -1e-12)):
        for sign in (1.0, -1.0):
            found = _within_half_a_turn(sign * turn)
            np.testing.assert_allclose(found, np.pi * first / np.linalg.norm(first), atol=1e-9)


@pytest.mark.parametrize("axes", [1, 3])
def test_orientations_that_differ_by_whole_turns_are_the_same(axes):
    vectors = np.random.default_rng(0).normal(size=(20, axes)) * 5.0
    vectors[0] = 0.0
    found = _within_half_a_turn(vectors)
    assert np.max(np.linalg.norm(found, axis=1)) <= np.pi + 1e-12
    turned = (
        Rotation.from_rotvec(np.pad(v, ((0, 0), (3 - axes, 0)))).as_matrix()
        for v in (found, vectors)
    )
    np.testing.assert_allclose(*turned, atol=1e-12)
