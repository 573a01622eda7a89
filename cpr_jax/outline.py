"""Trees of arrays and of Python values, taken apart into both."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import equinox as eqx
import jax

_are_arrays: dict[type, bool] = {}
"""Whether what is of a type is an array: to ask anew takes longer than all else here."""


class Slot(NamedTuple):
    """Stands for the array of this number in a tree whose other leaves are Python values."""

    number: int


def outlined(tree) -> tuple[list[jax.Array], Any]:
    """The arrays of a tree, and the tree with a `Slot` in the place of each."""
    arrays = [leaf for leaf in jax.tree.leaves(tree) if eqx.is_array(leaf)]
    numbers = iter(range(len(arrays)))
    outline = jax.tree.map(lambda x: Slot(next(numbers)) if eqx.is_array(x) else x, tree)
    return arrays, outline


def type_of(leaf) -> tuple:
    """What a program depends on of an array."""
    return leaf.shape, leaf.dtype, getattr(leaf, "weak_type", False)


def parted(leaves: Iterable[Any]) -> tuple[list[Any], list[tuple]]:
    """The arrays among leaves, and what a program depends on of each leaf."""
    arrays, types = [], []
    for leaf in leaves:
        kind = type(leaf)
        is_array = _are_arrays.get(kind)
        if is_array is None:
            is_array = _are_arrays[kind] = eqx.is_array(leaf)
        if is_array:
            arrays.append(leaf)
        types.append(type_of(leaf) if is_array else (kind, leaf))
    return arrays, types


def are_traced(arrays: Sequence[Any]) -> bool:
    """Whether a program that is being traced knows of one of them."""
    tracer = jax.core.Tracer
    # A generator takes five times as long.
    for array in arrays:  # noqa: SIM110
        if isinstance(array, tracer):
            return True
    return False
