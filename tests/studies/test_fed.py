"""Rods that motors draw in to nothing: every study says so, as single solves do."""

import dataclasses

import jax
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select
from cpr_jax.statics.status import Status


@pytest.fixture(scope="module")
def robot():
    """Two rods that are pushed through their bases; their first 20 mm are a segment."""

    def leg(side, angle):
        parts = [cpr.kirchhoff_rod(cpr.PLANE, length, 0.0183, side) for length in (0.02, 0.23)]
        rod = cpr.segmented_rod(parts)
        at = side * 0.1, 0.0
        return cpr.make_leg(cpr.PLANE, at, rod, base_rotation=[angle], screw=np.zeros(3), feed=1.0)

    return cpr.make_robot(
        cpr.PLANE,
        [leg(-1.0, 2.0), leg(1.0, np.pi - 2.0)],
        oriented=False,
        f_P=(0.0, 0.5),
        home=((0.0, 0.0), (0.0, 0.2)),
        uncertainty={"l1_1": 3e-3, "l2_1": 3e-3},
        name="fed",
    )


def test_a_map_ends_where_a_rod_does(robot):
    grid = cpr.workspace_map(robot, spacing=0.02, box=((-0.02, 0.14), (0.02, 0.24)))
    column = grid.sel(y=0.0, method="nearest")
    seen = set()
    for z, status in zip(column.z.values, column.status.values, strict=True):
        alone = cpr.solve_inverse(robot, (0.0, float(z)), throw=False)
        assert int(status) == int(alone.status), z
        seen.add(int(status))
    assert seen == {Status.SOLVED, Status.OUT_OF_REACH}
    drawn_in = np.asarray(column.q_a)[column.status.values == Status.SOLVED]
    assert np.all(drawn_in > -0.02)


def test_no_map_leads_through_a_rod_that_is_used_up(robot):
    """Below the motors the equations have equilibria again: no robot comes to them from above."""
    grid = cpr.workspace_map(robot, spacing=0.02, box=((-0.02, -0.24), (0.02, 0.24)))
    z, status = np.broadcast_arrays(grid.z.values, grid.status.values)
    assert np.all(status[z > 0.2] == Status.SOLVED)
    assert np.all(status[z < 0.1] == Status.OUT_OF_REACH)


def test_a_search_finds_rods_that_are_there(robot):
    """Many of its starts have drawn in a segment: their energy is no measure."""
    homeless = dataclasses.replace(robot, home=None)
    found = cpr.solve_inverse(homeless, (0.0, 0.21), throw=False)
    assert int(found.status) == Status.SOLVED
    assert np.all(np.asarray(found.q_a) > -0.02)


def test_no_equilibrium_has_a_rod_of_negative_length(robot):
    found = cpr.find_equilibria(robot, (0.0, 0.21), starts=512)
    assert len(found.y) > 0
    assert np.all(found.y[:, : robot.n_a] > -0.02)
    for k in range(len(found.y)):
        assert int(found.equilibrium(robot, k).status) == Status.SOLVED


def test_samples_without_a_rod_have_no_platform(robot):
    """Where a millimetre is left, some of the samples have nothing left to draw in."""
    equilibrium = cpr.solve_inverse(robot, (0.0, 0.1885))
    study = cpr.monte_carlo(robot, equilibrium, 400)
    selection = select(robot, ("l1_1", "l2_1"))
    gone = np.any(study.rho + np.asarray(equilibrium.q_a) <= 0.0, axis=1)
    assert 20 < np.sum(gone) < 380
    np.testing.assert_array_equal(study.status == Status.OUT_OF_REACH, gone)
    assert study.failed == np.sum(gone)
    assert np.all(np.isnan(study.q_p[gone]))
    assert not np.any(study.inside[gone])
    first = selection.set(robot, jax.numpy.asarray(study.rho[np.argmax(gone)]))
    alone = cpr.solve_forward(first, equilibrium.q_a, throw=False)
    assert int(alone.status) == Status.OUT_OF_REACH


@pytest.mark.parametrize("spacing", [0.02, 0.001])
def test_a_path_ends_where_a_rod_does(robot, spacing):
    """Within a sixtieth of the usual distance of stops, whatever their distance here."""
    path = cpr.trajectory(robot, [(0.0, 0.23), (0.0, 0.12)], spacing=spacing)
    (end,) = cpr.events(path)
    assert (end["event"], end["status"]) == ("end", "out_of_reach")
    assert np.all(path["q_a"].values[path["index"].values >= 0] > -0.02)
    beside = [
        cpr.solve_inverse(robot, (0.0, 0.23 - end["s"] + h), throw=False) for h in (4e-5, -5e-5)
    ]
    assert [int(one.status) for one in beside] == [Status.SOLVED, Status.OUT_OF_REACH]


def test_a_critical_value_is_none_where_a_rod_ends(robot):
    """The equations go on, with a rod of negative length that many directions make unstable."""
    start = cpr.solve_inverse(robot, (0.0, 0.19))
    drawn_in = -float(np.asarray(start.q_a)[0])
    assert 0.005 < drawn_in < 0.02
    with pytest.raises(cpr.SolveError, match="nothing is left of a rod") as caught:
        cpr.critical_value(robot, start, "l1_1", 0.0, points=10, rtol=1e-4)
    assert caught.value.status == Status.OUT_OF_REACH
    end = float(str(caught.value).split("l1_1 = ")[1].split(",")[0])
    assert end == pytest.approx(drawn_in, abs=1e-5)
