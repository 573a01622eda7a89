"""What a wrong call is told, and what a call without a solution returns."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE
from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.rods.segments import segmented_rod
from cpr_jax.statics.solve import solve_forward, solve_inverse
from cpr_jax.statics.status import SolveError, Status

NOT_TWO_NUMBERS = {
    "three numbers": (0.0, 0.2, 0.1),
    "one number": 0.2,
    "a column": np.zeros((2, 1)),
    "nothing": (),
    "text": "0, 0.2",
    "a list of text": ["0", "0.2"],
    "None": None,
    "ragged": [[0.0, 0.2], [0.1]],
    "complex": np.array([0.0, 0.2j]),
    "logical": np.array([True, False]),
    "not a number": (np.nan, 0.2),
    "infinite": (0.0, np.inf),
    "float32": jnp.array([0.0, 0.2], jnp.float32),
    "float32 of numpy": np.array([0.0, 0.2], np.float32),
}


@pytest.mark.parametrize("value", NOT_TWO_NUMBERS.values(), ids=NOT_TWO_NUMBERS)
@pytest.mark.parametrize(
    ("solve", "name"),
    [(solve_inverse, "point"), (solve_forward, "q_a")],
    ids=["inverse", "forward"],
)
def test_a_wrong_target_is_named(paper, solve, name, value):
    with pytest.raises(InputError, match=f"`{name}` must") as caught:
        solve(paper, value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "target", [[0.0, 0.2], (0, 0.2), np.array([0.0, 0.2]), jnp.array([0.0, 0.2])]
)
def test_any_pair_of_numbers_will_do(paper, nominal, target):
    np.testing.assert_array_equal(solve_inverse(paper, target).y, nominal.y)


def test_a_robot_in_float32_is_refused(paper):
    single = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), paper)
    with pytest.raises(InputError, match=r"`robot` must hold float64.*jax_enable_x64"):
        solve_inverse(single, (0.0, 0.2))


@pytest.mark.parametrize("part", ["rods", "segments"])
def test_a_robot_made_of_float32_parts_is_refused(part):
    """Described before float64 was enabled, put together after it."""
    single = jax.tree.map(
        lambda leaf: leaf.astype(jnp.float32), kirchhoff_rod(PLANE, 0.25, 0.0183, 2.0)
    )
    rod = single if part == "rods" else segmented_rod([single, single])
    legs = [make_leg(PLANE, (side, 0.0), rod) for side in (-0.1, 0.1)]
    robot = make_robot(PLANE, legs, oriented=False, home=((2.7, 0.44), (0.0, 0.2)))
    with pytest.raises(InputError, match="float32"):
        solve_inverse(robot, (0.0, 0.2))
    assert robot.leg(0).rod.length.dtype == jnp.float32


@pytest.mark.parametrize("robot", [None, "rfrfr", {"name": "rfrfr"}], ids=repr)
def test_what_is_no_robot_is_refused(robot):
    with pytest.raises(ValueError, match="`robot` must"):
        solve_inverse(robot, (0.0, 0.2))


def test_an_inverse_problem_needs_a_motor_for_each_coordinate():
    """A point driven by three motors cannot have all its coordinates imposed alone."""
    robot = dataclasses.replace(three_rfr(), oriented=False)
    with pytest.raises(ValueError, match=r"3 motors cannot impose 2 .*: name 1 of the motors"):
        solve_inverse(robot, (0.0, 0.0))


def test_names_of_coordinates_are_a_list(paper):
    with pytest.raises(InputError, match="`imposed` must be a list of names, but it is 'yz'"):
        solve_inverse(paper, (0.0, 0.2), imposed="yz")
    with pytest.raises(InputError, match=r"`imposed` must name 2 different .* are the same"):
        solve_inverse(paper, (0.0, 0.2), imposed=("y", "p_P_y"))


def test_a_robot_without_home_cannot_be_searched_in_a_transformation(paper):
    robot = dataclasses.replace(paper, home=None)
    with pytest.raises(InputError, match="`robot` must have a home"):
        jax.jit(lambda point: solve_inverse(robot, point).y)(jnp.array([0.0, 0.2]))


@pytest.mark.parametrize("steps", [0, -3, 2.5, "10", (10,)], ids=repr)
def test_wrong_steps_are_named(paper, steps):
    with pytest.raises(ValueError, match="`steps` must"):
        solve_inverse(paper, (0.0, 0.2), steps=steps)


@pytest.mark.parametrize(
    "guess", ["home", (2.7, 0.4), np.zeros(10)], ids=["text", "tuple", "array"]
)
def test_a_guess_that_is_no_equilibrium_is_named(paper, guess):
    with pytest.raises(ValueError, match="`guess` must"):
        solve_inverse(paper, (0.0, 0.2), guess=guess)


def test_a_guess_of_another_robot_is_named(paper, nominal):
    other = dataclasses.replace(nominal, q_a=jnp.zeros(3), q_p=jnp.zeros(3), mu=jnp.zeros((3, 3)))
    with pytest.raises(ValueError, match="`guess` must"):
        solve_inverse(paper, (0.0, 0.2), guess=other)


def test_a_batch_of_equilibria_is_no_guess(paper, nominal):
    batch = jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), nominal)
    with pytest.raises(ValueError, match=r"`guess` must be one equilibrium, but it is a batch"):
        solve_inverse(paper, (0.0, 0.2), guess=batch)


def test_a_point_out_of_reach_raises_with_its_status(paper):
    with pytest.raises(SolveError, match="RFRFR") as caught:
        solve_inverse(paper, (0.0, 0.6))
    assert caught.value.status is Status.OUT_OF_REACH


def test_within_a_transformation_such_a_point_is_where_the_branch_is_lost(paper):
    """Nothing is known of the numbers there but by following the branch."""
    status = jax.jit(lambda point: solve_inverse(paper, point).status)(jnp.array([0.0, 0.6]))
    assert int(status) == Status.LOST


def test_motor_angles_in_degrees_are_hinted_at(paper):
    with pytest.raises(SolveError, match="radians"):
        cpr.solve_forward(paper, (155.0, 25.0))
    with pytest.raises(SolveError) as caught:
        cpr.solve_inverse(paper, (0.0, 0.6))
    assert "radians" not in str(caught.value)


def test_positions_in_millimetres_are_hinted_at(paper):
    with pytest.raises(SolveError, match=r"metres.*rods are 0.25 m long") as caught:
        cpr.solve_inverse(paper, (0.0, 200.0))
    assert caught.value.hint.startswith("Positions are in metres")
    assert int(caught.value.equilibrium.status) == Status.OUT_OF_REACH
    with pytest.raises(SolveError) as caught:
        cpr.solve_inverse(paper, (0.0, 0.6))
    assert caught.value.hint == ""


def test_a_home_that_cannot_be_assembled_says_so():
    """Its rods do not reach the platform from any motor position."""
    robot = cpr.three_rfr()
    robot = eqx.tree_at(lambda r: r.legs.rod.length, robot, 0.3 * robot.legs.rod.length)
    with pytest.raises(SolveError, match="assembled at its home") as caught:
        cpr.solve_forward(robot, robot.home.q_a)
    assert caught.value.status is Status.NOT_ASSEMBLED


def test_without_raising_the_status_tells_and_nothing_looks_like_a_solution(paper):
    found = solve_inverse(paper, (0.0, 0.6), throw=False)
    assert int(found.status) == Status.OUT_OF_REACH
    assert np.all(np.isnan(found.y)) and np.isnan(found.residual)
    assert all(np.all(np.isnan(leaf)) for leaf in jax.tree.leaves(found.measures))


def test_a_failed_guess_leads_nowhere(paper):
    failed = solve_inverse(paper, (0.0, 0.6), throw=False)
    found = solve_inverse(paper, (0.0, 0.2), guess=failed, throw=False)
    assert int(found.status) == Status.NOT_FINITE
    with pytest.raises(SolveError, match="`guess` is not solved itself: OUT_OF_REACH"):
        solve_inverse(paper, (0.0, 0.2), guess=failed)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_of_a_robot_that_are_not_finite(paper, value):
    """As a lane of a batch may have them: no exception but that of a failed solve."""
    robot = eqx.tree_at(lambda r: r.legs.rod.length, paper, jnp.array([0.25, value]))
    with pytest.raises(SolveError) as caught:
        solve_inverse(robot, (0.0, 0.2))
    assert caught.value.status is Status.NOT_FINITE
    assert np.all(np.isnan(solve_inverse(robot, (0.0, 0.2), throw=False).y))
