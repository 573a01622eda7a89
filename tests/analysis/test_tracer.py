"""The tracer of singular curves, on circles."""

import numpy as np
import pytest

from cpr_jax.analysis.singular_points import Lane
from cpr_jax.analysis.tracer import _FIRST, Tracer


class Circle(Tracer):
    """The tracer on a circle instead of on singular equilibria."""

    def __init__(self, box, radius=1.0, belongs=None):
        self.axes, self.units = np.array([0, 1]), np.full(2, 1.0 / radius)
        self.box, self.spacing, self.belongs = np.asarray(box), 0.1, belongs
        self.radius, self.calls = radius, 0

    def correct(self, lanes, predicted):
        self.calls += 1
        z = self.radius * predicted / np.linalg.norm(predicted, axis=1, keepdims=True)
        tangent = z[:, ::-1] * [-1.0, 1.0] / self.radius
        tangent *= np.sign(np.sum(tangent * lanes.tangent, axis=1, keepdims=True))
        return lanes._replace(z=z, tangent=tangent, converged=np.ones(len(z), bool))

    def starts(self, angles):
        z = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        blank = np.zeros((len(z), 1))
        tangent = z[:, ::-1] * [-1.0, 1.0]
        return Lane(self.radius * z, tangent, blank, blank, np.ones(len(z), bool))


@pytest.mark.parametrize("angles", [[0.3], [0.0, 2.0], [0.0, 0.01, 1.5, 3.0, 4.5]])
def test_closed_loops_are_closed(angles):
    circle = Circle([[-2.0, -2.0], [2.0, 2.0]])
    ((points, closed),) = circle.trace(circle.starts(np.array(angles)), 1000)
    assert closed
    np.testing.assert_array_equal(points[0], points[-1])
    turns = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert turns[-1] - turns[0] == pytest.approx(2.0 * np.pi, abs=1e-9)
    assert np.all(np.diff(turns) > 0.0)


def test_a_curve_through_the_box_ends_outside_of_it():
    circle = Circle([[-2.0, 0.0], [2.0, 2.0]])
    ((points, closed),) = circle.trace(circle.starts(np.array([1.0, 2.0])), 1000)
    assert not closed
    outside = points[:, 1] < 0.0
    assert outside[0] and outside[-1] and outside.sum() == 2


def test_steps_are_as_long_as_the_curve_and_its_points_allow():
    """However large its unknowns are, as wrenches are where rods are strained much."""
    circle = Circle([[-2.0, -2.0], [2.0, 2.0]], radius=1000.0)
    ((points, closed),) = circle.trace(circle.starts(np.array([0.3])), 1000)
    assert closed
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1) / circle.radius
    assert np.max(gaps) < 0.101
    # 63 of the wanted length close it, and each of the first is twice the one before.
    assert circle.calls < 80


def test_a_curve_ends_close_to_where_it_leaves_the_sheet():
    def belongs(z):
        return z[:, 1] > 0.0

    circle = Circle([[-2.0, -2.0], [2.0, 2.0]], radius=1000.0, belongs=belongs)
    ((points, closed),) = circle.trace(circle.starts(np.array([0.3])), 1000)
    assert not closed
    assert np.all(points[:, 1] > 0.0)
    assert max(points[0, 1], points[-1, 1]) < 2.0 * _FIRST


def test_a_step_that_lands_on_another_branch_is_taken_again_shorter():
    """Far from its prediction, though converged and with the same tangent."""

    class Beside(Circle):
        def correct(self, lanes, predicted):
            found = super().correct(lanes, predicted)
            far = np.linalg.norm(predicted - lanes.z, axis=1, keepdims=True) > 0.05
            return found._replace(z=np.where(far, 1.5 * found.z, found.z))

    beside = Beside([[-2.0, -2.0], [2.0, 2.0]])
    ((points, closed),) = beside.trace(beside.starts(np.array([0.3])), 1000)
    assert closed
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-12)
