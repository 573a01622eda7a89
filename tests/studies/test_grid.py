"""Grids keep to a user's box and enclose a workspace of their own."""

import numpy as np
import pytest

from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.studies.grid import make_grid


@pytest.mark.parametrize("spacing", [0.002, 0.003, 0.007])
def test_all_within_reach_is_enclosed(spacing):
    """Both legs reach 0.33 m from (∓0.1, 0): at most to y = ±0.23 and z = ±√(0.33² - 0.1²)."""
    grid = make_grid(rfrfr(), np.zeros(4), spacing, None)
    low, high = grid.box
    assert low[0] <= -0.23 + 1e-12 and high[0] >= 0.23 - 1e-12
    assert low[0] > -0.23 - spacing and high[0] < 0.23 + spacing
    assert high[1] >= np.sqrt(0.33**2 - 0.1**2)
    for line in grid.coordinates:
        np.testing.assert_allclose(line / spacing, np.round(line / spacing), atol=1e-9)


def test_a_box_is_kept_to():
    box = np.array([[-0.0105, 0.1], [0.0305, 0.2]])
    grid = make_grid(rfrfr(), np.zeros(4), 0.01, box)
    np.testing.assert_allclose(grid.box, [[-0.01, 0.1], [0.03, 0.2]], atol=1e-12)
    half = make_grid(rfrfr(), np.zeros(4), 0.01, box, mirror=True)
    assert half.box[0, 0] == 0.0


@pytest.mark.parametrize("low", [-0.2, 0.05])
def test_half_of_a_box_stays_within_it(low):
    robot = rfrfr()
    begin = np.concatenate([robot.home.q_a, robot.home.q_p])
    box = np.array([[low, 0.1], [0.3, 0.2]])
    grid = make_grid(robot, begin, 0.01, box, mirror=True)
    np.testing.assert_allclose(grid.box, [[max(low, 0.0), 0.1], [0.3, 0.2]], atol=1e-12)
