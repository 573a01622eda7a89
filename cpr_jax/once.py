"""Programs in which XLA calculates no value twice.

Where several results need one value, XLA's CPU back end copies its calculation into the loop of
each of them, and so do those that need these: in long algebra on small vectors the work grows
without bound. `once` cuts a function where values are shared.
"""

import functools
from collections import Counter
from collections.abc import Callable
from typing import Any

import jax
from jax.extend import core

from .kernel import (
    as_one_kernel,
    called,
    fits_a_kernel,
    is_kernel_of_packs,
    is_one_kernel,
    is_small,
    kernel_of_packs,
)
from .lazy import is_lazy
from .traces import CALLS, LOOPS, VIEWS, inner, name_of, operations

_LEAST = 8
"""Operations on an element that are rather repeated than their result stored and read again."""

_LONG = frozenset(
    {"acos", "asin", "atan2", "cos", "exp", "expm1", "log", "log1p", "pow", "sin", "tan", "tanh"}
)
"""Operations that take as long as many others: calls, element by element, of a mathematical
library."""

_LONGER = 20
"""How many others that are."""

_APART = frozenset({"dot_general", "dynamic_slice", "dynamic_update_slice", "gather", "sort"})
"""What is not part of a loop over elements."""


def once(function: Callable[..., Any], least: int = 0) -> Callable[..., Any]:
    """The same function, each shared value of which is calculated once and kept in memory.

    Between two of these values a program is one loop over elements. Loops are entered, and calls
    are inlined; the result is no longer to be differentiated or batched by custom rules.

    **Arguments:**

    - `least`: number of operations below which a function stays as it is.
    """

    @functools.wraps(function)
    def calculated(*args):
        if jax.default_backend() != "cpu":
            return function(*args)
        program, shape = jax.make_jaxpr(function, return_shape=True)(*args)
        leaves = jax.tree.leaves(args)
        if operations(program.jaxpr) < least:
            values = _as_is(program, leaves)
        else:
            values = _finished(program, leaves)
        return jax.tree.unflatten(jax.tree.structure(shape), values)

    return calculated


class _Pending:
    """An operation that its only reader will carry out."""

    def __init__(self, equation, inputs):
        self.equation, self.inputs = equation, inputs
        self.value: Any = None
        self.effort = sum(entry.effort for entry in inputs if _is_pending(entry))
        name = name_of(equation)
        self.effort += _LONGER if name in _LONG else name not in VIEWS

    def bind(self, *values):
        return self.equation.primitive.bind(*values, **self.equation.params)


def _as_is(program, args) -> list:
    return core.jaxpr_as_fun(program)(*args)


def _finished(program, args) -> list:
    return [_value(entry) for entry in _evaluate(program.jaxpr, program.consts, args)]


def _evaluate(jaxpr, constants, args) -> list:
    """Values, or what they are pending on, of a program's results."""
    uses = Counter(
        variable
        for variables in (*(equation.invars for equation in jaxpr.eqns), jaxpr.outvars)
        for variable in variables
        if not isinstance(variable, core.Literal)
    )
    known: dict[Any, Any] = {}

    def put(variable, entry):
        known[variable] = entry
        if _is_pending(entry) and (uses[variable] - 1) * entry.effort > _LEAST:
            _value(entry)

    def get(variable):
        return variable.val if isinstance(variable, core.Literal) else known[variable]

    for variable, entry in zip(jaxpr.constvars, constants, strict=True):
        known[variable] = entry
    for variable, entry in zip(jaxpr.invars, args, strict=True):
        put(variable, entry)
    for equation in jaxpr.eqns:
        results = _results(equation, [get(variable) for variable in equation.invars])
        for variable, entry in zip(equation.outvars, results, strict=True):
            put(variable, entry)
    return [get(variable) for variable in jaxpr.outvars]


def _results(equation, inputs) -> list:
    name, primitive = name_of(equation), equation.primitive
    if name in CALLS or is_lazy(equation):
        (program,) = inner(equation)
        if is_kernel_of_packs(equation):
            # Made by `once` before: a program of single cases may be part of one on lanes.
            values = [_value(entry) for entry in inputs]
            return kernel_of_packs(lambda *packs: _as_is(program, packs), values)
        if is_one_kernel(equation):
            values = [_value(entry) for entry in inputs]
            kernel = _kernel(program, values)
            if fits_a_kernel(kernel.jaxpr):
                return as_one_kernel(functools.partial(_as_is, kernel), values)
        return _evaluate(program.jaxpr, program.consts, inputs)
    if primitive.multiple_results or name in _APART:
        params = dict(equation.params)
        if name in LOOPS:
            params[LOOPS[name]] = _in_loop(params[LOOPS[name]])
        results = primitive.bind(*(_value(entry) for entry in inputs), **params)
        return results if primitive.multiple_results else [results]
    return [_Pending(equation, inputs)]


def _kernel(program, values):
    """What one kernel is to do, of arguments like the values; constants among these are in it."""
    carry_out = _as_is if is_small(program.jaxpr) else _finished

    def carried_out(*args):
        pairs = zip(args, values, strict=True)
        return carry_out(program, [a if isinstance(v, jax.core.Tracer) else v for a, v in pairs])

    return jax.make_jaxpr(carried_out)(*values)


def _in_loop(body):
    """The body of a loop, rewritten likewise."""
    return jax.make_jaxpr(lambda *args: _finished(body, args))(*body.in_avals)


def _is_pending(entry) -> bool:
    return isinstance(entry, _Pending) and entry.value is None


def _value(entry):
    """What an entry is, calculated in one loop with all that it is pending on."""
    if not isinstance(entry, _Pending):
        return entry
    if entry.value is None:
        sources: dict[int, Any] = {}
        _gather(entry, sources)

        def together(values):
            found = dict(zip(sources, values, strict=True))
            return _carried_out(entry, found)

        entry.value = called(together, [_value(source) for source in sources.values()])
    return entry.value


def _gather(entry, sources) -> None:
    """Finds the values that an operation starts from; constants stay a part of it."""
    if _is_pending(entry):
        for source in entry.inputs:
            _gather(source, sources)
    elif isinstance(entry, (_Pending, jax.core.Tracer)):
        sources[id(entry)] = entry


def _carried_out(entry, found):
    if id(entry) in found or not isinstance(entry, _Pending):
        return found.get(id(entry), entry)
    found[id(entry)] = entry.bind(*(_carried_out(source, found) for source in entry.inputs))
    return found[id(entry)]
