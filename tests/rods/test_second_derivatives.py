"""Second derivatives of a rod's tip: differences of Jacobians, forward and reverse mode."""

import jax
import numpy as np

from cpr_jax.geometry import PLANE, SPACE
from tests.rods.common import differences, tip_of


def test_second_derivatives_in_space():
    subject = tip_of(SPACE)
    hessian = jax.jit(jax.jacfwd(jax.jacfwd(subject)))(subject.x)
    expected = differences(subject.jacobian, subject.x, 1e-3)
    np.testing.assert_allclose(hessian, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(hessian, np.swapaxes(hessian, 1, 2), rtol=0, atol=1e-12)


def test_second_derivatives_in_reverse():
    planar = tip_of(PLANE)
    weights = np.random.default_rng(6).normal(size=planar.value(planar.x).size)

    def scalar(x):
        return weights @ planar(x)

    reverse = jax.jit(jax.jacrev(jax.grad(scalar)))(planar.x)
    expected = differences(lambda x: weights @ planar.jacobian(x), planar.x, 1e-3)
    np.testing.assert_allclose(reverse, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(reverse, reverse.T, rtol=0, atol=1e-12)
