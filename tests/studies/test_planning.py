"""Planned paths beside straight lines, the law of refraction, and what they must keep off."""

import json

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import minimize_scalar

import cpr_jax as cpr
from cpr_jax.statics.status import Status

Y, Z = 0.01 * np.arange(61), 0.01 * np.arange(41)


def made_up(cost, **changed):
    """A map over y and z with a cost, all of it open."""
    shape = (len(Y), len(Z))
    over = ("y", "z")
    variables = {
        "status": (over, np.zeros(shape, int)),
        "stable": (over, np.ones(shape, int)),
        "seam": (over, np.zeros(shape, int)),
        "semi_axis_max": (over, np.broadcast_to(cost, shape).astype(float)),
    }
    variables |= {name: (over, values) for name, values in changed.items()}
    return xr.Dataset(
        variables,
        coords={
            "y": ("y", Y, {"units": "m"}),
            "z": ("z", Z, {"units": "m"}),
            "motor": ["q1", "q2"],
            "coordinate": ["p_P_y", "p_P_z"],
        },
        attrs={"imposed": json.dumps(["p_P_y", "p_P_z"]), "held": "{}"},
    )


@pytest.mark.parametrize("goal", [(0.6, 0.4), (0.57, 0.031), (0.0, 0.4), (0.3, 0.0)])
def test_at_one_cost_it_is_the_straight_line(goal):
    way = cpr.plan_path(made_up(2.5), (0.0, 0.0), goal)
    np.testing.assert_allclose(way.points, [(0.0, 0.0), goal], atol=1e-15)
    assert way.imposed == ("p_P_y", "p_P_z")
    assert way.length == pytest.approx(np.hypot(*goal), rel=1e-12)
    assert way.cost == pytest.approx(2.5 * way.length, rel=1e-12)


@pytest.mark.parametrize("ratio", [2.0, 6.0])
def test_between_two_costs_it_is_refracted(ratio):
    """Fermat's principle over the place where it crosses from one half into the other."""
    cost = np.where(Y[:, None] < 0.295, 1.0, ratio) * np.ones(len(Z))
    way = cpr.plan_path(made_up(cost), (0.0, 0.0), (0.6, 0.4))

    def total(z):
        return np.hypot(0.295, z) + ratio * np.hypot(0.305, 0.4 - z)

    least = minimize_scalar(total, bounds=(0.0, 0.4), method="bounded")
    assert way.cost == pytest.approx(least.fun, rel=1e-3)
    assert np.interp(0.295, *way.points.T) == pytest.approx(least.x, abs=0.01)


def test_around_an_obstacle_it_is_no_longer_than_around_its_corner():
    blocked = (np.abs(Y[:, None] - 0.3) < 0.051) & (Z < 0.301)
    data = made_up(1.0)
    way = cpr.plan_path(data, (0.0, 0.1), (0.6, 0.1), allowed=data["status"].copy(data=~blocked))
    # Over cells that are open: one line of the grid above what is blocked.
    around = 2.0 * np.hypot(0.24, 0.21) + 0.12
    assert np.hypot(0.25, 0.2) * 2.0 + 0.1 < way.length <= around * (1.0 + 1e-9)


@pytest.mark.parametrize(
    "changed",
    [
        {"status": np.where(Y[:, None] == Y[30], int(Status.BEYOND_FOLD), 0)},
        {"status": np.where(Y[:, None] == Y[30], int(Status.BEYOND_LIMITS), 0)},
        {"stable": np.where(Y[:, None] == Y[30], 0, 1)},
        {"seam": np.where(Y[:, None] == Y[30], 1, 0)},
    ],
    ids=["fold", "limit", "unstable", "seam"],
)
def test_it_does_not_cross_what_robots_do_not_cross(changed):
    ((name, wall),) = changed.items()
    wall = np.broadcast_to(wall, (len(Y), len(Z))).copy()
    with pytest.raises(cpr.SolveError, match="No path leads"):
        cpr.plan_path(made_up(1.0, **{name: wall}), (0.0, 0.1), (0.6, 0.1))
    gap = 25
    wall[30, gap] = {"status": 0, "stable": 1, "seam": 0}[name]
    way = cpr.plan_path(made_up(1.0, **{name: wall}), (0.0, 0.1), (0.6, 0.1))
    at_wall = np.interp(Y[30], way.points[:, 0], way.points[:, 1])
    assert at_wall == pytest.approx(Z[gap], abs=1e-9)
    if name == "stable":
        held = cpr.plan_path(made_up(1.0, stable=wall), (0.0, 0.1), (0.6, 0.1), unstable=True)
        assert len(held.points) == 2


