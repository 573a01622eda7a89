"""Calls that are traced late give what they give at once."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.custom_batching import custom_vmap

from cpr_jax.lazy import is_lazy, lazily, traced
from cpr_jax.once import once

RNG = np.random.default_rng(0)
X, Y = RNG.normal(size=(2, 4))


def plain(x, y):
    return {"product": jnp.sin(x) * y, "sum": jnp.sum(x * y)}


def counted():
    """The lazy function, and a list of its traces."""
    traces = []

    def function(x, y):
        traces.append(x.shape)
        return plain(x, y)

    def outline(x, y):
        return {"product": x, "sum": jax.ShapeDtypeStruct((), x.dtype)}

    return lazily(function, outline), traces


def same(found, expected):
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-14), found, expected)


@pytest.mark.parametrize("wrap", [lambda f: f, jax.jit], ids=["eager", "jit"])
def test_values(wrap):
    same(wrap(counted()[0])(X, Y), plain(X, Y))


def test_a_call_is_traced_when_it_is_lowered():
    lazy, traces = counted()
    program = jax.jit(lazy).trace(X, Y)
    assert not traces
    program.lower()
    assert traces == [(4,)]


def test_what_a_rule_replaces_is_never_traced():
    lazy, traces = counted()
    function = custom_vmap(lazy)
    function.def_vmap(
        lambda size, batched, x, y: (jax.vmap(plain)(x, y), {"product": True, "sum": True})
    )
    same(
        jax.jit(jax.vmap(function))(X[:, None], Y[:, None]), jax.vmap(plain)(X[:, None], Y[:, None])
    )
    assert not traces


@pytest.mark.parametrize("wrap", [lambda f: f, jax.jit], ids=["eager", "jit"])
def test_batches_and_derivatives(wrap):
    lazy, _ = counted()
    rows = RNG.normal(size=(3, 4))
    axes = (0, None)
    same(wrap(jax.vmap(lazy, in_axes=axes))(rows, Y), jax.vmap(plain, in_axes=axes)(rows, Y))
    for derivative in (jax.jacfwd, jax.jacrev, jax.hessian):
        same(wrap(derivative(lazy, argnums=1))(X, Y), derivative(plain, argnums=1)(X, Y))
    batch = jax.vmap(jax.jacfwd(lazy), in_axes=axes)
    same(wrap(batch)(rows, Y), jax.vmap(jax.jacfwd(plain), in_axes=axes)(rows, Y))


def test_whole_numbers_have_no_slope():
    lazy = lazily(lambda x, n: x * n, lambda x, n: x)
    np.testing.assert_array_equal(jax.grad(lambda x: jnp.sum(lazy(x, jnp.array(3))))(X), [3.0] * 4)


def test_a_program_can_be_looked_into():
    program = jax.make_jaxpr(counted()[0])(X, Y)
    (call,) = (equation for equation in program.eqns if is_lazy(equation))
    assert "sin" in {equation.primitive.name for equation in traced(call).eqns}


def test_what_is_to_be_calculated_once_is_seen_within():
    lazy, _ = counted()
    written = jax.make_jaxpr(once(lazy))(X, Y)
    assert not any(is_lazy(equation) for equation in written.eqns)
    same(jax.jit(once(lazy))(X, Y), plain(X, Y))
