"""Batches laid out with their lanes last in memory.

XLA's CPU back end vectorises along the last axis. `jax.vmap` puts the batch first, so that a
kernel on small vectors runs on strides; with the lanes last the same kernel is several times
faster. `lanes_last` re-lays a function under any number of nested `vmap`s, by whomever they
are written, and hands it one merged batch axis.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap

from .lazy import lazily
from .once import once

_SMALL = 150
"""Operations of a kernel on lanes up to which XLA is left to it, as in `once`."""

_LARGE = 900
"""Operations from which on a single case, too, is worth the longer compilation by `once`."""


class Lift(NamedTuple):
    """Vectorises functions of a kernel's arguments along its lanes.

    **Attributes:**

    - `structure`: of the arguments.
    - `laned`: which of their leaves have a last axis of lanes.
    """

    structure: Any
    laned: tuple[bool, ...]

    def __call__(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """A function of a single case, vectorised if there are lanes."""
        if not any(self.laned):
            return function
        axes = self.structure.unflatten([-1 if flag else None for flag in self.laned])
        return jax.vmap(function, in_axes=axes, out_axes=-1)

    def spread(self, args: tuple) -> tuple:
        """The arguments, each with a last axis: of length one where lanes do not differ."""
        leaves = zip(jax.tree.leaves(args), self.laned, strict=True)
        return self.structure.unflatten(
            [leaf if flag else leaf[..., None] for leaf, flag in leaves]
        )


def lanes_last(
    kernel: Callable[..., Any], outline: Callable[..., Any] | None = None
) -> Callable[..., Any]:
    """Gives a function whose batches run with the lanes as the last axis.

    **Arguments:**

    - `kernel`: called as `kernel(lift, *args)`. It is written for a single case; where it
        calls the function that is to be vectorised along the lanes it calls `lift(function)`
        instead, with `function` taking exactly `*args`. What it does outside of `lift` sees
        arrays with one more, last axis where they are batched. Its outputs carry the lanes
        last.
    - `outline`: what it returns for a single case, with shapes and dtypes in the places of arrays;
        a function of `*args`. By default the kernel is traced for it.

    **Returns:**

    A function of `*args` (pytrees of arrays). Differentiation goes through a rule of its own
    (`jax.custom_jvp`) around it.
    """

    def call(*args):
        leaves, treedef = jax.tree.flatten(args)
        flags = tuple(False for _ in leaves)
        return _level(kernel, outline, treedef, flags)(*[jnp.asarray(leaf) for leaf in leaves])

    return functools.wraps(kernel)(call)


def over_lanes(
    kernel: Callable[..., Any], outline: Callable[..., Any] | None = None
) -> Callable[..., Any]:
    """Gives a function whose batches are calculated on arrays with the lanes as their last axis.

    **Arguments:**

    - `kernel`: called with arrays that have one more, last axis, of length one where lanes do
        not differ. Its outputs have that axis too.
    - `outline`: as of `lanes_last`.

    **Returns:** a function for a single case, of pytrees of arrays, to be batched as by
    `lanes_last`.
    """

    def spread(lift, *args):
        out = kernel(*lift.spread(args))
        return out if any(lift.laned) else jax.tree.map(lambda leaf: leaf[..., 0], out)

    return lanes_last(spread, outline)


def in_blocks(function: Callable[..., Any], arrays: Sequence[jax.Array], size: int) -> Any:
    """`function` on blocks of the last axis, which is padded with copies of its last entry.

    **Arguments:**

    - `function`: of the arrays; what it returns has the lanes last, too.
    - `size`: of a block, such that what is worked on stays in the cache of a core.
    """
    lanes = arrays[0].shape[-1]
    if lanes <= size:
        return function(*arrays)
    blocks = -(-lanes // size)

    def cut(array):
        spare = [(0, 0)] * (array.ndim - 1) + [(0, blocks * size - lanes)]
        padded = jnp.pad(array, spare, mode="edge")
        return jnp.moveaxis(padded.reshape(*array.shape[:-1], blocks, size), -2, 0)

    def join(array):
        return jnp.moveaxis(array, 0, -2).reshape(*array.shape[1:-1], -1)[..., :lanes]

    out = jax.lax.map(lambda parts: function(*parts), tuple(cut(array) for array in arrays))
    return jax.tree.map(join, out)


@functools.cache
def _level(kernel, outline, treedef, laned: tuple[bool, ...]):
    """The kernel on leaves of which those flagged in `laned` have a last, merged lane axis."""

    # The inner jit traces a kernel once, however often a program calls it.
    def on_leaves(*leaves):
        return kernel(Lift(treedef, laned), *treedef.unflatten(leaves))

    compiled = jax.jit(once(on_leaves, _SMALL if any(laned) else _LARGE))

    def outlined(*leaves):
        alone = tuple(
            jax.ShapeDtypeStruct(leaf.shape[:-1] if flag else leaf.shape, leaf.dtype)
            for leaf, flag in zip(leaves, laned, strict=True)
        )
        if outline is None:
            out = _traced_outline(kernel, treedef, alone)
        else:
            out = outline(*treedef.unflatten(alone))
        return jax.tree.map(lambda leaf: with_lanes(leaf, lanes_of(leaves, laned)), out)

    batched = lazily(compiled, outlined)
    return merging(batched, laned, lambda flags: _level(kernel, outline, treedef, flags))


@functools.cache
def _traced_outline(kernel, treedef, shapes: tuple[jax.ShapeDtypeStruct, ...]):
    alone = Lift(treedef, (False,) * len(shapes))
    return jax.eval_shape(lambda *leaves: kernel(alone, *treedef.unflatten(leaves)), *shapes)


def lanes_of(leaves: Sequence[Any], laned: tuple[bool, ...]) -> int | None:
    """How many lanes the flagged arrays have; `None` if there are none."""
    return next((leaf.shape[-1] for leaf, flag in zip(leaves, laned, strict=True) if flag), None)


def with_lanes(leaf: Any, lanes: int | None) -> jax.ShapeDtypeStruct:
    """The outline of an array, with a last axis of lanes unless there are none."""
    added = () if lanes is None else (lanes,)
    return jax.ShapeDtypeStruct((*leaf.shape, *added), leaf.dtype)


def merging(
    function: Callable[..., Any],
    laned: tuple[bool, ...],
    level: Callable[[tuple[bool, ...]], Callable[..., Any]],
) -> Callable[..., Any]:
    """A function of arrays whose batches have one lane axis, the last, however deep they nest.

    **Arguments:**

    - `function`: on arrays of which those flagged in `laned` have a last axis of lanes.
    - `level`: the function for other flags.
    """
    merged = custom_vmap(function)

    @merged.def_vmap
    def rule(size, batched, *leaves):
        if not any(batched):
            # A derivative of this call is batched and the call is not: made again as it is, it
            # would be differentiated and batched without end.
            out = function(*leaves)
            return out, jax.tree.map(lambda _: False, out)
        # The inner lanes lie last already; the outer batch goes before them and is merged.
        width = lanes_of(leaves, laned)
        new = []
        for leaf, outer, inner in zip(leaves, batched, laned, strict=True):
            if outer:
                leaf = jnp.moveaxis(leaf, 0, -2 if inner else -1)
                if width is not None and not inner:
                    leaf = jnp.broadcast_to(leaf[..., None], (*leaf.shape, width))
            elif inner:
                leaf = jnp.broadcast_to(
                    leaf[..., None, :], (*leaf.shape[:-1], size, leaf.shape[-1])
                )
            if width is not None and (outer or inner):
                leaf = leaf.reshape(*leaf.shape[:-2], size * width)
            new.append(leaf)
        flags = tuple(o or i for o, i in zip(batched, laned, strict=True))
        out = level(flags)(*new)

        def split(leaf):
            if width is not None:
                return jnp.moveaxis(leaf.reshape(*leaf.shape[:-1], size, width), -2, 0)
            return jnp.moveaxis(leaf, -1, 0)

        out = jax.tree.map(split, out)
        return out, jax.tree.map(lambda _: True, out)

    return merged
