"""Derivatives of integrations of rods: tangents (8), to any order."""

import functools
import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero

from ..geometry import AbstractGeometry
from ..lanes import lanes_last
from .batching import block_size, over_rods
from .equations import rates_at_end


@functools.cache
def differentiable(
    single: Callable[..., Any],
    geometry: AbstractGeometry,
    treedef: Any,
    shapes: tuple[tuple[int, ...], ...],
    many: int,
    ends: bool,
    perturbed: tuple[tuple[bool, ...], ...] = (),
) -> Callable[..., Any]:
    """An integration together with its derivatives along the leaves flagged in `perturbed`.

    **Arguments:**

    - `single`: the integration of one rod, a function of leaves, see `over_rods`.
    - `treedef`: of these leaves, but for the numbers of the scheme, if they come last.
    - `shapes`: of the leaves of one rod.
    - `many`: number of further axes behind these.
    - `ends`: whether it returns what is at the rod's end, a `RodState` or a `RodEnergy`.
    - `perturbed`: one tuple of flags for each order.

    The rule of the derivative of order k is the derivative of order k + 1, so that nothing ever
    differentiates the loop in reverse, and tangents are integrated for those inputs alone that are
    perturbed.
    """
    counts = [
        sum(math.prod(shape) for shape, flag in zip(shapes, flags, strict=True) if flag)
        for flags in perturbed
    ]
    columns = math.prod(1 + count for count in counts)
    size = block_size(columns * (2 * geometry.d + len(geometry.identity)))

    def with_tangents(function):
        for flags in perturbed:
            function = _with_tangents(function, shapes, flags)
        return function

    def outline(*leaves):
        alone = [
            jax.ShapeDtypeStruct(shape, leaf.dtype)
            for leaf, shape in zip(leaves, shapes, strict=True)
        ]
        out = jax.eval_shape(functools.partial(single, compact=True), *alone)
        over = leaves[0].shape[len(shapes[0]) :]
        out = jax.tree.map(lambda leaf: leaf.update(shape=(*leaf.shape, *over)), out)
        for count in counts:
            slopes = jax.tree.map(lambda leaf, n=count: leaf.update(shape=(n, *leaf.shape)), out)
            out = out, slopes
        return out

    def kernel(lift, *leaves):
        depth = many + any(lift.laned)

        def aligned(leaf, shape, laned):
            # Lanes come last in memory, behind the further axes.
            before = leaf.ndim - laned
            ones = (1,) * (depth + len(shape) - leaf.ndim)
            return leaf.reshape(*leaf.shape[:before], *ones, *leaf.shape[before:])

        rods = over_rods(single, with_tangents, shapes, size)
        return rods(*map(aligned, leaves, shapes, lift.laned))

    integrated = lanes_last(kernel, outline)

    @jax.custom_jvp
    def integrate(*leaves):
        return integrated(*leaves)

    # The end of a longer rod lies further along the same rod, which takes no tangent.
    length = _place_of_length(treedef) if ends and not perturbed else None

    def rule(primals, tangents):
        flags = [not isinstance(tangent, SymbolicZero) for tangent in tangents]
        if length is None or not flags[length]:
            return along_tangents(primals, tangents, tuple(flags))
        flags[length] = False
        value, slope = along_tangents(primals, tangents, tuple(flags))
        leaves = [tuple(a) if shape else a for a, shape in zip(primals, shapes, strict=True)]
        rod, *_ = treedef.unflatten(leaves[: treedef.num_leaves])
        rates = rates_at_end(geometry, value, rod)
        return value, jax.tree.map(lambda dx, rate: dx + rate * tangents[length], slope, rates)

    def along_tangents(primals, tangents, flags):
        if not any(flags):
            value = integrate(*primals)
            return value, jax.tree.map(jnp.zeros_like, value)
        order = (*perturbed, flags)
        value, jacobian = differentiable(single, geometry, treedef, shapes, many, ends, order)(
            *primals
        )
        seeds = jnp.concatenate(
            [
                t.reshape(-1, *t.shape[len(shape) :])
                for t, shape, flag in zip(tangents, shapes, flags, strict=True)
                if flag
            ]
        )

        def along(j):
            between = (1,) * (j.ndim - seeds.ndim)
            return jnp.sum(seeds.reshape(len(seeds), *between, *seeds.shape[1:]) * j, axis=0)

        return value, jax.tree.map(along, jacobian)

    integrate.defjvp(rule, symbolic_zeros=True)
    return integrate


def _place_of_length(treedef) -> int | None:
    """Where the length of a uniform rod is among the leaves; `None` if the rod has segments."""
    rod, *_ = treedef.unflatten(range(treedef.num_leaves))
    return rod.length if rod.further is None else None


def _with_tangents(function, shapes, flags):
    """`function` beside its Jacobian in the flagged leaves; the Jacobian's first axis is theirs.

    Tangents are the outer batch and lanes the inner, last one.
    """

    def both(*leaves):
        chosen = tuple(leaf for leaf, flag in zip(leaves, flags, strict=True) if flag)

        def partial(*moving):
            supply = iter(moving)
            return function(
                *(next(supply) if flag else leaf for leaf, flag in zip(leaves, flags, strict=True))
            )

        return jax.vmap(lambda *tangents: jax.jvp(partial, chosen, tangents), out_axes=(None, 0))(
            *_seeds(chosen, [s for s, flag in zip(shapes, flags, strict=True) if flag])
        )

    return both


def _seeds(leaves, shapes):
    """Unit tangents, one for each component of all leaves; equal along the lanes."""
    sizes = [math.prod(shape) for shape in shapes]
    units = jnp.split(jnp.eye(sum(sizes)), [sum(sizes[:k]) for k in range(1, len(sizes))], axis=1)
    seeds = []
    for leaf, shape, unit in zip(leaves, shapes, units, strict=True):
        unit = unit.reshape(-1, *shape, *(1,) * (leaf.ndim - len(shape)))
        seeds.append(jnp.broadcast_to(unit, (unit.shape[0], *leaf.shape)))
    return tuple(seeds)
