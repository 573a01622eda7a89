"""Calls that are traced where they are compiled, not where they are written."""

from collections.abc import Callable
from typing import Any

import jax
from jax.extend.core import ClosedJaxpr, Primitive
from jax.interpreters import ad, batching, mlir

_lazy = Primitive("lazy_call")
_lazy.multiple_results = True


def lazily(function: Callable[..., Any], outline: Callable[..., Any]) -> Callable[..., Any]:
    """The same function, traced once it is known that its call stays as it is.

    `custom_vmap` traces a function before it is batched, and what comes of that is thrown away
    where it is. For a long kernel that takes longer than to trace the batch.

    **Arguments:**

    - `function`: of arrays, closing over none that are traced.
    - `outline`: of the same arguments; what it returns has a shape and a dtype in the place of
        each array of the result.
    """

    def call(*leaves):
        results, structure = jax.tree.flatten(outline(*leaves))
        shapes = tuple(jax.core.ShapedArray(leaf.shape, leaf.dtype) for leaf in results)
        found = _lazy.bind(*leaves, function=function, shapes=shapes)
        return jax.tree.unflatten(structure, found)

    return call


def is_lazy(equation) -> bool:
    """Whether an operation of a traced program is a lazy call."""
    return equation.primitive is _lazy


def traced(equation) -> ClosedJaxpr:
    """What a lazy call does."""
    arguments = [variable.aval for variable in equation.invars]
    return jax.make_jaxpr(_flat(equation.params["function"]))(*arguments)


def _flat(function: Callable[..., Any]) -> Callable[..., list]:
    return lambda *leaves: jax.tree.leaves(function(*leaves))


def _called(*leaves, function, shapes):
    return _flat(function)(*leaves)


def _derived(primals, tangents, *, function, shapes):
    slopes = tuple(map(ad.instantiate_zeros, tangents))
    return jax.jvp(_flat(function), tuple(primals), slopes)


def _batched(leaves, axes, *, function, shapes):
    results = jax.vmap(_flat(function), in_axes=tuple(axes))(*leaves)
    return results, [0] * len(results)


_lazy.def_impl(_called)
_lazy.def_abstract_eval(lambda *_, function, shapes: shapes)
ad.primitive_jvps[_lazy] = _derived
batching.primitive_batchers[_lazy] = _batched
mlir.register_lowering(_lazy, mlir.lower_fun(_called, multiple_results=True))
