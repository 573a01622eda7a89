"""Batches with their lanes last give what a Python loop gives, under any nesting of `vmap`."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.lanes import lanes_last

RNG = np.random.default_rng(0)
OUTER, MIDDLE, INNER = 2, 3, 4


def physics(body, scale, shift):
    """Any function of a pytree, a scalar and a vector; its outputs differ in shape."""
    vector, scalar = body["vector"], body["scalar"]
    product = scale * jnp.sum(vector**2) * jnp.prod(jnp.sin(shift)) + scalar
    return {"outer": jnp.outer(vector, shift) * scalar, "number": product}


@lanes_last
def kernel(lift, body, scale, shift):
    return lift(physics)(body, scale, shift)


def random(*shape):
    return jnp.asarray(RNG.normal(size=shape))


def body(*batch):
    return {"vector": random(*batch, 3), "scalar": random(*batch)}


def same(found, expected):
    def close(f, e):
        np.testing.assert_allclose(f, e, rtol=1e-14, atol=1e-15)

    jax.tree.map(close, found, expected)


def stack(results):
    return jax.tree.map(lambda *leaves: np.stack(leaves), *results)


def test_a_single_call():
    arguments = body(), random(), random(2)
    same(kernel(*arguments), physics(*arguments))


@pytest.mark.parametrize("wrap", [lambda f: f, jax.jit], ids=["eager", "jit"])
def test_one_batch_with_arguments_in_and_out_of_it(wrap):
    bodies, scale, shifts = body(INNER), random(), random(INNER, 2)
    found = wrap(jax.vmap(kernel, in_axes=(0, None, 0)))(bodies, scale, shifts)
    expected = stack(
        [physics(jax.tree.map(lambda x, k=k: x[k], bodies), scale, shifts[k]) for k in range(INNER)]
    )
    same(found, expected)


@pytest.mark.parametrize("wrap", [lambda f: f, jax.jit], ids=["eager", "jit"])
def test_three_nested_batches_each_of_other_arguments(wrap):
    """Every argument, and every leaf of one, belongs to a batch of its own."""
    batch = {"vector": random(MIDDLE, INNER, 3), "scalar": random(INNER)}
    scales, shifts = random(OUTER), random(MIDDLE, 2)
    inner = jax.vmap(kernel, in_axes=({"vector": 0, "scalar": 0}, None, None))
    middle = jax.vmap(inner, in_axes=({"vector": 0, "scalar": None}, None, 0))
    outer = wrap(jax.vmap(middle, in_axes=(None, 0, None)))
    found = outer(batch, scales, shifts)
    for i, j, k in np.ndindex(OUTER, MIDDLE, INNER):
        case = {"vector": batch["vector"][j, k], "scalar": batch["scalar"][k]}
        alone = physics(case, scales[i], shifts[j])
        same(jax.tree.map(lambda x, at=(i, j, k): x[at], found), alone)


def test_batches_along_other_axes():
    vectors, shifts = random(3, INNER), random(2, INNER)
    inputs = {"vector": vectors, "scalar": jnp.asarray(0.5)}
    axes = ({"vector": 1, "scalar": None}, None, -1)
    found = jax.vmap(kernel, in_axes=axes, out_axes=-1)(inputs, 2.0, shifts)
    for k in range(INNER):
        alone = physics({"vector": vectors[:, k], "scalar": 0.5}, 2.0, shifts[:, k])
        same(jax.tree.map(lambda x, k=k: x[..., k], found), alone)


def test_a_batch_of_one_and_a_batch_of_none():
    arguments = body(1), random(1), random(1, 2)
    found = jax.vmap(kernel)(*arguments)
    same(found, stack([physics(*jax.tree.map(lambda x: x[0], arguments))]))
    empty = jax.vmap(kernel)(body(0), random(0), random(0, 2))
    assert empty["outer"].shape == (0, 3, 2) and empty["number"].shape == (0,)


def test_lanes_reach_the_kernel_last_and_merged():
    seen = []

    @lanes_last
    def spy(lift, x, y):
        seen.append((x.shape, y.shape))
        return lift(lambda x, y: jnp.sum(x) * y)(x, y)

    nested = jax.vmap(jax.vmap(spy, in_axes=(0, None)))
    nested(random(OUTER, INNER, 5), random(OUTER))
    assert seen[-1] == ((5, OUTER * INNER), (OUTER * INNER,))


def test_inside_of_loops_and_conditions():
    """`scan` and `cond` under `vmap` see the same numbers as alone."""

    def program(x, steps):
        def body(carry, _):
            return kernel({"vector": carry, "scalar": 0.1}, 0.3, steps)["outer"] @ steps, None

        looped, _ = jax.lax.scan(body, x, None, length=3)
        return jax.lax.cond(looped[0] > 0.0, lambda: looped, lambda: -looped)

    xs, steps = random(INNER, 3), random(2)
    found = jax.vmap(program, in_axes=(0, None))(xs, steps)
    np.testing.assert_allclose(found, np.stack([program(x, steps) for x in xs]), rtol=1e-13)


def test_numbers_of_python_are_arguments_too():
    found = jax.vmap(lambda v: kernel({"vector": v, "scalar": 1}, 2.0, np.ones(2)))(np.eye(3))
    expected = stack([physics({"vector": v, "scalar": 1}, 2.0, np.ones(2)) for v in np.eye(3)])
    same(found, expected)
