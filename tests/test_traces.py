"""What traced programs consist of."""

import jax
import jax.numpy as jnp

from cpr_jax.lazy import lazily
from cpr_jax.traces import largest, loops_over_elements, operations

BYTES = 8


def traced(function, *args):
    return jax.make_jaxpr(function)(*args).jaxpr


def test_operations_of_loops_and_calls_count_once_each():
    def step(_, y):
        return jnp.sin(y) + 1.0

    plain = operations(traced(lambda y: step(0, y), 1.0))
    assert plain == 2
    called = operations(traced(lambda y: jax.jit(lambda y: step(0, y))(y), 1.0))
    assert called == plain + 1
    later = lazily(lambda y: step(0, y), lambda y: jax.ShapeDtypeStruct((), y.dtype))
    assert operations(traced(later, 1.0)) == plain + 1
    repeated = traced(lambda y, n: jax.lax.fori_loop(0, n, step, y), 1.0, 5)
    assert operations(repeated) >= plain + 1


def test_the_largest_array_is_found_within_loops_and_calls():
    x = jnp.ones(10)

    def function(x):
        return jnp.sum(jnp.outer(x, x) ** 2, axis=0)

    assert largest(traced(lambda x: x, x)) == 0
    assert largest(traced(function, x)) == 100
    assert largest(traced(jax.jit(function), x)) == 100
    looped = traced(lambda x, n: jax.lax.fori_loop(0, n, lambda _, y: function(y), x), x, 3)
    assert largest(looped) == 100


def test_a_call_is_one_loop_over_elements_and_an_operation_is_one():
    x, y = jnp.ones(10), jnp.ones((3, 10))

    def product(x, y):
        return (x * y + 1.0) * x

    alone = sorted(loops_over_elements(traced(lambda y: jnp.sin(y) + 1.0, y)))
    # The second loop has a constant among what it reads.
    assert alone == [(30, 2 * 30 * BYTES), (30, 2 * 30 * BYTES + BYTES)]
    together = traced(jax.jit(product), x, y)
    assert list(loops_over_elements(together)) == [(3 * 30, (10 + 30 + 30) * BYTES)]
    looped = traced(lambda n: jax.lax.fori_loop(0, n, lambda _, y: jax.jit(product)(x, y), y), 3)
    assert (3 * 30, (10 + 30 + 30) * BYTES) in list(loops_over_elements(looped))
    joined = traced(lambda x, y: jax.lax.concatenate([x, y[0]], 0), x, y)
    assert list(loops_over_elements(joined))[-1] == (0, 2 * 20 * BYTES)
