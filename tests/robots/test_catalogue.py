"""The robots that papers name, and how robots are put together."""

import dataclasses
import importlib
import json
import pathlib
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.analysis.stability import stability
from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.robots.catalogue import rfrfr, rfrfr_straight, three_pfr, three_rfr
from cpr_jax.robots.embedding import in_space
from cpr_jax.robots.joint import clamped, pivot, slider, spherical
from cpr_jax.robots.leg import make_leg, prismatic_screw, revolute_screw
from cpr_jax.robots.names import CATALOGUE
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.statics.solve import solve_forward, solve_inverse
from cpr_jax.statics.unknowns import unknown_units

CASES = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())
MAKERS = [rfrfr, rfrfr_straight, three_rfr, three_pfr]


def test_table_1():
    """The defaults are the paper's robot, in SI units."""
    case, robot = CASES["rfrfr_paper"]["robot"], rfrfr()
    rod = robot.legs.rod
    np.testing.assert_allclose(robot.legs.base_position, case["motors"])
    np.testing.assert_allclose(rod.length, case["l"])
    np.testing.assert_allclose(robot.legs.a, [[case["a"], 0.0]] * 2)
    np.testing.assert_allclose(robot.legs.b, [[case["b"], 0.0]] * 2)
    np.testing.assert_allclose(1.0 / rod.curvature_compliance[:, 0], case["k_b"])
    np.testing.assert_allclose(1.0 / rod.precurvature[:, 0], case["r_c"])
    np.testing.assert_allclose(robot.f_P, case["f_P"])
    delta = CASES["rfrfr_paper"]["delta"]
    for i in (1, 2):
        assert float(robot.uncertainty[f"k_b{i}"]) == delta["k_b"]
        assert float(robot.uncertainty[f"r_c{i}"]) == delta["r_c"]


def test_the_straight_robot():
    case, robot = CASES["rfrfr_straight"]["robot"], rfrfr_straight()
    np.testing.assert_allclose(robot.legs.base_position, case["motors"])
    np.testing.assert_allclose(robot.legs.rod.length, case["l"])
    np.testing.assert_allclose(1.0 / robot.legs.rod.curvature_compliance, case["k_b"])
    for zero in (robot.legs.a, robot.legs.b, robot.legs.rod.precurvature):
        np.testing.assert_array_equal(zero, 0.0)
    # Rods of 1 mm radius and 200 GPa.
    assert case["k_b"] == pytest.approx(200e9 * np.pi * 1e-12 / 4.0, rel=1e-9)


@pytest.mark.parametrize("printed", [False, True])
def test_the_choice_of_the_moment_row(printed):
    np.testing.assert_array_equal(rfrfr(printed_moment_row=printed).legs.joint.lever, not printed)


@pytest.mark.parametrize("make", MAKERS)
def test_numbers_are_strong_float64(make):
    """What differs in type alone would compile every program again."""
    for path, leaf in jax.tree_util.tree_leaves_with_path(make()):
        name = jax.tree_util.keystr(path)
        assert leaf.dtype == jnp.float64, name
        assert not leaf.weak_type, name


@pytest.mark.parametrize(
    ("make", "n", "n_p", "n_y"),
    [(rfrfr, 2, 2, 10), (rfrfr_straight, 2, 2, 10), (three_rfr, 3, 3, 15)],
)
def test_counts(make, n, n_p, n_y):
    robot = make()
    assert (robot.n, robot.n_a, robot.n_p, robot.n_y) == (n, n, n_p, n_y)
    spatial = in_space(robot)
    assert spatial.geometry == SPACE
    assert spatial.n_y == n + (6 if robot.oriented else 3) + 6 * n


def test_home_of_the_3_rfr_is_on_a_branch_and_solves_both_problems():
    """The home of a robot is a rough configuration: its platform is where its motors put it."""
    robot = three_rfr()
    forward = solve_forward(robot, robot.home.q_a)
    np.testing.assert_allclose(forward.q_p, robot.home.q_p, rtol=0, atol=0.1)
    inverse = solve_inverse(robot, robot.home.q_p)
    np.testing.assert_allclose(inverse.q_a, robot.home.q_a, rtol=0, atol=0.1)
    back = solve_forward(robot, inverse.q_a)
    np.testing.assert_allclose(back.q_p, robot.home.q_p, rtol=0, atol=1e-10)


