"""Optimal designs beside scans with single solves."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import cpr_jax as cpr
from cpr_jax.studies.design_search import Search

POINTS = ((0.06, 0.15), (-0.02, 0.12))
MOST = 0.55
"""Largest torque, N·m."""


def build(x):
    """Rods of some stiffness whose curvature at rest is a design variable."""
    return cpr.rfrfr(k_b=x["k_b"], r_c=(-1.0 / x["c"], 1.0 / x["c"]))


def looked_at(k_b, c):
    """Mean spread and largest torque of a design, by single solves."""
    robot = build({"k_b": k_b, "c": c})
    found = [cpr.solve_inverse(robot, point) for point in POINTS]
    kernels = [cpr.ellipsoid(cpr.sensitivity(robot, here)).semi_axes for here in found]
    spread = np.mean([np.sqrt(np.sum(np.asarray(axes) ** 2)) for axes in kernels])
    return spread, max(np.max(np.abs(here.motor_torques)) for here in found)


@pytest.fixture(scope="module")
def limited():
    return cpr.optimise_design(
        build,
        {"k_b": 0.015, "c": 0.5},
        {"k_b": (0.01, 0.04), "c": (0.2, 4.0)},
        POINTS,
        constraints=lambda robot, here: 1.0 - (here.motor_torques / MOST) ** 2,
    )


def test_under_a_constraint_it_is_the_best_of_those_that_just_fulfil_it(limited):
    def stiffness(c):
        return brentq(lambda k_b: looked_at(k_b, c)[1] - MOST, 0.01, 0.04, xtol=1e-7)

    scan = minimize_scalar(
        lambda c: looked_at(stiffness(c), c)[0],
        bounds=(0.2, 4.0),
        method="bounded",
        options={"xatol": 1e-2},
    )
    assert limited.converged
    assert limited.objective == pytest.approx(scan.fun, rel=1e-4)
    assert limited.values["c"] == pytest.approx(scan.x, abs=0.05)
    spread, torque = looked_at(**limited.values)
    assert limited.objective == pytest.approx(spread, rel=1e-9)
    assert torque == pytest.approx(MOST, rel=1e-5)


def test_it_says_what_it_has_found(limited):
    assert np.min(limited.slack) == pytest.approx(0.0, abs=1e-6)
    assert np.shape(limited.slack) == (2, 2)
    np.testing.assert_array_equal(limited.equilibria.status, 0)
    np.testing.assert_allclose(limited.equilibria.q_p, POINTS, atol=1e-12)
    alone = cpr.solve_inverse(limited.robot, POINTS[0])
    np.testing.assert_allclose(limited.equilibrium(0).y, alone.y, rtol=0, atol=1e-7)
    values, objective = limited.history[0]
    assert values == pytest.approx({"k_b": 0.015, "c": 0.5})
    assert objective == pytest.approx(looked_at(0.015, 0.5)[0], rel=1e-9)
    assert limited.objective < objective
    assert all(
        limited.objective <= value * (1.0 + 1e-6)
        for values, value in limited.history
        if looked_at(**values)[1] <= MOST
    )


def test_it_is_printed_by_what_it_has_found(limited):
    first, *lines = str(limited).splitlines()
    assert first.startswith(f"Best design of {len(limited.history)} that work: ")
    found = dict(line.split(maxsplit=1) for line in lines)
    values = dict(part.split(" = ") for part in found["values"].split(", "))
    assert list(values) == list(limited.values)
    for name, value in values.items():
        assert float(value) == pytest.approx(limited.values[name], rel=1e-5)
    assert float(found["objective"]) == pytest.approx(limited.objective, rel=1e-5)
    assert float(found["slack"]) == pytest.approx(np.min(limited.slack), abs=1e-9)


def test_it_follows_a_branch_where_one_jump_leads_to_another():
    """To other lengths and stiffnesses; solves in small steps are the oracle."""
    ends = {"l": (0.3, 0.36443), "d": (0.2, 0.17826), "k_b": (0.0183, 0.03067), "c": (1.0, 2.0)}
    names = list(ends)

    def design(x):
        c = x["c"]
        return cpr.rfrfr(l=x["l"], d=x["d"], k_b=x["k_b"], r_c=(-1.0 / c, 1.0 / c))

    low, high = np.array([ends[name] for name in names]).T

    def named(values):
        return dict(zip(names, values, strict=True))

    order = np.sort(np.stack([low, high]), axis=0)
    search = Search(
        design, names, order[0], order[1] - order[0], lambda robot, here: here.q_a[0], None, True
    )
    first = named(low)
    search.begin(design(first), np.array([[0.03, 0.2]]), None, first)
    found = search.at((high - order[0]) / (order[1] - order[0]))
    here = cpr.solve_inverse(design(first), (0.03, 0.2))
    for share in np.linspace(0.0, 1.0, 81)[1:]:
        robot = design(named(low + share * (high - low)))
        here = cpr.solve_inverse(robot, (0.03, 0.2), guess=here)
    assert found.works
    np.testing.assert_allclose(found.equilibria.q_a[0], here.q_a, rtol=0, atol=1e-7)


def test_what_cannot_be_fulfilled_is_said_with_its_point():
    found = cpr.optimise_design(
        lambda x: cpr.rfrfr(l=x["l"]),
        {"l": 0.25},
        {"l": (0.24, 0.26)},
        [(0.0, 0.25)],
        lambda robot, here: jnp.sum(here.q_a**2),
        constraints=lambda robot, here: here.motor_torques * 0.0 - 0.3,
        unstable=True,
        iterations=5,
    )
    assert not found.converged
    assert "a constraint is missed by 0.3 at point 0" in found.message


def test_slopes_beside_differences():
    """Of distances to singularities, too, whose units change with the design."""

    def worst(robot, here):
        return here.measures.sigma_t2

    search = Search(
        build, ["k_b", "c"], np.array([0.01, 0.2]), np.array([0.03, 3.8]), worst,
        lambda robot, here: here.measures.sigma_t1[None], True,
    )  # fmt: skip
    search.begin(build(START), np.array(POINTS), None, START)
    at = search.near
    h = 1e-4
    for k in range(2):
        ahead, behind = (search.at(at.x + sign * h * np.eye(2)[k]) for sign in (1.0, -1.0))
        slope = (ahead.value - behind.value) / (2.0 * h)
        assert at.slope[k] == pytest.approx(slope, rel=1e-4, abs=1e-6)
        slopes = (ahead.slack - behind.slack) / (2.0 * h)
        np.testing.assert_allclose(at.slack_slope[..., k], slopes, rtol=1e-4, atol=1e-7)


def test_where_designs_beyond_do_not_work_it_has_not_converged():
    """Shorter rods are less sensitive until one is straight: there the objective has no minimum."""
    found = cpr.optimise_design(
        lambda x: cpr.rfrfr(l=x["l"]),
        {"l": 0.25},
        {"l": (0.15, 0.3)},
        [(0.0, 0.25)],
        lambda robot, here: jnp.sum(robot.legs.rod.length),
        unstable=True,
        iterations=20,
    )
    straight = np.hypot(0.1, 0.25) - 0.045 - 0.035
    assert not found.converged
    assert (
        "ended beside designs that do not work (there is no equilibrium at point 0" in found.message
    )
    assert straight < found.values["l"] < straight + 0.02
    alone = cpr.solve_inverse(found.robot, (0.0, 0.25))
    np.testing.assert_allclose(found.equilibria.q_a[0], alone.q_a, rtol=0, atol=1e-6)


def test_a_start_that_has_no_solution_is_refused_with_its_point():
    with pytest.raises(cpr.SolveError, match=r"of the start at \[0.0, 0.5\]: a leg is too short"):
        cpr.optimise_design(build, START, BOUNDS, [(0.0, 0.2), (0.0, 0.5)])


START, BOUNDS = {"k_b": 0.015, "c": 0.5}, {"k_b": (0.01, 0.04), "c": (0.2, 4.0)}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"start": {}}, "`start` must be a table by name"),
        ({"bounds": [(0, 1)]}, "`bounds` must be a table by name"),
        ({"bounds": {"k_b": (0.01, 0.04)}}, r"`bounds` must have the names of `start` \(k_b, c\)"),
        ({"bounds": BOUNDS | {"c": (4.0, 0.2)}}, r"`bounds\['c'\]` must be a lowest and a highest"),
        ({"bounds": BOUNDS | {"c": 4.0}}, r"`bounds\['c'\]` must be a lowest and a highest"),
        ({"start": START | {"c": 5.0}}, r"`start\['c'\]` must be a number within"),
        ({"start": START | {"c": np.nan}}, r"`start\['c'\]` must be a number within"),
        ({"start": START | {"c": [1.0, 2.0]}}, r"`start\['c'\]` must be a number within"),
        (
            {"bounds": BOUNDS | {"c": (None, 3.0)}},
            r"`bounds\['c'\]` must be a lowest and a highest",
        ),
        ({"tolerance": 0.0}, "`tolerance` must be positive"),
        ({"objective": lambda robot, here: here.q_a}, "`objective` must return one number"),
        ({"objective": lambda robot, here: None}, "`objective` must return floating-point"),
        (
            {"constraints": lambda robot, here: here.motor_torques < 1.0},
            "`constraints` must return floating-point numbers, but it returned",
        ),
        ({"points": [(0.0, 0.2, 0.1)]}, "`points` must be rows of 2 numbers"),
        ({"points": []}, "`points` must be rows of 2 numbers"),
        ({"points": "here"}, "`points` must be rows of 2 numbers"),
        ({"build": lambda x: x}, "`build` must return a Robot"),
        ({"iterations": 0}, "`iterations` must be a positive integer"),
        ({"imposed": ("x", "z")}, "`imposed` must name coordinates"),
    ],
)
def test_mistakes_are_named(arguments, message):
    usual = {"build": build, "start": START, "bounds": BOUNDS, "points": POINTS}
    with pytest.raises(ValueError, match=message):
        cpr.optimise_design(**{**usual, **arguments})
