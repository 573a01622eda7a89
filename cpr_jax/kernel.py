"""Loops that XLA's CPU back end compiles into one kernel.

By default every loop over elements in the body of a loop is a kernel of its own, started by an
interpreter that takes longer than a short kernel itself. One kernel for all of them is a function
that runs on one core: its arrays are best small enough for the cache of that core.
"""

import functools
from collections.abc import Callable
from typing import Any

import jax
from jax.experimental.xla_metadata import set_xla_metadata

_NAME = "one_kernel"


def one_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Asks for a function to become one kernel, wherever `once` carries it out.

    The request outlives derivatives and batches.

    **Arguments:**

    - `function`: elementwise arithmetic in loops; reductions and contractions are not for it.
    """

    # A name is what every transformation of a call hands on.
    def one_kernel(*args):
        return function(*args)

    return jax.jit(one_kernel)


def is_one_kernel(equation) -> bool:
    """Whether a call in a traced program was made by `one_kernel`."""
    return _NAME in equation.params.get("name", "")


def called(function: Callable[..., Any], *args: Any, whole: bool = False) -> Any:
    """A call that XLA does not inline.

    **Arguments:**

    - `whole`: whether it becomes one kernel.
    """
    marks = {"inlineable": "false"} | ({"xla_cpu_small_call": "true"} if whole else {})

    @functools.wraps(function)
    def unmarked(*args):
        # The marks are for the call, not for what it does.
        with set_xla_metadata(**dict.fromkeys(marks)):
            return function(*args)

    with set_xla_metadata(**marks):
        return jax.jit(unmarked)(*args)
