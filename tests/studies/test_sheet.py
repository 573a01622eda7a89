"""What belongs to the sheet that a map shows, on fine and on coarse grids."""

import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.statics.unknowns import unknown_scales
from cpr_jax.studies.grid import make_grid
from cpr_jax.studies.sheet import _Sheet


@pytest.fixture(scope="module")
def robot():
    return cpr.rfrfr()


def sheet_of(robot, spacing, slope):
    """Motors that grow evenly over the grid; and places halfway between cells, with theirs."""
    begin = np.concatenate([robot.home.q_a, robot.home.q_p])
    grid = make_grid(robot, begin, spacing, np.array([[-0.2, 0.0], [0.2, 0.4]]), None)
    y = np.zeros((*grid.shape, robot.n_y))
    y[..., 0] = slope * grid.points[..., 0]
    y[..., 2:4] = grid.points
    between = (y[1:, 1:] + y[:-1, :-1]).reshape(-1, robot.n_y) / 2.0
    sheet = _Sheet(robot, grid, y, np.ones(grid.shape, bool))
    return sheet, between / np.asarray(unknown_scales(robot))


@pytest.mark.parametrize("spacing", [0.005, 0.08])
def test_places_between_cells_belong_to_them(robot, spacing):
    """Also where neighbours differ by more than what tells sheets apart on a fine grid."""
    sheet, between = sheet_of(robot, spacing, slope=10.0)
    assert np.all(sheet.shows(between))


@pytest.mark.parametrize("spacing", [0.005, 0.08])
def test_another_sheet_does_not(robot, spacing):
    sheet, between = sheet_of(robot, spacing, slope=10.0)
    between[:, 1] += 2.0
    assert not np.any(sheet.shows(between))


def test_cells_without_neighbours_are_a_sheet_too(robot):
    begin = np.concatenate([robot.home.q_a, robot.home.q_p])
    grid = make_grid(robot, begin, 0.1, np.array([[-0.2, 0.0], [0.2, 0.4]]), None)
    solved = np.zeros(grid.shape, bool)
    solved[1, 2] = True
    sheet = _Sheet(robot, grid, np.zeros((*grid.shape, robot.n_y)), solved)
    starts, along = sheet.rim()
    assert len(starts) == len(along) == 4
