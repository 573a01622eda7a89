"""The front of a map tries what it must, and no more."""

import numpy as np
import pytest
import xarray as xr

import cpr_jax as cpr
from cpr_jax.statics.problem import imposed_rows
from cpr_jax.statics.unknowns import unknown_scales
from cpr_jax.studies.follower import Follower
from cpr_jax.studies.front import Front
from cpr_jax.studies.grid import make_grid

pytestmark = pytest.mark.optimised


@pytest.mark.parametrize("case", [{"spacing": 0.016}, {"spacing": 0.03, "refine": 1}])
def test_cells_beside_new_ones_are_all_that_is_to_be_tried(case, monkeypatch):
    """Folds and cusps included: with every pass over the whole grid the map is the same."""
    robot = cpr.rfrfr()
    found = cpr.workspace_map(robot, **case)
    passes = []

    def whole(self, stride):
        passes.append(stride)
        return self._unsolved(stride)

    monkeypatch.setattr(Front, "_beside_fresh", whole)
    xr.testing.assert_identical(cpr.workspace_map(robot, **case), found)
    assert len(passes) > 10


def test_a_close_look_takes_no_more_than_its_cells():
    """However small the spacing is beside the lattice that a branch is first spread on."""
    robot = cpr.rfrfr()
    seed = cpr.solve_inverse(robot, (0.0, 0.2))
    units, begin = np.asarray(unknown_scales(robot)), np.concatenate([seed.q_a, seed.q_p])
    h = 1e-7
    box = ((-10.0 * h, 0.2 - 10.0 * h), (10.0 * h, 0.2 + 10.0 * h))
    grid = make_grid(robot, begin, h, box)
    follower = Follower(robot, imposed_rows(robot, (2, 3)), grid.axes, 10)
    front = Front(follower, grid, np.asarray(seed.y) / units)
    assert front.solved.size < 3 * np.prod(grid.shape)
    front.spread(lambda _: None, lambda: None)
    assert np.all(front.solved[front.inner])
