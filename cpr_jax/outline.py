"""Trees of arrays and of Python values, taken apart into both."""

from typing import Any, NamedTuple

import equinox as eqx
import jax


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
    return leaf.shape, leaf.dtype, bool(getattr(leaf, "weak_type", False))
