"""Second derivatives of whole solves, their measures included, in mixed modes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.geometry import PLANE
from cpr_jax.rods.integration import rod_tip

LENGTH = 0.25


@pytest.fixture(scope="module")
def outcome():
    """Where the platform is and the energy there, the motors held, by the length of the rods."""
    at = cpr.solve_inverse(cpr.rfrfr(), (0.01, 0.2))

    def outcome(length):
        found = cpr.solve_forward(cpr.rfrfr(l=length), at.q_a, guess=at, throw=False)
        return found.q_p[1] + found.measures.energy

    return outcome


def test_mixed_modes_beside_differences_of_slopes(outcome):
    """What `jax.hessian` does, and reverse mode twice."""
    hessian = jax.jit(jax.jacfwd(lambda length: (jax.grad(outcome)(length),) * 2, has_aux=True))
    step = 1e-5
    expected = (hessian(LENGTH + step)[1] - hessian(LENGTH - step)[1]) / (2.0 * step)
    assert abs(expected) > 1.0
    forward, _ = hessian(LENGTH)
    np.testing.assert_allclose(forward, expected, rtol=1e-6)
    reverse = jax.jit(jax.grad(jax.grad(outcome)))(LENGTH)
    np.testing.assert_allclose(reverse, forward, rtol=1e-9)


@pytest.mark.parametrize("over", [jax.lax.map, lambda tip, lengths: jax.vmap(tip)(lengths)])
def test_rods_in_loops_and_in_batches(over):
    """Where a loop has lost the rule of a derivative, what it runs is differentiated."""
    load = jnp.array([0.1, 0.2]), jnp.array([0.01])

    def total(length):
        def tip(factor):
            rod = cpr.kirchhoff_rod(PLANE, length * factor, 0.02, 1.0)
            return rod_tip(PLANE, rod, *load).position[1]

        return jnp.sum(over(tip, jnp.array([1.0, 1.2, 0.8])))

    forward = jax.jit(jax.hessian(total))(LENGTH)
    twice = jax.jit(jax.jacfwd(jax.jacfwd(total)))(LENGTH)
    np.testing.assert_allclose(forward, twice, rtol=1e-12)
    slope = jax.jit(jax.grad(total))
    expected = (slope(LENGTH + 1e-5) - slope(LENGTH - 1e-5)) / 2e-5
    np.testing.assert_allclose(forward, expected, rtol=1e-7)
