"""The front of a map tries what it must, and no more."""

import pytest
import xarray as xr

import cpr_jax as cpr
from cpr_jax.studies.front import Front


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
