"""Many rods at once: one axis for all of them, in blocks that stay in the cache of a core."""

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp

from ..lanes import in_blocks

_CACHED = 2048
"""Numbers of the states that are stepped at a time, with those of their tangents."""

_SMALLEST, _LARGEST = 32, 128

_FEW = 16
"""Rods of a single case. They take milliseconds and their program many seconds to compile, so its
size is what counts; of batches it is their time."""


def block_size(numbers: int) -> int:
    """How many rods to step at a time if each has so many numbers: a power of two."""
    fitting = 2 ** round(math.log2(_CACHED / numbers))
    return min(max(fitting, _SMALLEST), _LARGEST)


def over_rods(
    single: Callable[..., Any],
    wrap: Callable[[Callable[..., Any]], Callable[..., Any]],
    shapes: Sequence[tuple[int, ...]],
    size: int,
) -> Callable[..., Any]:
    """`wrap` of a function of one rod, on arrays with equally many axes behind their components.

    **Arguments:**

    - `single`: takes arrays of the given `shapes`, and whether its program is to be `compact`.
    - `wrap`: what is to be done to it once it takes arrays with one more, last axis.
    - `size`: of a block of rods.

    **Returns:** a function of arrays; what is common to all rods has axes of length one.
    """

    def call(*leaves):
        batches = [leaf.shape[len(shape) :] for leaf, shape in zip(leaves, shapes, strict=True)]
        over = jnp.broadcast_shapes(*batches)
        one = functools.partial(single, compact=math.prod(over) <= _FEW)
        if over == ():
            return wrap(one)(*leaves)
        varied = [math.prod(batch) > 1 for batch in batches]
        varied[0] |= not any(varied)

        def flat(leaf, shape, varies):
            if not varies:
                return leaf.reshape(shape)
            return jnp.broadcast_to(leaf, (*shape, *over)).reshape(*shape, -1)

        leaves = tuple(flat(*each) for each in zip(leaves, shapes, varied, strict=True))
        axes = tuple(-1 if varies else None for varies in varied)
        along = wrap(jax.vmap(one, in_axes=axes, out_axes=-1))

        def block(*moving):
            supply = iter(moving)
            pairs = zip(leaves, varied, strict=True)
            return along(*(next(supply) if varies else leaf for leaf, varies in pairs))

        moving = [leaf for leaf, varies in zip(leaves, varied, strict=True) if varies]
        out = in_blocks(block, moving, size)
        return jax.tree.map(lambda leaf: leaf.reshape(*leaf.shape[:-1], *over), out)

    return call
