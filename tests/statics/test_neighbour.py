"""A guess from a robot with slightly other numbers leads where a cold start leads."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.statics.solve import solve_forward, solve_inverse
from cpr_jax.statics.status import Status


@pytest.mark.parametrize(
    "numbers",
    [
        *({"l": 0.245}, {"l": 0.27}, {"a": 0.05}, {"b": 0.03}, {"d": 0.21}),
        *({"k_b": 0.006}, {"k_b": 0.015}, {"k_b": 0.05}),
        *({"f_P": (0.0, force)} for force in (6.0, 4.0, 3.0, -1.0, -3.0)),
        {"k_b": 0.01, "f_P": (0.5, 3.0)},
    ],
    ids=str,
)
def test_a_guess_of_another_design(nominal, numbers):
    other = rfrfr(**numbers)
    for solve, target in ((solve_inverse, nominal.q_p), (solve_forward, nominal.q_a)):
        followed = solve(other, target, guess=nominal)
        cold = solve(other, target)
        assert int(followed.status) == Status.SOLVED
        np.testing.assert_allclose(followed.y, cold.y, atol=1e-10)


@pytest.mark.parametrize("point", [(0.06, 0.15), (-0.05, 0.1), (0.03, 0.1)])
def test_a_guess_of_any_stiffness_nearby(paper, point):
    """The factor of its wrenches is between those that are tried, wherever that is."""
    nominal = solve_inverse(paper, point)
    for share in (*np.linspace(0.9, 1.1, 15), 0.5, 0.63, 0.8, 1.3, 1.7):
        other = rfrfr(k_b=0.0183 * share)
        followed = solve_inverse(other, point, guess=nominal, throw=False)
        assert int(followed.status) == Status.SOLVED, share
        np.testing.assert_allclose(followed.y, solve_inverse(other, point).y, rtol=0, atol=1e-9)


def test_a_neighbour_under_heavy_load(paper):
    """Where multiples of its wrenches overflow, a guess is still taken as it is."""
    equilibrium = solve_inverse(paper, (0.05, 0.06))
    for z in (0.055, 0.0525, 0.05, 0.045):
        equilibrium = solve_inverse(paper, (0.05, z), guess=equilibrium)
        assert int(equilibrium.status) == Status.SOLVED
    cold = solve_inverse(paper, (0.05, 0.045))
    np.testing.assert_allclose(equilibrium.y, cold.y, rtol=0, atol=1e-9)


def test_a_trajectory_in_a_loop(paper):
    """`jax.lax.scan` carries the equilibrium along; the way is that of single solves."""
    points = jnp.stack([jnp.linspace(0.0, 0.04, 4), jnp.linspace(0.2, 0.18, 4)], axis=1)
    start = solve_inverse(paper, points[0])

    def step(now, point):
        new = solve_inverse(paper, point, guess=now)
        return new, (new.q_a, new.status)

    _, (q_a, status) = jax.lax.scan(step, start, points)
    assert np.all(status == Status.SOLVED)
    alone = [solve_inverse(paper, point).q_a for point in points]
    np.testing.assert_allclose(q_a, alone, rtol=0, atol=1e-8)
