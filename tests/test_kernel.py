"""Loops in one kernel: the same numbers, and no argument that XLA cannot place."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.kernel import one_kernel
from cpr_jax.once import once

LANES = 16


def grown(x, rate, unused, steps):
    """Compound growth, beside something that no result needs."""
    del unused
    return jax.lax.fori_loop(0, steps, lambda _, y: y * (1.0 + rate), x)


@pytest.fixture
def numbers():
    x = jnp.linspace(1.0, 2.0, LANES)
    return x, jnp.asarray(0.1), jnp.full((3, LANES), 7.0), jnp.asarray(5)


def compiled(function, *args):
    return jax.jit(once(function)).lower(*args).compile()


def test_a_kernel_calculates_what_its_function_does(numbers):
    x = np.asarray(numbers[0])
    np.testing.assert_allclose(
        compiled(one_kernel(grown), *numbers)(*numbers), x * 1.1**5, rtol=1e-14
    )


def test_the_request_outlives_derivatives_and_batches(numbers):
    x, rate, unused, steps = numbers

    def slope(x):
        return jax.jvp(
            lambda rate: one_kernel(grown)(x, rate, unused[:, 0], steps), (rate,), (1.0,)
        )

    program = compiled(jax.vmap(slope), x)
    if jax.default_backend() == "cpu":
        assert "xla_cpu_small_call" in program.as_text()
    value, derivative = program(x)
    np.testing.assert_allclose(value, x * 1.1**5, rtol=1e-14)
    np.testing.assert_allclose(derivative, 5 * x * 1.1**4, rtol=1e-14)


def test_a_kernel_stays_one_where_a_program_becomes_part_of_another(numbers):
    """As one of single cases does within one on lanes."""

    @jax.jit
    @once
    def part(*args):
        return 2.0 * one_kernel(grown)(*args)

    lowered = jax.jit(once(lambda *args: part(*args))).lower(*numbers)
    if jax.default_backend() == "cpu":
        assert lowered.as_text().count("xla_cpu_small_call") == 1
    program = lowered.compile()
    x = np.asarray(numbers[0])
    np.testing.assert_allclose(program(*numbers), 2.0 * x * 1.1**5, rtol=1e-14)


def test_constants_and_arguments_that_nothing_needs_do_no_harm(numbers):
    x, _, unused, _ = numbers

    def function(x, unused):
        return one_kernel(grown)(x, 0.1, unused, 5)

    np.testing.assert_allclose(compiled(function, x, unused)(x, unused), x * 1.1**5, rtol=1e-14)


@pytest.mark.parametrize(
    ("operations", "lanes"),
    [(1, 100_000), (30, 1_500), (30, 100_000)],
    ids=["long", "hard", "both"],
)
def test_arrays_that_go_to_several_cores_are_no_part_of_a_kernel(operations, lanes):
    """XLA cannot compile a kernel within which it spreads a loop over cores."""

    def function(x):
        y = jnp.concatenate([x[1:], x[:1]])
        for _ in range(operations):
            y = y * x + 1.0
        return y

    x = np.linspace(0.0, 0.5, lanes)
    found = compiled(one_kernel(function), x)(x)
    y = np.roll(x, -1)
    for _ in range(operations):
        y = y * x + 1.0
    np.testing.assert_allclose(found, y, rtol=1e-14)


def test_what_large_arrays_are_moved_for_is_a_kernel():
    """An array of many numbers that are calculated with one by one."""
    if jax.default_backend() != "cpu":
        pytest.skip("only the back end for the CPU has such kernels")
    packs = np.ones((60, 128))

    def function(pack):
        return jnp.concatenate([part * pack[0] for part in pack])

    assert "xla_cpu_small_call" in compiled(one_kernel(function), packs).as_text()
