"""Folds of curves that are known."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.chord import chord_corrector
from cpr_jax.statics.continuation import Corrected, follow
from cpr_jax.statics.fold import fold_ahead, hermite, is_fold
from cpr_jax.statics.status import Status

RNG = np.random.default_rng(0)


def on_a_parabola(coefficients, u):
    """`y` and `dy/dh` on `y = a u + b u² + c u³`, `h = -u²`."""
    powers = [u, u**2, u**3], [1.0, 2.0 * u, 3.0 * u**2]
    y, by_u = (sum(p * c for p, c in zip(row, coefficients, strict=True)) for row in powers)
    return y, by_u / (-2.0 * u)


def expected(coefficients, u, u_before):
    """The fold expected at u, from there and from a point before."""
    y, slope = on_a_parabola(coefficients, u)
    y_before, before = on_a_parabola(coefficients, u_before)
    taken = u_before**2 - u**2
    curve, bend = hermite(y - y_before, before, slope, taken)
    return fold_ahead(*(jnp.asarray(x) for x in (y, slope, curve, bend, taken)))


@pytest.mark.parametrize("u, u_before", [(0.3, 0.5), (0.01, 0.5), (2.0, 2.1)])
def test_a_fold_is_where_it_is_expected(u, u_before):
    """Of a parabola that leans to any side it is exact."""
    coefficients = RNG.normal(size=(2, 4))
    coefficients = [*coefficients, np.zeros(4)]
    fold = expected(coefficients, u, u_before)
    np.testing.assert_allclose(fold.distance, u**2, rtol=1e-8)
    y, slope = on_a_parabola(coefficients, -u)
    np.testing.assert_allclose(fold.y, y, atol=1e-9)
    np.testing.assert_allclose(fold.slope, slope, atol=1e-8 / u)


def test_expectations_get_better_towards_a_fold():
    """Of a curve that is no parabola, by the third order of u."""
    coefficients, errors = RNG.normal(size=(3, 4)), []
    for u in (0.08, 0.04, 0.02):
        fold = expected(coefficients, u, 1.5 * u)
        errors.append(np.max(np.abs(fold.y - on_a_parabola(coefficients, -u)[0])))
    assert errors[0] > 6.0 * errors[1] > 36.0 * errors[2] > 0.0


@pytest.mark.parametrize("curve", [0.0, -0.3])
def test_a_branch_that_goes_on_has_no_fold_ahead(curve):
    fold = fold_ahead(
        jnp.array([1.0]), jnp.array([0.5]), jnp.array([curve]), jnp.zeros(1), jnp.array(0.2)
    )
    assert np.isinf(fold.distance)


def test_both_sides_of_a_fold_are_told_from_other_points():
    coefficients, u, end = [*RNG.normal(size=(2, 4)) * [[1.0], [0.1]], np.zeros(4)], 0.3, 1.0
    fold = expected(coefficients, u, 0.5)
    here, other = on_a_parabola(coefficients, u), on_a_parabola(coefficients, -u)

    def told(*points, rest=end):
        return bool(is_fold(fold, *(jnp.asarray(x) for point in points for x in point), rest))

    assert told(here, other)
    # The path ends before the fold, or too close behind it to be sure.
    assert not told(here, other, rest=0.05)
    assert not told(here, other, rest=0.1)
    assert not told(here, here)
    # Going the same way, standing still, and a long way from where it was expected.
    assert not told(here, (other[0], here[1]))
    assert not told(here, (other[0], 0.0 * here[1]))
    assert not told(here, (other[0] + 0.5 * (other[0] - here[0]), other[1]))


def track(equations, start, path, **options):
    """One run, compiled."""

    def linearised(y, h):
        return equations(y, h), jax.jacfwd(equations)(y, h)

    correct = chord_corrector(equations, linearised)
    run = jax.jit(lambda y, h: follow(correct, y, h, **options))
    return run(jnp.asarray(start, float), jnp.asarray(path, float))


FOLD = 2.0 / 3.0**1.5
"""Of `y³ - y = h` from its lower branch: there `3 y² = 1`."""


@pytest.mark.parametrize("beyond", [1.0, 0.3, 1e-2, 1e-3, -1e-3, -1e-2, -0.3])
def test_folds_end_a_branch_in_fewer_steps(beyond):
    path = [[-1.0], [FOLD * (1.0 + beyond)]]
    start = [np.min(np.real(np.roots([1.0, 0.0, -1.0, 1.0])))]
    found, slow = (
        track(lambda y, h: y**3 - y - h, start, path, folds=folds) for folds in (True, False)
    )
    assert int(found.status) == int(slow.status)
    assert int(found.status) == (Status.LOST if beyond > 0.0 else Status.SOLVED)
    h = -1.0 + float(found.progress) * (path[1][0] + 1.0)
    np.testing.assert_allclose(found.y[0] ** 3 - found.y[0], h, atol=1e-9)
    assert float(found.y[0]) <= -1.0 / np.sqrt(3.0) + 1e-9
    if beyond > 0.1:
        assert int(found.steps) < 0.7 * int(slow.steps)


def test_each_point_looks_across_once():
    """To a branch whose other side is never found."""
    across = []

    def correct(predicted, _, h, dh, reach):
        y = jnp.sqrt(jnp.maximum(0.5 - h, 1e-30))
        jax.debug.callback(lambda *at: across.append(at), h[0], predicted[0], ordered=True)
        return Corrected(y, (h[0] < 0.5) & (predicted[0] > 0.0), jnp.ones(()), -0.5 / y * dh)

    found = follow(correct, jnp.array([0.5**0.5]), jnp.array([[0.0], [1.0]]), folds=True)
    jax.effects_barrier()
    assert int(found.status) == Status.LOST
    looked = [float(h) for h, predicted in across if predicted < 0.0 and h < 0.5]
    assert len(looked) == len(set(looked)) > 3


@pytest.mark.parametrize("gap", [1e-1, 1e-2, 1e-3])
def test_a_branch_that_bends_beside_a_fold_goes_on(gap):
    """`y³ - h y = gap`: from h = -1 it turns into `sqrt(h)`, a fold of others close to it."""
    ends = []
    for h in (-1.0, 1.0):
        roots = np.roots([1.0, 0.0, -h, -gap])
        ends.append(np.max(np.real(roots[np.abs(np.imag(roots)) < 1e-9])))
    found = track(lambda y, h: y**3 - h * y - gap, [ends[0]], [[-1.0], [1.0]], folds=True)
    assert int(found.status) == Status.SOLVED
    np.testing.assert_allclose(found.y, ends[1], atol=1e-8)
