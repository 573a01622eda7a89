"""Loops that XLA's CPU back end compiles into one kernel.

By default every loop over elements in the body of a loop is a kernel of its own, started by an
interpreter that takes longer than a short kernel itself. One kernel for all of them is a function
that runs on one core: its arrays are best small enough for the cache of that core.
"""

import functools
import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax.experimental.xla_metadata import set_xla_metadata

_NAME, _PACKED = "one_kernel", "kernel_of_packs"


def one_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Asks for a function to become one kernel, wherever `once` carries it out.

    The request outlives derivatives and batches.

    **Arguments:**

    - `function`: elementwise arithmetic in loops; reductions and contractions are not for it, nor
        arrays of some hundred kilobytes: XLA would spread those over several cores, which it cannot
        within a kernel. Of each type of its arguments, what it returns must depend on one at least.
    """

    # A name is what every transformation of a call hands on.
    def one_kernel(*args):
        return function(*args)

    return jax.jit(one_kernel)


def is_one_kernel(equation) -> bool:
    """Whether a call in a traced program was made by `one_kernel`."""
    return _NAME in equation.params.get("name", "")


def as_one_kernel(function: Callable[..., list], args: list) -> list:
    """A call that becomes one kernel.

    XLA aborts the process where a kernel has an argument that it does not need, as it seeks that
    one's place among those that are needed. So all arguments of one type go in as one array.
    """
    traced = [k for k, arg in enumerate(args) if isinstance(arg, jax.core.Tracer)]
    types: dict[Any, list[int]] = {}
    for k in traced:
        types.setdefault(args[k].dtype, []).append(k)

    def unpacked(*packs):
        found = list(args)
        for pack, members in zip(packs, types.values(), strict=True):
            start = 0
            for k in members:
                size = math.prod(args[k].shape)
                part = jax.lax.slice(pack, (start,), (start + size,))
                found[k] = part.reshape(args[k].shape)
                start += size
        return function(found)

    packs = [jnp.concatenate([args[k].ravel() for k in members]) for members in types.values()]
    return kernel_of_packs(unpacked, packs)


def kernel_of_packs(function: Callable[..., list], packs: list) -> list:
    """A call that becomes one kernel, of one array of each type."""

    def packed(*packs):
        return function(*packs)

    packed.__name__ = _PACKED
    return called(packed, *packs, xla_cpu_small_call="true")


def is_kernel_of_packs(equation) -> bool:
    """Whether a call in a traced program is one that becomes one kernel."""
    return equation.params.get("name") == _PACKED


def called(function: Callable[..., Any], *args: Any, **marks: str) -> Any:
    """A call that XLA does not inline, with further attributes for its compiler."""
    marks["inlineable"] = "false"

    @functools.wraps(function)
    def unmarked(*args):
        # The marks are for the call, not for what it does.
        with set_xla_metadata(**dict.fromkeys(marks)):
            return function(*args)

    with set_xla_metadata(**marks):
        return jax.jit(unmarked)(*args)