def test_a_mask_of_one_axis_is_one_of_all_cells():
    data = made_up(1.0)
    way = cpr.plan_path(data, (0.0, 0.1), (0.6, 0.1), allowed=data["z"] < 0.2)
    assert len(way.points) == 2


def test_an_angle_counts_for_a_length():
    data = made_up(1.0)
    data["z"].attrs["units"] = "rad"
    with pytest.raises(ValueError, match="`radian` must be given for a map over y and z"):
        cpr.plan_path(data, (0.0, 0.0), (0.3, 0.4))
    way = cpr.plan_path(data, (0.0, 0.0), (0.3, 0.4), radian=0.5)
    assert way.length == pytest.approx(np.hypot(0.3, 0.2))


@pytest.mark.parametrize("sliced", [False, True])
def test_what_is_held_is_in_the_waypoints(sliced):
    """By a map, or by a slice of a volume, which has it as a coordinate."""
    data = made_up(1.0)
    data = data.assign_coords(coordinate=["p_P_x", "p_P_y", "p_P_z"], motor=["q1", "q2", "q3"])
    data.attrs["imposed"] = json.dumps(["p_P_x", "p_P_y", "p_P_z"])
    if sliced:
        data = data.assign_coords(x=0.07)
    else:
        data.attrs["held"] = json.dumps({"p_P_x": 0.07})
    way = cpr.plan_path(data, (0.0, 0.0), (0.3, 0.4))
    assert way.imposed == ("p_P_x", "p_P_y", "p_P_z")
    np.testing.assert_allclose(way.points, [(0.07, 0.0, 0.0), (0.07, 0.3, 0.4)])


def test_on_the_papers_robot_it_is_less_exposed_than_the_straight_line():
    """And the robot follows it, with the cost that was promised."""
    robot = cpr.rfrfr()
    ends = (-0.06, 0.08), (0.14, 0.12)
    mapped = cpr.workspace_map(
        robot, spacing=0.006, symmetry=False, box=((-0.15, 0.05), (0.2, 0.32))
    )
    way = cpr.plan_path(mapped, *ends)
    exposures = {}
    for name, points in (("planned", way.points), ("straight", np.array(ends))):
        followed = cpr.trajectory(robot, points, spacing=0.002)
        assert cpr.events(followed) == []
        exposures[name] = float(followed["semi_axis_max"].integrate("s"))
    assert exposures["planned"] < 0.95 * exposures["straight"]
    assert way.cost == pytest.approx(exposures["planned"], rel=0.01)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"goal": (0.7, 0.1)}, "`goal` must be on the map, whose y goes from 0 to 0.6"),
        ({"start": (0.1,)}, "`start` must be two finite numbers, y and z"),
        ({"start": (0.1, np.nan)}, "`start` must be two finite numbers"),
        ({"start": "home"}, "`start` must be two finite numbers"),
        ({"cost": "sensitivity"}, "`cost` must be a variable of the map"),
        ({"cost": np.ones(3)}, "`cost` must be over y and z"),
        ({"cost": -np.ones((61, 41))}, "`cost` must not be negative"),
        ({"allowed": np.ones(3)}, "`allowed` must be over y and z"),
        ({"allowed": np.zeros((61, 41))}, "`allowed` must be true or false in each cell"),
        ({"allowed": np.zeros((61, 41), bool)}, "`allowed` and `cost` must leave some cells"),
        ({"allowed": Y[:, None] + 0.0 * Z > 0.1}, "`start` .* but its cell is not allowed"),
        (
            {"allowed": made_up(1.0)["stable"].isel(y=slice(None, None, -1)) == 1},
            "but its y differs",
        ),
        ({"goal": (0.1, 0.1)}, "`goal` must not be the point `start`"),
        ({"start": (-0.1, 0.1)}, "`symmetry=False`"),
        ({"goal": (60.0, 0.1)}, "whose y goes from 0 to 0.6 in SI units, but its y is 60.$"),
        ({"radian": -1.0}, "`radian` must be positive"),
    ],
)
def test_mistakes_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        cpr.plan_path(made_up(1.0), **{"start": (0.1, 0.1), "goal": (0.2, 0.2), **arguments})


def test_what_is_no_map_is_refused():
    for other in (3, xr.Dataset()):
        with pytest.raises(ValueError, match="`dataset` must be a workspace map over two"):
            cpr.plan_path(other, (0.0, 0.0), (0.3, 0.4))


def test_without_uncertainties_it_is_the_shortest_path():
    bare = made_up(1.0).drop_vars("semi_axis_max")
    assert cpr.plan_path(bare, (0.0, 0.0), (0.3, 0.4)).cost == pytest.approx(0.5)
