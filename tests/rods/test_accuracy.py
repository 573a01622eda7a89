"""The integrator's order, and the honesty of the error estimate."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.geometry import PLANE
from cpr_jax.rods.integration import DEFAULT_STEPS, rod_tip
from cpr_jax.rods.rod import kirchhoff_rod
from tests.oracles import cosserat, elastica

LOAD = 3.0
EXACT = elastica.cantilever(LOAD)


def cantilever_tip(steps):
    """Tip of the elastica under `P L² / EI = 3` with the clamp's moment of the closed form."""
    rod = kirchhoff_rod(PLANE, 1.0, 1.0)
    return rod_tip(PLANE, rod, jnp.array([0.0, LOAD]), jnp.array([EXACT.moment]), steps)


def test_the_tip_converges_with_order_ten():
    counts = np.array([3, 4, 5])
    errors = []
    for steps in counts:
        position = cantilever_tip(int(steps)).position
        errors.append(np.max(np.abs(position - np.array([EXACT.along, EXACT.across]))))
    orders = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert errors[-1] > 1e-14, "rounding would hide the order"
    assert np.all(orders > 9.5), orders
    assert np.all(orders < 10.5), orders


def test_the_default_is_as_accurate_as_it_says():
    """Below 1e-9 of the length for rods that turn by less than 5 rad."""
    rng = np.random.default_rng(0)
    rods, forces, moments, exact, turned = [], [], [], [], []
    while len(rods) < 6:
        rest, force, moment = rng.uniform(-2, 2), rng.uniform(-8, 8, 2), rng.uniform(-4, 4, 1)
        oracle = cosserat.SpatialRod(1.0, np.ones(3), np.array([0.0, 0.0, rest]))
        s = np.linspace(0.0, 1.0, 101)
        p, R, *_ = cosserat.integrate(
            oracle, np.array([*force, 0.0]), np.array([0.0, 0.0, *moment]), s
        )
        turn = np.ptp(np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0])))
        if turn > 5.0:
            continue
        rods.append(kirchhoff_rod(PLANE, 1.0, 1.0, rest))
        forces.append(force)
        moments.append(moment)
        exact.append(p[-1, :2])
        turned.append(turn)
    assert max(turned) > 3.0
    found = jax.vmap(lambda rod, n, m: rod_tip(PLANE, rod, n, m, DEFAULT_STEPS).position)(
        jax.tree.map(lambda *leaves: jnp.stack(leaves), *rods), np.array(forces), np.array(moments)
    )
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize("steps", [2, 3, 4])
def test_doubled_steps_tell_the_error(steps):
    """Estimate over error stays near one, on rods that turn more and less than usual."""
    count = 6
    rng = np.random.default_rng(1)
    rests = rng.uniform(-3.0, 3.0, count)
    forces, moments = rng.uniform(-12.0, 12.0, (count, 2)), rng.uniform(-4.0, 4.0, (count, 1))
    rods = jax.vmap(lambda rest: kirchhoff_rod(PLANE, 1.0, 1.0, rest[None]))(rests)

    @jax.jit
    @jax.vmap
    def both(rod, n, m):
        return [rod_tip(PLANE, rod, n, m, count).position for count in (steps, 2 * steps)]

    positions, finer = both(rods, forces, moments)
    estimates = np.max(np.abs(positions - finer), axis=1)
    for k in range(count):
        oracle = cosserat.SpatialRod(1.0, np.ones(3), np.array([0.0, 0.0, rests[k]]))
        p, *_ = cosserat.integrate(
            oracle, np.array([*forces[k], 0.0]), np.array([0.0, 0.0, *moments[k]])
        )
        error = np.max(np.abs(positions[k] - p[-1, :2]))
        # Below this the oracle and rounding have a say.
        if error > 1e-11:
            assert 0.5 < estimates[k] / error < 2.0
        else:
            assert estimates[k] < 1e-10
    assert np.any(estimates > 1e-9)
