"""Critical values beside the analytic buckling load."""

import dataclasses
import json
import pathlib

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.errors import InputError
from cpr_jax.robots.catalogue import rfrfr_straight
from cpr_jax.statics.measures import measure
from cpr_jax.statics.solve import solve_inverse
from cpr_jax.statics.status import SolveError, Status
from cpr_jax.studies.critical import critical_value
from cpr_jax.studies.paper_samples import POINTS
from tests.statics.common import with_stiffness

CASE = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())[
    "buckling_t2"
]


@pytest.fixture(scope="module")
def compressed():
    """The straight robot with its apex at (0, √0.96), its legs straight under a load of 1 N."""
    robot = dataclasses.replace(rfrfr_straight(), f_P=jnp.array([0.0, -1.0]))
    apex = np.array([0.0, np.sqrt(0.96)])
    ways = apex - np.asarray(robot.legs.base_position)
    angles = np.arctan2(ways[:, 1], ways[:, 0])
    forces = -0.5 / np.sin(angles[0]) * ways
    solved = solve_inverse(robot, (0.0, 0.9))
    exact = jnp.asarray(angles), jnp.asarray(apex), jnp.asarray(np.column_stack([forces, [0, 0]]))
    return robot, eqx.tree_at(lambda e: (e.q_a, e.q_p, e.mu), solved, exact)


def test_two_legs_buckle_together(compressed):
    """The determinant keeps its sign there; the index does not."""
    robot, equilibrium = compressed
    found = critical_value(robot, equilibrium, "f_P_z", -9.0)
    assert found.value == pytest.approx(-CASE["critical_downward_force_N"], rel=1e-6)
    assert (found.before, found.after) == (0, 2)
    np.testing.assert_allclose(found.y[:4], [*equilibrium.q_a, *equilibrium.q_p], atol=1e-9)


@pytest.mark.parametrize("eps", [2e-5, 5e-6])
def test_a_fold_is_not_jumped(eps):
    """A clamped column that is buckled against its slight precurvature, as its load falls: there
    it folds back `3/2 (c eps)^(2/3)` above Euler's load. Beyond, only the other side is left."""

    def column(load):
        rod = cpr.kirchhoff_rod(cpr.PLANE, 1.0, 1.0, eps)
        ways = {"joint": cpr.pivot(cpr.PLANE), "base_rotation": np.pi / 2.0}
        leg = cpr.make_leg(cpr.PLANE, (0.0, 0.0), rod, **ways)
        return cpr.make_robot(cpr.PLANE, [leg], oriented=False, f_P=(0.0, -load))

    robot = column(2.6)
    every = cpr.find_equilibria(robot, q_a=[0.0], starts=256)
    sides = [k for k in range(len(every.y)) if every.unstable[k] == 0 and every.y[k][1] > 0.0]
    start = every.equilibrium(robot, sides[0])
    found = critical_value(robot, start, "f_P_z", -1.0)
    assert (found.before, found.after) == (0, -1)
    here, last = start, 2.6
    while last > 2.4:
        ahead = cpr.solve_forward(column(last - 5e-4), (0.0,), guess=here, throw=False)
        if int(ahead.status) != Status.SOLVED:
            break
        here, last = ahead, last - 5e-4
    assert last - 5e-4 <= -found.value <= last
    assert found.y[1] > 0.0


def test_nothing_happens_before_the_load(compressed):
    robot, equilibrium = compressed
    found = critical_value(robot, equilibrium, "f_P_z", -6.0)
    assert np.isnan(found.value)
    assert found.before == found.after == 0


@pytest.mark.parametrize(
    ("parameter", "stop", "named"),
    [
        ("f_P_z", -1.0, "`stop`"),
        ("f_P_z", np.nan, "`stop`"),
        ("f_P_q", 1.0, "`parameter` .*'f_P_q'"),
        ("l3", 1.0, "`parameter` .*'l3'"),
        ("l1", -0.1, "`stop` must not be negative, as l1 cannot be"),
        ("k_b", -0.01, "`stop` must not be negative, as k_b cannot be"),
        ("f1_z", -1.0, "`legs.rod.force` is left out, give zeros for it"),
        (3, 1.0, "`parameter` .*3"),
    ],
)
def test_mistakes_are_named(compressed, parameter, stop, named):
    with pytest.raises(InputError, match=named):
        critical_value(*compressed, parameter, stop)


