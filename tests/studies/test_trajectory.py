"""Trajectories: every stop beside shooting, events beside where they must be."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import brentq

import cpr_jax as cpr
from cpr_jax.statics.status import Status
from tests.oracles.planar_shooting import PlanarRobot, forward, inverse, residual

DOWN = [(0.05, 0.2), (0.05, 0.02), (0.4, 0.2)]
"""Through a corner in the unstable zone, then out of reach."""


@pytest.fixture(scope="module")
def robot():
    return cpr.rfrfr()


@pytest.fixture(scope="module")
def down(robot):
    return cpr.trajectory(robot, DOWN, spacing=0.006)


def unknowns(dataset, k):
    stop = dataset.isel(s=k)
    return np.concatenate([stop["q_a"], stop["q_p"], stop["mu"].values.reshape(-1)])


def solved(dataset):
    return np.flatnonzero(dataset["index"].values >= 0)


def test_stops_are_on_the_path_at_most_a_spacing_apart(down):
    s, target = down["s"].values, down["target"].values
    assert np.max(np.diff(s)) <= 0.006 * (1.0 + 1e-12)
    np.testing.assert_allclose(np.linalg.norm(np.diff(target, axis=0), axis=1), np.diff(s))
    corners = target[down["waypoint"].values == 1]
    np.testing.assert_allclose(corners, DOWN, atol=1e-15)
    some = solved(down)
    np.testing.assert_allclose(down["q_p"].values[some], target[some], atol=1e-12)


def test_stops_are_equilibria_of_the_shooting_model_and_each_is_next_to_the_last(down):
    model = PlanarRobot()
    some = solved(down)
    for k in some[::9]:
        np.testing.assert_allclose(residual(model, unknowns(down, k)), 0.0, atol=1e-7)
    # From the stop before it, shooting finds the same one.
    for k in some[1::13]:
        found = inverse(model, down["target"].values[k], unknowns(down, k - 1))
        np.testing.assert_allclose(found, unknowns(down, k), rtol=0, atol=1e-6)


def test_it_becomes_unstable_where_the_forward_problem_is_singular(down):
    """Both places beside a root of `det ∂R/∂(q_p, μ)` by shooting and differences."""
    model, s = PlanarRobot(), down["s"].values
    happened = cpr.events(down)
    assert [event["event"] for event in happened] == ["unstable", "stable", "end"]

    def determinant(x, k):
        share = (x - s[k]) / (s[k + 1] - s[k])
        targets = down["target"].values
        y = inverse(model, (1.0 - share) * targets[k] + share * targets[k + 1], unknowns(down, k))
        h = 1e-5 * np.array([0.1, 0.1, 1.0, 1.0, 0.1, 1.0, 1.0, 0.1])
        columns = [
            (residual(model, y + step) - residual(model, y - step)) / (2.0 * np.max(step))
            for step in np.eye(10)[2:] * h[:, None]
        ]
        return np.linalg.det(columns)

    for event in happened[:2]:
        k = int(np.searchsorted(s, event["s"])) - 1
        root = brentq(determinant, s[k], s[k + 1], args=(k,), xtol=1e-9)
        assert event["s"] == pytest.approx(root, abs=3e-6)


def test_nothing_is_missed_between_stops_far_apart(robot, down):
    """Waypoints alone are returned, and what happens between them is that of closer stops."""
    for spacing in (np.inf, 1.0, 0.03):
        coarse = cpr.trajectory(robot, DOWN, spacing=spacing)
        found, expected = cpr.events(coarse), cpr.events(down)
        assert [one["event"] for one in found] == [one["event"] for one in expected]
        for one, other in zip(found, expected, strict=True):
            assert one["s"] == pytest.approx(other["s"], abs=3e-6)
    alone = cpr.trajectory(robot, DOWN, spacing=np.inf)
    np.testing.assert_allclose(alone["target"], DOWN)
    np.testing.assert_array_equal(alone["status"], [0, 0, Status.OUT_OF_REACH])
    np.testing.assert_allclose(unknowns(alone, 1), unknowns(down, 30), rtol=0, atol=1e-8)


def test_events_beside_the_end_are_found_whatever_the_spacing(robot):
    """The third one is less than a usual distance from where the branch folds back."""
    path = [(0.05, 0.2), (0.05, -0.4)]
    coarse, fine = (cpr.trajectory(robot, path, spacing=h) for h in (None, 0.001))
    names = ["unstable", "stable", "unstable", "end"]
    for one, other, name in zip(cpr.events(coarse), cpr.events(fine), names, strict=True):
        assert one["event"] == other["event"] == name
        assert one["s"] == pytest.approx(other["s"], abs=2e-5)
        assert one.get("status") == other.get("status")


def test_a_smaller_robot_has_its_stops_closer_together():
    """A tenth in size and a hundredth in stiffness: the same shapes, forces and stops."""
    small = cpr.rfrfr(l=0.025, a=0.0045, b=0.0035, d=0.02, k_b=1.83e-4, r_c=(-0.1, 0.1))
    home = cpr.Home(small.home.q_a, 0.1 * np.asarray(small.home.q_p))
    small = dataclasses.replace(small, home=home)
    ends = np.array([(0.0, 0.06), (0.13, -0.05)])
    usual = cpr.trajectory(cpr.rfrfr(), ends)
    tenth = cpr.trajectory(small, 0.1 * ends)
    assert usual.sizes["s"] == tenth.sizes["s"] == 70
    for one, other in zip(cpr.events(usual), cpr.events(tenth), strict=True):
        assert (one["event"], one["index"]) == (other["event"], other["index"])
        assert 0.1 * one["s"] == pytest.approx(other["s"], rel=1e-6)


def test_behind_its_end_there_is_one_reason(robot):
    """Though what is behind it is within reach again."""
    path = cpr.trajectory(robot, [(0.0, 0.2), (0.4, 0.2), (0.0, 0.2)], spacing=0.02)
    (end,) = cpr.events(path)
    behind = path["status"].values[path["s"].values > end["s"]]
    assert end["status"] == "out_of_reach" and set(behind) == {int(Status.OUT_OF_REACH)}


def test_it_ends_where_a_leg_is_straight(down):
    """A tenth of a millimetre before, as its tension grows without bound there."""
    end = cpr.events(down)[-1]
    assert (end["status"], end["s"]) == ("out_of_reach", down.attrs["reached"])
    begin, goal = (np.array(point) for point in DOWN[1:])
    along = (goal - begin) / np.linalg.norm(goal - begin)
    length = 0.045 + 0.25 + 0.035

    def too_far(x):
        return np.hypot(*(begin + x * along - (-0.1, 0.0))) - length

    straight = brentq(too_far, 0.0, 1.0) + 0.18
    assert straight - 1e-4 < end["s"] < straight
    beyond = down["s"].values > straight
    assert np.all(down["status"].values[beyond] == Status.OUT_OF_REACH)
    assert np.all(np.isnan(down["q_a"].values[beyond]))
    assert np.all(down["stable"].values[beyond] == 0)


def test_sensitivities_are_those_of_single_solves(robot, down):
    for k in (0, 20, len(solved(down)) - 5):
        here = cpr.solve_inverse(robot, down["target"].values[k])
        np.testing.assert_allclose(here.y, unknowns(down, k), rtol=0, atol=1e-8)
        analysed = cpr.sensitivity(robot, here)
        np.testing.assert_allclose(down["Pi_p"].values[k], analysed.Pi_p, rtol=1e-6)
        axes = np.asarray(cpr.ellipsoid(analysed).semi_axes)
        np.testing.assert_allclose(down["semi_axis_max"].values[k], axes[0], rtol=1e-6)
        np.testing.assert_allclose(
            down["motor_torque"].values[k], here.motor_torques, rtol=0, atol=1e-8
        )


def test_a_circle_closes_and_its_motors_lead_the_platform_around_it(robot):
    angle = np.linspace(0.0, 2.0 * np.pi, 41)
    circle = np.stack([0.04 * np.cos(angle), 0.2 + 0.04 * np.sin(angle)], axis=1)
    there = cpr.trajectory(robot, circle, spacing=1.0)
    assert there.sizes["s"] == 41 and cpr.events(there) == []
    np.testing.assert_allclose(unknowns(there, 40), unknowns(there, 0), rtol=0, atol=1e-9)
    seed = cpr.solve_inverse(robot, circle[0])
    motors = there["q_a"].values
    back = cpr.trajectory(robot, motors, seed, imposed=("q1", "q2"), spacing=1.0)
    assert (back["s"].attrs["units"], back.sizes["s"]) == ("rad", 41)
    np.testing.assert_allclose(back["q_p"].values, circle, rtol=0, atol=1e-9)


def test_motors_end_at_a_fold_from_which_shooting_finds_no_way_on(robot):
    """The platform is led to where its stiffness vanishes: beyond there is nothing near."""
    held = cpr.solve_inverse(robot, (0.05, 0.06))
    fold = cpr.trajectory(robot, [(0.05, 0.06), (0.05, 0.026)], held, spacing=0.002)
    motors = fold["q_a"].values
    on = motors[-1] + 4.0 * (motors[-1] - motors[-2])
    path = cpr.trajectory(robot, [*motors[::4], on], held, imposed=("q1", "q2"), spacing=0.01)
    end = cpr.events(path)[-1]
    assert end["event"] == "end" and end["status"] == "beyond_fold"
    last = len(solved(path)) - 1
    assert path["s"].values[last] < end["s"] < path["s"].values[last + 1]
    assert path["sigma_t2"].values[last] < 0.3 * path["sigma_t2"].values[0]
    y = unknowns(path, last)
    with pytest.raises(RuntimeError, match="found no equilibrium"):
        forward(PlanarRobot(), path["target"].values[last + 2], y)


def test_a_body_turns_and_a_radian_counts_as_the_length_of_a_rod():
    robot = cpr.three_rfr()
    home = cpr.solve_inverse(robot, robot.home.q_p)
    begin = np.asarray(home.q_p)
    turned = cpr.trajectory(robot, [begin, begin + np.array([0.0, 0.0, 0.3])], home, spacing=0.02)
    length = float(np.mean(robot.legs.rod.length))
    assert float(turned["s"][-1]) == pytest.approx(0.3 * length)
    assert turned["s"].attrs["units"] == "m"
    for k in (0, 3, turned.sizes["s"] - 1):
        alone = cpr.solve_inverse(robot, turned["target"].values[k])
        np.testing.assert_allclose(unknowns(turned, k), alone.y, rtol=0, atol=1e-8)
        axes = cpr.ellipsoid(cpr.sensitivity(robot, alone)).semi_axes
        np.testing.assert_allclose(turned["semi_axis_max"].values[k], axes[0], rtol=1e-6)


def test_limits_are_events_and_keep_their_numbers(robot, down):
    torque = np.max(np.abs(down["motor_torque"].values), axis=1)
    most = 0.5 * (torque[0] + np.nanmax(torque))
    limited = cpr.trajectory(robot, DOWN[:2], spacing=0.006, limits=cpr.Limits(torque=float(most)))
    names = [event["event"] for event in cpr.events(limited)]
    assert names == ["beyond limits", "within limits", "unstable"]
    for event in cpr.events(limited)[:2]:
        at = np.interp(event["s"], limited["s"], np.max(np.abs(limited["motor_torque"]), axis=1))
        assert at == pytest.approx(most, rel=2e-3)
    beyond = limited["status"].values == Status.BEYOND_LIMITS
    np.testing.assert_array_equal(
        beyond, np.max(np.abs(limited["motor_torque"].values), axis=1) > most
    )
    assert np.all(np.isfinite(limited["semi_axis_max"]))


def test_a_robot_without_uncertainties_has_a_trajectory():
    certain = dataclasses.replace(cpr.rfrfr(), uncertainty={})
    dataset = cpr.trajectory(certain, [(0.0, 0.2), (0.02, 0.2)])
    assert "semi_axis_max" not in dataset and np.all(dataset["stable"].values == 1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"waypoints": [(0.0, 0.2)]}, "`waypoints` must be at least 2 rows of 2 numbers"),
        ({"waypoints": (0.0, 0.2)}, "`waypoints` must be at least 2 rows"),
        ({"waypoints": [(0.0, 0.2, 0.1)] * 2}, "`waypoints` must be at least 2 rows"),
        ({"waypoints": "here"}, "`waypoints` must be at least 2 rows"),
        ({"waypoints": [(0.0, 0.2), (0.0, np.nan)]}, "`waypoints` must be finite"),
        ({"waypoints": [(0.0, 0.2), (0.0, 0.2)]}, "`waypoints` must be different points"),
        ({"spacing": 0.0}, "`spacing` must be positive"),
        ({"spacing": 1e-9}, "`spacing` must leave at most"),
        ({"imposed": ("x", "z")}, "`imposed` must name coordinates"),
        ({"limits": 3.0}, "`limits` must be `Limits`"),
        ({"seed": "home"}, "`seed` must be an Equilibrium"),
        ({"steps": 0}, "`steps` must be a positive integer"),
    ],
)
def test_mistakes_are_named(robot, arguments, message):
    with pytest.raises(ValueError, match=message):
        cpr.trajectory(robot, **{"waypoints": [(0.0, 0.2), (0.02, 0.2)], **arguments})


def test_a_name_is_no_robot():
    with pytest.raises(ValueError, match="`robot` must be a Robot"):
        cpr.trajectory("rfrfr", [(0.0, 0.2), (0.02, 0.2)])


def test_what_is_not_solved_well_enough_is_no_solution(robot, monkeypatch):
    """As in a map: no stop of which the residual is above the tolerance has numbers."""
    monkeypatch.setattr("cpr_jax.studies.trajectory.TOLERANCE", 1e-30)
    path = cpr.trajectory(robot, [(0.0, 0.2), (0.02, 0.2)])
    assert set(path["status"].values) == {int(Status.NOT_CONVERGED)}
    assert np.all(path["index"].values == -1) and np.all(np.isnan(path["q_a"].values))


def test_a_first_waypoint_out_of_reach_is_a_solve_without_a_solution(robot):
    with pytest.raises(cpr.SolveError) as caught:
        cpr.trajectory(robot, [(0.0, 0.5), (0.0, 0.2)])
    assert caught.value.status == Status.OUT_OF_REACH
