"""Optimal designs beside scans with single solves."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import cpr_jax as cpr

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
        ({"start": START | {"c": 5.0}}, r"`start\['c'\]` must be within its bounds"),
        ({"start": START | {"c": np.nan}}, r"`start\['c'\]` must be finite"),
        ({"points": [(0.0, 0.2, 0.1)]}, "`points` must be rows of 2 finite numbers"),
        ({"points": []}, "`points` must be rows of 2 finite numbers"),
        ({"points": "here"}, "`points` must be rows of 2 finite numbers"),
        ({"build": lambda x: x}, "`build` must return a Robot"),
        ({"iterations": 0}, "`iterations` must be a positive integer"),
        ({"imposed": ("x", "z")}, "`imposed` must name coordinates"),
    ],
)
def test_mistakes_are_named(arguments, message):
    usual = {"build": build, "start": START, "bounds": BOUNDS, "points": POINTS}
    with pytest.raises(ValueError, match=message):
        cpr.optimise_design(**{**usual, **arguments})
