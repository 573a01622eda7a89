"""What a call of a program is surrounded by: other programs, devices, what JAX watches."""

import functools
from typing import Any

import jax
from jax.extend.core import get_opaque_trace_state

_WATCHED_BY = ("jax_disable_jit", "jax_debug_nans", "jax_debug_infs")

_outside: Any = None
"""JAX's state outside of all programs, once it is known: to compare it is quick."""


def is_within(arrays) -> bool:
    """Whether a call is part of another program, whose options hold for it then."""
    global _outside
    if any(isinstance(array, jax.core.Tracer) for array in arrays):
        return True
    state = get_opaque_trace_state()
    if state == _outside:
        return False
    # Within `jax.jit` even arithmetic on constants is traced.
    if isinstance(jax.lax.neg(0.0), jax.core.Tracer):
        return True
    _outside = state
    return False


def devices_of(arrays) -> tuple | None:
    """Where arrays lie, and which are bound to it; `None` if they lie on several devices."""
    if _is_single():
        # To ask each array takes as long as all the rest of a call.
        return ()
    found = [array for array in arrays if isinstance(array, jax.Array)]
    devices = frozenset().union(*(array.sharding.device_set for array in found))
    if len(devices) > 1:
        return None
    return devices, tuple(array.committed for array in found)


def is_watched() -> bool:
    """Whether JAX is to look at each call itself, for debugging."""
    return any(getattr(jax.config, name) for name in _WATCHED_BY)


@functools.cache
def _is_single() -> bool:
    """Whether there is but one device; beside a GPU there always is the CPU."""
    return jax.device_count() == 1 and jax.default_backend() == "cpu"
