"""A planar robot as it is drawn: what is where, on plain axes."""

import dataclasses

import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Polygon

import cpr_jax as cpr
from cpr_jax.plotting.robot import plot_robot


@pytest.fixture(scope="module")
def solved():
    robot = cpr.three_pfr()
    return robot, cpr.solve_forward(robot, (0.02, 0.01, 0.0))


@pytest.fixture
def ax():
    figure, ax = plt.subplots()
    yield ax
    plt.close(figure)


def markers(ax, kind):
    """Places of the markers of a kind, with their size."""
    lines = [line for line in ax.lines if line.get_marker() == kind]
    return [(line.get_xydata()[0], line.get_markersize()) for line in lines]


def ends(ax):
    """Ends of straight lines by their colour."""
    lines = [line for line in ax.lines if len(line.get_xydata()) == 2]
    return [(line.get_color(), line.get_xydata() / 1e3) for line in lines]


def test_sliders_are_square_and_show_the_way_that_they_have_gone(solved, ax):
    robot, equilibrium = solved
    drawn = plot_robot(robot, equilibrium, ax)
    squares = np.array([place for place, _ in markers(ax, "s")])
    np.testing.assert_allclose(squares, 1e3 * np.asarray(drawn.motors))
    ways = [
        np.linalg.norm(np.ptp(line, axis=0)) for colour, line in ends(ax) if colour == "#7F7F7F"
    ]
    np.testing.assert_allclose(ways, [0.02, 0.01, 0.0], atol=1e-12)
    (platform,) = (patch for patch in ax.patches if isinstance(patch, Polygon))
    np.testing.assert_allclose(platform.get_xy()[:3], 1e3 * np.asarray(drawn.joints))


def test_cranks_lead_to_marked_pivots(solved, ax, monkeypatch):
    """A crank of leg 2 alone: motor, pivot, rigid segment, rod."""
    robot, equilibrium = solved
    shape = cpr.shape(robot, equilibrium)
    moved = shape._replace(pivots=shape.pivots.at[1].add(jnp.array([0.03, -0.02])))
    free = jnp.zeros((3, 3)).at[1, 2].set(1.0)
    joint = cpr.BaseJoint(free, jnp.zeros((3, 2)), jnp.zeros((3, 1)))
    jointed = dataclasses.replace(robot, legs=dataclasses.replace(robot.legs, base_joint=joint))
    monkeypatch.setattr("cpr_jax.plotting.robot.solved_shape", lambda *_: moved)
    plot_robot(jointed, equilibrium, ax)
    bars = [line for colour, line in ends(ax) if colour == "#000000"]
    pivot = np.asarray(moved.pivots[1])
    crank = np.stack([moved.motors[1], pivot])
    segment = np.stack([pivot, moved.rods.position[1, 0]])
    for expected in (crank, segment):
        assert any(np.allclose(bar, expected, atol=1e-12) for bar in bars)
    joints = np.concatenate([moved.joints, pivot[None]])
    rings = [place / 1e3 for place, size in markers(ax, "o") if size == 5.0]
    assert len(rings) == 4
    for place in joints:
        assert min(np.linalg.norm(ring - place) for ring in rings) < 1e-12


def test_what_cannot_be_drawn_is_refused(solved, ax):
    robot, equilibrium = solved
    lost = dataclasses.replace(equilibrium, status=jnp.asarray(cpr.Status.LOST))
    with pytest.raises(cpr.InputError, match=r"^Argument `equilibrium` must be solved .* LOST"):
        plot_robot(robot, lost, ax)
    with pytest.raises(cpr.InputError, match=r"^Argument `robot` must be planar"):
        plot_robot(cpr.in_space(robot), equilibrium, ax)
    assert not ax.lines
