"""Functions whose shared values are calculated once give what they gave before."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.once import once
from cpr_jax.statics.singular_values import norm_2

RNG = np.random.default_rng(0)


def ladder(x, y):
    """Each rung needs both results of the one before, so that copies double."""
    for k in range(12):
        shared = x * y + (x - y) * (0.5 + 0.01 * k) + 0.1 * x * x - 0.2 * y * y
        x, y = 0.1 * shared * y - 0.3 * x, 0.1 * shared * x + 0.2 * y
    return x, y


def with_loops(x, y):
    """A scan, a while loop of its own length in each lane, calls, a rule, views and constants."""

    def add(carry, k):
        x, y = carry
        both = jax.jit(ladder)(x, y)
        return both, both[0] * k

    (x, y), along = jax.lax.scan(add, (x, y), jnp.arange(3.0))
    count, x = jax.lax.while_loop(
        lambda s: jnp.abs(s[1]) < 2.0, lambda s: (s[0] + 1, 1.3 * s[1] + 0.5), (0, x)
    )
    table = jnp.asarray(RNG_TABLE)
    spread = jnp.broadcast_to(y, (3,))
    return norm_2(x * jnp.eye(2)) + count, table @ spread + along, jnp.sum(spread[:2]), 3.0


RNG_TABLE = RNG.normal(size=(3, 3))


@pytest.mark.parametrize("function", [ladder, with_loops])
def test_values_stay(function):
    lanes = RNG.normal(size=(2, 5))
    batched = jax.vmap(function)
    expected = jax.jit(batched)(*lanes)
    found = jax.jit(once(batched))(*lanes)
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-12), found, expected)


def test_derivatives_are_taken_before():
    x, y = RNG.normal(size=(2, 4))
    slopes = jax.vmap(jax.jacfwd(lambda x, y: ladder(x, y)[0], argnums=(0, 1)))
    jax.tree.map(
        lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-10),
        jax.jit(once(slopes))(x, y),
        slopes(x, y),
    )


def test_shared_values_are_not_calculated_again():
    """Products in the optimised program: as many as are written, or many copies of them."""
    if jax.default_backend() != "cpu":
        pytest.skip("only the back end for the CPU copies calculations")
    lanes = RNG.normal(size=(2, 64))

    def products(function):
        return jax.jit(function).lower(*lanes).compile().as_text().count(" multiply(")

    written = 12 * 12
    assert products(once(ladder)) <= written < products(ladder)


def test_a_sine_is_not_calculated_for_each_that_needs_it():
    """The turn of a vector by one angle: two components of which each needs both."""
    if jax.default_backend() != "cpu":
        pytest.skip("only the back end for the CPU copies calculations")

    def turned(angle, size):
        cosine, sine = jnp.cos(angle), jnp.sin(angle)
        return cosine * size - sine, sine * size + cosine

    lanes = RNG.normal(size=(2, 64))

    def calls(function):
        program = jax.jit(function).lower(*lanes).compile().as_text()
        return program.count(" cosine("), program.count(" sine(")

    assert calls(once(turned)) == (1, 1) and calls(turned) == (2, 2)
    np.testing.assert_allclose(jax.jit(once(turned))(*lanes), turned(*lanes), rtol=1e-14)


def test_small_functions_can_be_left_alone():
    lanes = RNG.normal(size=(2, 4))
    kept, changed = (jax.make_jaxpr(once(with_loops, least))(*lanes[:, 0]) for least in (10**6, 10))
    assert str(kept) == str(jax.make_jaxpr(with_loops)(*lanes[:, 0])) != str(changed)