@pytest.mark.parametrize("points", [0, -5, 2.5])
def test_points_are_counted(compressed, points):
    with pytest.raises(InputError, match="`points` must be a positive integer"):
        critical_value(*compressed, "f_P_z", -3.0, points=points)


@pytest.fixture(scope="module")
def paper():
    return cpr.rfrfr()


def test_where_a_branch_ends_does_not_depend_on_how_far_one_looks(paper):
    """Point D of the paper with a softer rod, until the platform has no stiffness left."""
    start = cpr.solve_inverse(paper, POINTS["D"])
    found = [cpr.critical_value(paper, start, "k_b1", stop) for stop in (0.011, 0.008)]
    value = found[0].value
    assert found[1].value == pytest.approx(value, rel=1e-8)
    other = 1.0 / paper.legs.rod.curvature_compliance[1, 0]
    softer = with_stiffness(paper, jnp.array([value, other]))
    there, _ = measure(softer, jnp.asarray(found[0].y), 20)
    assert there.sigma_t2 < 1e-3 * start.measures.sigma_t2


def test_a_rod_pulled_taut_is_no_fold(paper):
    """The shorter it is the harder it pulls, until rounding hides what there is to solve."""
    start = cpr.solve_inverse(paper, (0.0, 0.2))
    found = cpr.critical_value(paper, start, "l1", 0.04)
    assert np.isnan(found.value) and found.before == found.after == 0
    with pytest.raises(SolveError, match=r"l1 = 0\.0[23]"):
        cpr.critical_value(paper, start, "l1", 0.0, rtol=1e-4)


@pytest.fixture(scope="module")
def column():
    """A straight rod, clamped at its motor and free at the other end."""
    leg = cpr.make_leg(cpr.PLANE, (0.0, 0.0), cpr.kirchhoff_rod(cpr.PLANE, 0.3, 0.02))
    robot = cpr.make_robot(
        cpr.PLANE, [leg], oriented=False, f_P=(0.0, 0.0), home=((np.pi / 2.0,), (0.0, 0.3))
    )
    return robot, cpr.solve_forward(robot, (np.pi / 2.0,)), np.pi**2 * 0.02 / 4.0 / 0.3**2


@pytest.mark.parametrize(("share", "points"), [(1.7, 40), (3.0, 40), (2.0, 40), (2.0, 2)])
def test_a_column_buckles_under_eulers_load(column, share, points):
    """Also where a value that is looked at is the load itself, at which all is singular."""
    robot, equilibrium, load = column
    found = critical_value(robot, equilibrium, "f_P_z", -share * load, points=points)
    assert found.value == pytest.approx(-load, rel=1e-8)
    assert (found.before, found.after) == (0, 1)


def test_two_columns_under_a_body_sway_together():
    """A quarter of their load is Euler's for a rod with a free end, which none of them is."""
    legs = [
        cpr.make_leg(
            cpr.PLANE,
            (side, 0.0),
            cpr.kirchhoff_rod(cpr.PLANE, 0.3, 0.02),
            joint=cpr.clamped(cpr.PLANE),
            attachment_position=(side, 0.0),
            attachment_rotation=np.pi / 2.0,
        )
        for side in (-0.05, 0.05)
    ]
    upright = (np.pi / 2.0,) * 2
    robot = cpr.make_robot(
        cpr.PLANE, legs, oriented=True, f_P=(0.0, 0.0), home=(upright, (0.0, 0.3, 0.0))
    )
    load = 2.0 * np.pi**2 * 0.02 / 0.3**2
    start = cpr.solve_forward(robot, upright)
    found = critical_value(robot, start, "f_P_z", -1.7 * load)
    assert found.value == pytest.approx(-load, rel=1e-7)
    below = critical_value(robot, start, "f_P_z", -0.75 * load, points=3)
    assert np.isnan(below.value) and below.before == below.after == 0


@pytest.mark.parametrize("rtol", [0.0, -1e-9, np.nan])
def test_an_accuracy_is_positive(column, rtol):
    with pytest.raises(InputError, match="`rtol` must be positive"):
        critical_value(*column[:2], "f_P_z", -1.0, rtol=rtol)


def test_no_accuracy_is_too_much(column):
    robot, equilibrium, load = column
    found = critical_value(robot, equilibrium, "f_P_z", -1.7 * load, rtol=1e-300)
    assert found.value == pytest.approx(-load, rel=1e-8)
