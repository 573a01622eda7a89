"""Singular curves: each of their points is one, and they pass what stops a map."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.analysis.singularity import SingularityType, trace_curves
from cpr_jax.errors import InputError
from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.statics.residual import residual
from cpr_jax.statics.solve import solve_inverse
from cpr_jax.statics.unknowns import unknown_scales, unravel
from tests.oracles import planar_shooting

STEPS = 40
"""Of the integration: unknowns are compared to more digits than the default gives."""

BOX = np.array([[-0.25, 0.1], [0.25, 0.35]])


@pytest.fixture(scope="module")
def robot():
    return rfrfr()


@pytest.fixture(scope="module")
def t2(robot):
    """The curve around the middle of the base, right half, from beside its crossing of y = 50."""
    start = solve_inverse(robot, (0.05, 0.027)).y
    return trace_curves(
        robot,
        SingularityType.TYPE_2,
        np.asarray(start)[None],
        np.array([1]),
        (2, 3),
        box=np.array([[0.01, -0.07], [0.25, 0.35]]),
        spacing=0.004,
        steps=STEPS,
    )


def blocks(robot, y):
    """`R₀`, `A_p` and `A_q` at unknowns in SI units."""
    units = unknown_scales(robot)

    def rows(scaled):
        return residual(robot, unravel(robot, scaled * units), STEPS + 8)

    J = np.asarray(jax.jacfwd(rows)(jnp.asarray(y) / units))
    A_q = np.concatenate([J[:, :2], J[:, 4:]], axis=1)
    return np.asarray(rows(jnp.asarray(y) / units)), J[:, 2:], A_q


def test_the_t2_line_crosses_where_it_was_measured(t2):
    """On y = 50 mm, coming from above, at z = 25.4775 mm."""
    (curve,) = t2
    on_line = np.abs(curve.y[:, 2] - 0.05) < 1e-12
    assert on_line.sum() == 1
    assert curve.y[on_line, 3][0] == pytest.approx(0.0254775, abs=1e-6)


def test_points_of_the_t2_line_are_singular_and_spaced(robot, t2):
    (curve,) = t2
    assert not curve.closed
    gaps = np.linalg.norm(np.diff(curve.y[:, 2:4], axis=0), axis=1)
    assert np.max(gaps) < 0.005
    for y in curve.y[:: max(1, len(curve.y) // 12)]:
        R_0, A_p, A_q = blocks(robot, y)
        assert np.max(np.abs(R_0)) < 1e-9
        sigma = np.linalg.svd(A_p, compute_uv=False)
        assert sigma[-1] < 1e-9 * sigma[0]
        assert np.linalg.svd(A_q, compute_uv=False)[-1] > 1e-4


def test_motors_do_not_hold_the_platform_on_the_t2_line(t2):
    """By shooting: the platform stiffness with the motors held has an eigenvalue of zero."""
    (curve,) = t2
    y = curve.y[len(curve.y) // 2]
    model = planar_shooting.PlanarRobot()

    def rows(x):
        return planar_shooting.residual(model, np.concatenate([y[:2], x]))

    x = y[2:]
    scale = np.array([0.25, 0.25, 0.3, 0.3, 0.07, 0.3, 0.3, 0.07])
    J = np.stack([(rows(x + h) - rows(x - h)) / 2e-6 for h in 1e-6 * np.diag(scale)], axis=1)
    sigma = np.linalg.svd(J, compute_uv=False)
    assert sigma[-1] < 1e-6 * sigma[0] < 1e6 * sigma[-2]


def test_t1_is_the_upper_edge(robot):
    """From beside it the curve of folds is followed to its corner, where both legs are straight."""
    start = np.asarray(solve_inverse(robot, (0.1, 0.25)).y)
    (curve,) = trace_curves(
        robot,
        SingularityType.TYPE_1,
        start[None],
        np.array([1]),
        (2, 3),
        box=BOX,
        spacing=0.03,
        steps=STEPS,
    )
    for y in curve.y[:: max(1, len(curve.y) // 8)]:
        R_0, _, A_q = blocks(robot, y)
        assert np.max(np.abs(R_0)) < 1e-9
        sigma = np.linalg.svd(A_q, compute_uv=False)
        assert sigma[-1] < 1e-9 * sigma[0]
    # From the axis of symmetry to the edge of the box, nowhere farther than straight legs reach.
    assert abs(curve.y[:, 2].min()) < 1e-3 and curve.y[:, 2].max() > 0.2
    assert curve.y[:, 3].min() < 0.1
    reach = [np.linalg.norm(curve.y[:, 2:4] - [side, 0.0], axis=1).max() for side in (-0.1, 0.1)]
    assert max(reach) < 0.33 + 1e-9


def test_names_are_as_good_as_places(robot, t2):
    start = solve_inverse(robot, (0.05, 0.027)).y
    options = {"box": np.array([[0.01, -0.07], [0.25, 0.35]]), "spacing": 0.004, "steps": STEPS}
    at = np.asarray(start)[None], np.array([1])
    named = trace_curves(robot, "type-2", *at, ("y", "z"), imposed=("y", "z"), **options)
    np.testing.assert_array_equal(named[0].y, t2[0].y)
    for kind, axes, field in (("type 2", ("y", "z"), "kind"), ("type-2", ("x", "z"), "axes")):
        with pytest.raises(InputError, match=f"`{field}` must"):
            trace_curves(robot, kind, *at, axes, **options)


def test_without_starts_there_are_no_curves(robot):
    nothing = trace_curves(
        robot,
        SingularityType.TYPE_2,
        np.zeros((0, 10)),
        np.zeros(0, int),
        (2, 3),
        box=BOX,
        spacing=0.01,
    )
    assert nothing == []
