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

from .traces import largest, loops_over_elements, operations

_NAME, _PACKED = "one_kernel", "kernel_of_packs"

_MOST_BYTES, _MOST_COST, _PER_BYTE = 2**19, 200_000, 10
"""From where on XLA spreads a loop over several cores: bytes that it reads and writes; or, where it
takes more than an operation for each of them, operations and so many for each byte (the cost model
of its `ParallelTaskAssignment`)."""

_MARGIN = 0.75
"""How much of that is made use of: XLA may fuse what was two loops."""

_SMALL, _FEW = 400, 512
"""Operations of a kernel up to which XLA is left to it, as what it then repeats costs less than
what is stored and read again; and elements of its largest array."""


def one_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Asks for a function to become one kernel, wherever `once` carries it out.

    The request outlives derivatives and batches.

    **Arguments:**

    - `function`: elementwise arithmetic in loops; reductions and contractions are not for it. Of
        each type of its arguments, what it returns must depend on one at least. Where its arrays
        are large, see `fits_a_kernel`, it stays what it is.
    """

    # A name is what every transformation of a call hands on.
    def one_kernel(*args):
        return function(*args)

    return jax.jit(one_kernel)


def is_one_kernel(equation) -> bool:
    """Whether a call in a traced program was made by `one_kernel`."""
    return _NAME in equation.params.get("name", "")


def fits_a_kernel(jaxpr) -> bool:
    """Whether XLA can make a traced program one kernel.

    It spreads long loops over several cores, which it cannot within a kernel: compilation ends
    with `Symbols not found`, or with `Incorrect number of arguments`.
    """
    return not any(_is_spread(*loop) for loop in loops_over_elements(jaxpr))


def _is_spread(operations: int, moved: int) -> bool:
    if operations > _MARGIN * moved:
        return operations + _PER_BYTE * moved > _MARGIN * _MOST_COST
    return moved > _MARGIN * _MOST_BYTES


def is_small(jaxpr) -> bool:
    """Whether XLA is best left to the program of a kernel."""
    return operations(jaxpr) < _SMALL and largest(jaxpr) <= _FEW


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
