"""Work spread over threads."""

import threading
import time

import jax
import jax.numpy as jnp
import pytest

from cpr_jax.parallel import WORKERS, in_parallel


@pytest.mark.parametrize("count", [0, 1, 2, 100])
def test_results_come_in_order(count):
    def late_if_early(k):
        time.sleep(0.01 if k % 7 == 0 else 0.0)
        return k**2

    assert in_parallel(late_if_early, range(count)) == [k**2 for k in range(count)]


def test_several_at_a_time():
    together = threading.Barrier(WORKERS)
    # Each waits for all others, which one thread could not do.
    assert sorted(in_parallel(lambda _: together.wait(timeout=10.0), range(WORKERS))) == list(
        range(WORKERS)
    )


def test_work_within_work_does_not_wait_for_itself():
    def outer(k):
        return sum(in_parallel(lambda j: j * k, range(20)))

    assert in_parallel(outer, range(20)) == [190 * k for k in range(20)]


def test_settings_of_the_caller_hold_for_its_helpers():
    """JAX keeps what `with` sets apart for each thread."""

    def kind(_):
        time.sleep(0.001)
        return jnp.zeros(1).dtype, threading.get_ident()

    for x64, expected in ((False, "float32"), (True, "float64")):
        with jax.enable_x64(x64):
            found = in_parallel(kind, range(100))
        assert {str(dtype) for dtype, _ in found} == {expected}
        assert len({thread for _, thread in found}) > 1


def test_a_failure_ends_the_rest():
    seen = []

    def fail(k):
        seen.append(k)
        time.sleep(0.01)
        if k == 3:
            raise ValueError("three")
        return k

    with pytest.raises(ValueError, match="three"):
        in_parallel(fail, range(1000))
    assert len(seen) < 100
    assert in_parallel(lambda k: k, range(5)) == list(range(5))
