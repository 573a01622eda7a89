"""Robots side by side: each within its column, and as large as that allows."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from mpl_toolkits.mplot3d import proj3d

import cpr_jax as cpr
from cpr_jax.plotting.gallery import figure_of_robots
from cpr_jax.plotting.style import journal_style


@pytest.fixture(scope="module")
def robots():
    """Two of the plane, and in between one of space, so often that its columns are narrow."""
    made = [cpr.rfrfr(), cpr.three_rfs(), cpr.three_rfr()]
    first, spatial, last = [(robot, cpr.solve_forward(robot, robot.home.q_a)) for robot in made]
    return [first, *[spatial] * 5, last]


@pytest.fixture(scope="module")
def figure(robots):
    with journal_style():
        figure = figure_of_robots(robots)
        figure.canvas.draw()
    yield figure
    plt.close(figure)


def pixels(ax, points):
    """Where points of a robot, m, are in the figure, as shares of its size."""
    points = 1e3 * points
    if points.shape[-1] == 3:
        points = np.stack(proj3d.proj_transform(*points.T, ax.get_proj())[:2], axis=1)
    return ax.figure.transFigure.inverted().transform(ax.transData.transform(points))


def test_rows_of_the_plane_and_of_space(robots, figure):
    words = [text.get_text() for text in figure.texts]
    planar, spatial = ["RFRFR\nrods of 250 mm", "3-RFR\nrods of 250 mm"], "3-RFS\nrods of 300 mm"
    assert words == [*planar, *[spatial] * 5]
    heights = [text.get_position()[1] for text in figure.texts]
    assert heights[0] == heights[1] > 0.9 > 0.5 > heights[2] == heights[6] > 0.4


@pytest.mark.parametrize(
    ("place", "which", "column", "row"),
    [(0, 0, (0.0, 0.5), 1), (1, 6, (0.5, 1.0), 1), (2, 1, (0.0, 0.2), 0), (5, 4, (0.6, 0.8), 0)],
)
def test_robots_fill_their_places(robots, figure, place, which, column, row):
    robot, equilibrium = robots[which]
    rods = np.asarray(cpr.shape(robot, equilibrium).rods.position)
    drawn = pixels(figure.axes[place], rods.reshape(-1, robot.geometry.d))
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    assert column[0] < low[0] < high[0] < column[1]
    assert 0.5 * row < low[1] < high[1] < 0.5 * row + 0.42
    wide, tall = (high - low) / (column[1] - column[0], 0.42)
    assert max(wide, tall) > 0.7