def test_the_3_rfr_is_symmetric_but_for_its_load():
    """Turned by 120°, each leg takes the place of the next one; unloaded, so do the motors."""
    robot = three_rfr()
    third = 2.0 * np.pi / 3.0
    turn = np.array([[np.cos(third), -np.sin(third)], [np.sin(third), np.cos(third)]])
    for place in (robot.legs.base_position, robot.legs.attachment_position):
        np.testing.assert_allclose(place @ turn.T, np.roll(place, -1, axis=0), rtol=0, atol=1e-15)
    unloaded = dataclasses.replace(robot, f_P=jnp.zeros(2))
    solved = solve_inverse(unloaded, robot.home.q_p)
    steps = np.diff(np.asarray(solved.q_a)) - third
    np.testing.assert_allclose(np.sin(steps), 0.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(solved.mu[:, 2], solved.mu[0, 2], rtol=0, atol=1e-9)


def test_the_3_pfr_is_stable_at_home_and_far_from_singularities():
    """Its rods are nearly at rest there; turned by 120°, each leg takes the place of the next."""
    robot = three_pfr()
    forward = solve_forward(robot, robot.home.q_a)
    np.testing.assert_allclose(forward.q_p, robot.home.q_p, rtol=0, atol=2e-3)
    assert int(stability(robot, forward).index) == 0
    assert float(forward.measures.sigma_t2) > 0.1
    assert np.max(np.abs(forward.mu[:, 2])) < 0.2 * 0.0183 * 2.0
    inverse = solve_inverse(robot, robot.home.q_p)
    np.testing.assert_allclose(inverse.q_a, robot.home.q_a, rtol=0, atol=1e-3)
    third = 2.0 * np.pi / 3.0
    turn = np.array([[np.cos(third), -np.sin(third)], [np.sin(third), np.cos(third)]])
    for place in (robot.legs.base_position, robot.legs.attachment_position):
        np.testing.assert_allclose(place @ turn.T, np.roll(place, -1, axis=0), rtol=0, atol=1e-15)


@pytest.mark.parametrize("entry", CATALOGUE.values(), ids=lambda entry: entry.name)
def test_the_table_of_contents_is_what_the_functions_make(entry):
    module = importlib.import_module(f"cpr_jax.robots.{entry.module}")
    robot = getattr(module, entry.function)()
    assert CATALOGUE[entry.name] is entry
    assert robot.geometry.name == entry.geometry
    assert robot.oriented == (entry.platform == "body")
    # Each leg has its motor, which does one thing and nothing else.
    np.testing.assert_array_equal(robot.transmission, np.eye(len(entry.motors)))
    slide, turn = np.split(np.asarray(robot.legs.screw), [robot.geometry.d], axis=1)
    feed = np.zeros(robot.n) if robot.legs.feed is None else np.asarray(robot.legs.feed)
    assert robot.legs.stroke is None
    moves = {
        "prismatic": np.any(slide, axis=1),
        "revolute": np.any(turn, axis=1),
        "feed": feed != 0.0,
    }
    for kind, does in moves.items():
        assert [kind == motor for motor in entry.motors] == does.tolist()
    units = unknown_units(robot)[: robot.n_a]
    assert units == tuple("rad" if turns else "m" for turns in entry.turning)


def test_leg_of_a_robot():
    robot = three_rfr()
    leg = robot.leg(1)
    np.testing.assert_array_equal(leg.base_position, robot.legs.base_position[1])
    assert leg.rod.length.shape == ()


def test_defaults_of_a_leg():
    leg = make_leg(PLANE, (0.1, 0.2), kirchhoff_rod(PLANE, 1.0, 1.0), a=0.3, b=(0.1, 0.2))
    np.testing.assert_array_equal(leg.a, [0.3, 0.0])
    np.testing.assert_array_equal(leg.b, [0.1, 0.2])
    np.testing.assert_array_equal(leg.screw, [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(leg.joint.free, [0.0, 0.0, 1.0])
    assert leg.feed is None


def test_screws_of_motors():
    np.testing.assert_array_equal(revolute_screw(SPACE), [0, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(prismatic_screw(SPACE), [1, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(prismatic_screw(PLANE, axis=1), [0, 1, 0])


def test_what_joints_leave_free():
    np.testing.assert_array_equal(pivot(SPACE).free, [0, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(spherical(SPACE).free, [0, 0, 0, 1, 1, 1])
    np.testing.assert_array_equal(spherical(PLANE).free, pivot(PLANE).free)
    np.testing.assert_array_equal(clamped(SPACE).free, np.zeros(6))
    np.testing.assert_array_equal(slider(PLANE).free, [1, 0, 0])
    np.testing.assert_array_equal(slider(SPACE, axis=2).free, [0, 0, 1, 0, 0, 0])


def test_an_effect_of_one_leg_is_a_zero_for_the_others():
    """Legs may differ in everything; stacking fills what one of them lacks."""
    plain = make_leg(PLANE, (-0.1, 0.0), kirchhoff_rod(PLANE, 1.0, 1.0))
    heavy = make_leg(PLANE, (0.1, 0.0), kirchhoff_rod(PLANE, 2.0, 3.0, force=(0.0, -1.0)), feed=1.0)
    robot = make_robot(PLANE, [plain, heavy], oriented=False)
    np.testing.assert_array_equal(robot.legs.rod.force, [[0.0, 0.0], [0.0, -1.0]])
    np.testing.assert_array_equal(robot.legs.feed, [0.0, 1.0])
    np.testing.assert_array_equal(robot.legs.rod.length, [1.0, 2.0])
    assert robot.legs.rod.moment is None
    np.testing.assert_array_equal(robot.f_P, 0.0)
    np.testing.assert_array_equal(robot.transmission, np.eye(2))


def test_a_robot_needs_legs():
    with pytest.raises(InputError, match="`legs` must"):
        make_robot(PLANE, [], oriented=False)


def test_a_point_carries_one_force():
    leg = make_leg(PLANE, (0.1, 0.0), kirchhoff_rod(PLANE, 1.0, 1.0))
    with pytest.raises(InputError, match="`loads` must"):
        make_robot(PLANE, [leg], oriented=False, loads=[((0.0, 0.0), (0.0, 1.0))])


def test_every_number_of_a_robot_is_a_leaf():
    """Static fields hold no arrays: two robots of one structure differ in leaves alone."""
    first, second = (jax.tree.structure(rfrfr(l=length)) for length in (0.25, 0.3))
    assert first == second
    leaves = jax.tree.leaves(rfrfr())
    assert all(isinstance(leaf, jax.Array) for leaf in leaves)


def test_a_planar_robot_in_space_keeps_its_plane():
    """The tangent at q = 0 points along y, the pivots' axes along x."""
    spatial = in_space(three_rfr())
    for vector in spatial.legs.base_rotation:
        rows = SPACE.rows(SPACE.exp(tuple(vector)))
        columns = [np.asarray(jnp.stack(SPACE.rotate(rows, axis))) for axis in np.eye(3)]
        np.testing.assert_allclose(columns, [[0, 1, 0], [0, 0, 1], [1, 0, 0]], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(spatial.legs.base_position[:, 0], 0.0)
    np.testing.assert_array_equal(spatial.f_P, [0.0, 0.0, -0.5])


DESCRIBED = """
import importlib, pathlib, sys
import jax
jax.config.update("jax_enable_x64", True)
compiled = []
def listen(event, seconds, **about):
    if event.endswith("backend_compile_duration"):
        compiled.append(about.get("fun_name"))
jax.monitoring.register_event_duration_secs_listener(listen)
import cpr_jax as cpr
from cpr_jax.robots.names import CATALOGUE
for entry in CATALOGUE.values():
    getattr(importlib.import_module(f"cpr_jax.robots.{entry.module}"), entry.function)()
for file in sorted(pathlib.Path(sys.argv[1]).glob("*.toml")):
    cpr.load_robot(file)
print(compiled)
jax.numpy.ones(3) + 1.0
print(len(compiled) > 0)
"""


def test_to_describe_a_robot_compiles_nothing():
    """An operation of JAX outside of a program is compiled by itself, shape by shape."""
    examples = pathlib.Path(__file__).parents[2] / "examples"
    command = [sys.executable, "-c", DESCRIBED, str(examples)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[]", "True"]
