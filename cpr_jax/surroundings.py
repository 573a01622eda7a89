"""What a call of a program is surrounded by: other programs, devices, what JAX watches."""

import contextlib
import functools
from collections.abc import Callable
from typing import Any, TypeVar

import jax
from jax.extend.core import get_opaque_trace_state

from .outline import are_traced

_WATCHED_BY = ("jax_disable_jit", "jax_debug_nans", "jax_debug_infs")

_outside: Any = None
"""JAX's state outside of all programs, once it is known: to compare it is quick."""


_Out = TypeVar("_Out")


def inherited(work: Callable[[], _Out]) -> Callable[[], _Out]:
    """The same work, for another thread: JAX keeps what `with` sets apart for each."""
    x64, device = set_here()

    def within() -> _Out:
        own_x64, own_device = set_here()
        with contextlib.ExitStack() as stack:
            # What is set once more would be another state to JAX.
            if own_x64 != x64:
                stack.enter_context(jax.enable_x64(x64))
            if own_device != device:
                stack.enter_context(jax.default_device(device))
            return work()

    return within


def set_here() -> tuple[bool, Any]:
    """Whether float64 is enabled, and the default device."""
    return bool(jax.config.read("jax_enable_x64")), getattr(jax.config, "jax_default_device", None)


def is_within(arrays) -> bool:
    """Whether a call is part of another program, whose options hold for it then."""
    global _outside
    if are_traced(arrays):
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


def is_on_cpu(arrays) -> bool:
    """Whether a program of these arrays runs on the CPU, be there a GPU or not."""
    bound = [each for each in arrays if isinstance(each, jax.Array) and each.committed]
    if bound:
        device: Any = next(iter(bound[0].sharding.device_set))
        return device.platform == "cpu"
    _, device = set_here()
    if device is None:
        return jax.default_backend() == "cpu"
    return getattr(device, "platform", device) == "cpu"


def is_watched() -> bool:
    """Whether JAX is to look at each call itself, for debugging."""
    return any(getattr(jax.config, name) for name in _WATCHED_BY)


@functools.cache
def _is_single() -> bool:
    """Whether there is but one device; beside a GPU there always is the CPU."""
    return jax.device_count() == 1 and jax.default_backend() == "cpu"
