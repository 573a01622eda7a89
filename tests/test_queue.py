"""Loops that are queued, beside plain Python."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.queue import SLOTS, queued_loop


def collatz(start, stop=1, effort=None):
    """Steps until the Collatz sequence of a number reaches `stop`, and the numbers' sum."""

    def advance(state):
        number, steps, total = state
        number = jnp.where(number % 2 == 0, number // 2, 3 * number + 1)
        return number, steps + 1, total + number

    state = start, jnp.array(0), jnp.array(0)
    return queued_loop(lambda state: state[0] != stop, advance, state, effort)[1:]


def in_python(start, stop=1):
    steps = total = 0
    while start != stop:
        start = start // 2 if start % 2 == 0 else 3 * start + 1
        steps, total = steps + 1, total + start
    return steps, total


def expected(starts, stops):
    pairs = [in_python(int(a), int(b)) for a, b in zip(starts, stops, strict=True)]
    return np.array(pairs).T


def test_a_single_case():
    assert tuple(map(int, collatz(jnp.array(27)))) == in_python(27)


@pytest.mark.parametrize("ordered", [False, True])
@pytest.mark.parametrize("lanes", [1, SLOTS - 1, SLOTS, SLOTS + 1, 700])
def test_every_lane_ends_where_it_ends_alone(lanes, ordered):
    # 1 is there at the start, as are a third of these: they wait for no slot.
    starts = np.maximum(np.arange(1, lanes + 1) - lanes // 3, 1)

    def one(start):
        return collatz(start, effort=1.0 * start if ordered else None)

    found = jax.jit(jax.vmap(one))(jnp.asarray(starts))
    np.testing.assert_array_equal(np.stack(found), expected(starts, np.ones(lanes)))


@pytest.mark.parametrize("closed", [False, True])
def test_what_differs_may_be_the_state_or_what_is_closed_over(closed):
    # Every number below 300 comes by 4 and by 2, but for 1, 2 and 4 themselves.
    starts = np.tile([7] if closed else np.arange(5, 305), 300 if closed else 1)
    stops = np.random.default_rng(0).choice([1, 2, 4], 300)
    if closed:
        found = jax.vmap(lambda stop: collatz(jnp.array(7), stop))(jnp.asarray(stops))
    else:
        found = jax.vmap(collatz)(jnp.asarray(starts), jnp.asarray(stops))
    np.testing.assert_array_equal(np.stack(found), expected(starts, stops))


def test_batches_of_batches():
    starts, stops = np.arange(5, 15), np.array([1, 2, 4])
    inner = jax.vmap(collatz, in_axes=(None, 0))
    found = np.stack(jax.vmap(inner, in_axes=(0, None))(jnp.asarray(starts), jnp.asarray(stops)))
    np.testing.assert_array_equal(
        found.reshape(2, -1), expected(np.repeat(starts, 3), np.tile(stops, 10))
    )


def calls_for(ends, efforts) -> int:
    """How many times, lane by lane, a body is run."""
    calls = []

    def one(end, effort):
        def advance(count):
            jax.debug.callback(lambda: calls.append(1))
            return count + 1

        return queued_loop(lambda count: count < end, advance, jnp.array(0), effort)

    found = jax.vmap(one)(jnp.asarray(ends), jnp.asarray(efforts, float))
    jax.effects_barrier()
    np.testing.assert_array_equal(found, ends)
    return len(calls)


def test_a_slow_lane_makes_the_others_wait_no_longer_than_it_takes():
    ends = np.full(8 * SLOTS, 5)
    ends[-1] = 100
    # All in step would be 100 for each lane; a slow lane that comes last has all others wait.
    assert calls_for(ends, np.zeros(ends.size)) <= SLOTS * (8 * 5 + 100)


def test_what_is_expected_to_be_slow_begins_first():
    ends = np.full(20 * SLOTS, 5)
    ends[-1] = 100
    assert calls_for(ends, ends) <= SLOTS * (20 * 5 + 5)
