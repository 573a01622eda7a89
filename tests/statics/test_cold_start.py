"""Cold starts all over the outward branch, against a branch followed on another way."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.problem import Problem, inverse_rows
from cpr_jax.statics.residual import residual
from cpr_jax.statics.roots import find_root
from cpr_jax.statics.solve import solve_inverse
from cpr_jax.statics.status import Status
from cpr_jax.statics.unknowns import unknown_scales, unravel
from tests.statics.common import LANES

pytestmark = pytest.mark.optimised

STEP, COUNT = 0.005, 45
WALKS = 80
"""A step of the grid in m, steps of a walk, walks in a batch."""


@pytest.fixture(scope="module")
def walk(paper, published):
    """Natural continuation: Newton's method from each grid point to the next.

    A walk ends at the first Type 1 or Type 2 singularity, where one of the determinants changes
    its sign; what lies beyond can be reached around it in several ways.
    """
    units = unknown_scales(paper)

    def signs(y):
        jacobian = jax.jacfwd(lambda scaled: residual(paper, unravel(paper, scaled * units)))
        matrix = jacobian(y / units)
        without_point = jnp.concatenate([matrix[:, :2], matrix[:, 4:]], axis=1)
        return jnp.stack([jnp.linalg.slogdet(m)[0] for m in (without_point, matrix[:, 2:])])

    here = signs(published)

    @jax.jit
    @jax.vmap
    def walks(y, start, direction):
        def one(carry, k):
            y, alive = carry
            point = start + direction * STEP * (k + 1)
            target = jnp.concatenate([jnp.zeros(2), point])
            root = find_root(Problem(paper, inverse_rows(paper), target), y, verify=False)
            near = jnp.max(jnp.abs(root.y[:2] - y[:2])) < 0.3
            alive &= near & (root.status == Status.SOLVED) & jnp.all(signs(root.y) == here)
            y = jnp.where(alive, root.y, y)
            return (y, alive), (point, y, alive)

        return jax.lax.scan(one, (y, True), jnp.arange(COUNT))[1]

    def run(starts, ys, direction):
        fill = np.minimum(np.arange(WALKS), len(ys) - 1)
        directions = np.broadcast_to(direction, (len(ys), 2))[fill]
        points, ys, alive = walks(ys[fill], starts[fill], directions)
        points, ys, alive = (np.asarray(x)[: fill[-1] + 1] for x in (points, ys, alive))
        return points[alive], ys[alive]

    return run


@pytest.fixture(scope="module")
def branch(walk, published):
    """Points and unknowns on a grid: along a horizontal line, from there up and down."""
    start, y = np.array([[0.0, 0.2]]), np.asarray(published)[None]
    sideways = [walk(start, y, (side, 0.0)) for side in (-1.0, 1.0)]
    points = np.concatenate([start, *(p for p, _ in sideways)])
    ys = np.concatenate([y, *(y for _, y in sideways)])
    walks = [walk(points, ys, (0.0, side)) for side in (-1.0, 1.0)]
    return np.concatenate([p for p, _ in walks]), np.concatenate([y for _, y in walks])


def test_the_branch_covers_the_workspace(branch):
    points, _ = branch
    assert len(points) > 3000
    assert np.all(points.min(axis=0) < [-0.15, 0.0])
    assert np.all(points.max(axis=0) > [0.15, 0.30])


@pytest.fixture(scope="module")
def cold(branch, batch):
    points, ys = branch
    chosen = np.random.default_rng(0).choice(len(points), LANES, replace=False)
    equilibria, _ = batch(np.full((LANES, 2), 0.0183), points[chosen])
    return points[chosen], ys[chosen], equilibria


def test_cold_starts_are_solved_to_tolerance(paper, cold):
    """At least 99 %; a lone solve also tries detours, which a batch does not."""
    points, _, equilibria = cold
    solved = np.asarray(equilibria.status) == Status.SOLVED
    assert np.nanmax(equilibria.residual) < 1e-10
    for k in np.flatnonzero(~solved):
        again = solve_inverse(paper, points[k], throw=False)
        solved[k] = int(again.status) == Status.SOLVED
    assert np.mean(solved) >= 0.99


def test_no_cold_start_takes_another_branch(cold):
    _, ys, equilibria = cold
    solved = np.asarray(equilibria.status) == Status.SOLVED
    np.testing.assert_allclose(equilibria.q_a[solved], ys[solved, :2], rtol=0, atol=1e-8)
