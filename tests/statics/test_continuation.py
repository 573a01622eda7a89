"""Following roots of small problems whose branches are known."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.chord import chord_corrector
from cpr_jax.statics.continuation import Jet, follow
from cpr_jax.statics.status import Status


def corrector(equations):
    """By the equations and their derivative."""

    def linearised(y, h):
        return equations(y, h), jax.jacfwd(equations)(y, h)

    return chord_corrector(equations, linearised)


def track(equations, start, path, **options):
    """One run, compiled."""
    run = jax.jit(lambda y, h: follow(corrector(equations), y, h, **options))
    return run(jnp.asarray(start, float), jnp.asarray(path, float))


def test_a_smooth_branch_is_followed_to_its_end():
    """`y³ + y = h` has one root for each h."""
    found = track(lambda y, h: y**3 + y - h, [0.0], [[0.0], [10.0], [-30.0]])
    assert int(found.status) == Status.SOLVED
    assert float(found.progress) == 2.0
    np.testing.assert_allclose(found.y, [-3.0], rtol=1e-3)
    np.testing.assert_allclose(found.y**3 + found.y, -30.0, rtol=0, atol=1e-8)
    assert float(found.sign) == 1.0


@pytest.mark.parametrize("end", [1.0, 0.2, 50.0])
def test_a_fold_ends_the_branch(end):
    """`y² + h = 0` has the roots `±sqrt(-h)` and none beyond h = 0."""
    found = track(lambda y, h: y**2 + h, [1.0], [[-1.0], [end]])
    assert int(found.status) == Status.LOST
    # The last point is on the branch, before the fold and near it.
    reached = -1.0 + float(found.progress) * (end + 1.0)
    assert -0.05 * (1.0 + end) < reached <= 0.0
    assert float(found.y[0]) > 0.0
    np.testing.assert_allclose(found.y[0] ** 2, -reached, rtol=0, atol=1e-8)


def test_what_is_known_at_the_start_saves_steps():
    """`y² = h` from h = 1 to 1.3, where `y' = 0.3 / 2` and `y'' = -0.3² / 4` along the path."""
    path, found = [[1.0], [1.3]], []
    for curve in (None, 0.0, -0.0225):
        sign = jnp.array(1.0)
        jet = None if curve is None else Jet(jnp.array([0.15]), jnp.array([curve]), sign)
        found.append(track(lambda y, h: y**2 - h, [1.0], path, first_step=1.0, jet=jet))
        assert int(found[-1].status) == Status.SOLVED
        np.testing.assert_allclose(found[-1].y, [np.sqrt(1.3)], atol=1e-12)
    assert [int(each.steps) for each in found] == [2, 1, 1]
    # A prediction of second order deviates less, so that longer steps are accepted.
    far = [[1.0], [1.8]]
    steps = []
    for curve in (0.0, -0.16):
        jet = Jet(jnp.array([0.4]), jnp.array([curve]), jnp.array(1.0))
        steps.append(int(track(lambda y, h: y**2 - h, [1.0], far, first_step=1.0, jet=jet).steps))
    assert steps[1] < steps[0]


def test_a_cubic_takes_few_steps():
    """It is predicted but for errors of slopes; along tangents no step could exceed 0.05."""

    def equations(y, h):
        return y - (5.0 - 40.0 * h + 90.0 * h**2 - 60.0 * h**3)

    found = track(equations, [5.0], [[0.0], [1.0]], first_step=0.01)
    assert int(found.status) == Status.SOLVED
    assert int(found.steps) <= 16


def test_a_start_on_another_branch_is_not_taken():
    jet = Jet(jnp.array([0.15]), jnp.array([0.0]), jnp.array(-1.0))
    found = track(lambda y, h: y**2 - h, [1.0], [[1.0], [1.3]], first_step=1.0, jet=jet)
    assert int(found.status) == Status.LOST
    assert float(found.progress) == 0.0


def test_steps_that_run_out_are_not_a_fold():
    found = track(lambda y, h: y - jnp.sin(200.0 * h), [0.0], [[0.0], [1.0]], max_steps=5)
    assert int(found.status) == Status.NOT_CONVERGED
    assert 0.0 < float(found.progress) < 1.0


def test_a_path_that_is_not_finite():
    found = track(lambda y, h: y - h, [0.0], [[0.0], [np.nan]])
    assert int(found.status) == Status.NOT_FINITE


@pytest.mark.parametrize("gap", [0.3, 0.05, 0.01])
def test_two_close_branches_are_not_mixed_up(gap):
    """The branches `sin 5h` and `sin 5h + gap`; the determinant tells them apart."""

    def equations(y, h):
        on = y - jnp.sin(5.0 * h)
        return on * (on - gap)

    for start, offset in ((0.0, 0.0), (gap, gap)):
        found = track(equations, [start], [[0.0], [2.0]])
        assert int(found.status) == Status.SOLVED
        np.testing.assert_allclose(found.y, np.sin(10.0) + offset, rtol=0, atol=1e-6)


@pytest.mark.parametrize("gap", [0.3, 0.1])
def test_close_branches_of_equal_sign_are_not_mixed_up(gap):
    """Two branches with a third between them have determinants of the same sign."""

    def equations(y, h):
        on = y - jnp.sin(5.0 * h)
        return on * (on - gap / 2.0) * (on - gap)

    found = track(equations, [0.0], [[0.0], [2.0]])
    assert int(found.status) == Status.SOLVED
    np.testing.assert_allclose(found.y, np.sin(10.0), rtol=0, atol=1e-6)


def test_a_loop_around_a_branch_point_leads_to_the_other_root():
    """`z² = h` in the complex plane, once around the origin: z turns into -z."""

    def square(z, h):
        return jnp.stack([z[0] ** 2 - z[1] ** 2 - h[0], 2.0 * z[0] * z[1] - h[1]])

    corners = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]]
    once = track(square, [1.0, 0.0], corners)
    assert int(once.status) == Status.SOLVED
    np.testing.assert_allclose(once.y, [-1.0, 0.0], rtol=0, atol=1e-9)
    twice = track(square, [1.0, 0.0], corners + corners[1:])
    np.testing.assert_allclose(twice.y, [1.0, 0.0], rtol=0, atol=1e-9)


def test_a_start_near_the_root_is_polished():
    found = track(lambda y, h: y**3 + y - h, [1.01], [[2.0], [2.0]])
    assert int(found.status) == Status.SOLVED
    np.testing.assert_allclose(found.y, [1.0], rtol=0, atol=1e-8)


def test_lanes_follow_their_own_paths():
    """In a batch, a lane that is lost holds up none that is not."""

    def one(end):
        correct = corrector(lambda y, h: y**2 + h)
        return follow(correct, jnp.ones(1), jnp.array([[-1.0], [0.0]]).at[1].set(end))

    ends = jnp.array([-4.0, 1.0, -0.25, jnp.nan])
    found = jax.jit(jax.vmap(one))(ends)
    expected = [Status.SOLVED, Status.LOST, Status.SOLVED, Status.NOT_FINITE]
    assert list(np.asarray(found.status)) == expected
    np.testing.assert_allclose(found.y[np.array([0, 2]), 0], [2.0, 0.5], rtol=0, atol=1e-9)
