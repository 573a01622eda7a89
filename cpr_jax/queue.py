"""Loops over many lanes, each of which takes as long as it takes.

Under `jax.vmap` a `lax.while_loop` runs all of its lanes until the slowest has finished. Here a
few slots work through the lanes: where one has finished, its slot takes the next.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from .lanes import lanes_of, merging, with_lanes
from .lazy import lazily

SLOTS = 128
"""Enough lanes to fill vectors, few enough not to wait for each other."""

_State = TypeVar("_State")


class _Loop(NamedTuple):
    unfinished: Callable[[list[Array]], Bool[Array, ""]]
    advance: Callable[[list[Array]], list[Array]]


def queued_loop(
    unfinished: Callable[[_State], Bool[Array, ""]],
    advance: Callable[[_State], _State],
    state: _State,
    effort: Float[Array, ""] | None = None,
    slots: int = SLOTS,
) -> _State:
    """As `lax.while_loop`, for a single case; batches of it are queued. Not differentiated.

    **Arguments:**

    - `effort`: lanes of which more is expected begin first, so that no slot is last by far; by
        default they begin in order.
    - `slots`: lanes worked on at a time.
    """
    # What the functions close over may differ from lane to lane, so it becomes an argument.
    loop = eqx.filter_closure_convert(unfinished, state), eqx.filter_closure_convert(advance, state)
    dynamic, static = eqx.partition(loop, eqx.is_array)
    given, structure = jax.tree.flatten(dynamic)
    values, form = jax.tree.flatten(state)
    split, end = len(given), len(given) + len(values)

    def parts(given: list[Array]) -> _Loop:
        unfinished, advance = eqx.combine(jax.tree.unflatten(structure, given), static)
        return _Loop(
            lambda values: unfinished(jax.tree.unflatten(form, values)),
            lambda values: jax.tree.leaves(advance(jax.tree.unflatten(form, values))),
        )

    def level(laned: tuple[bool, ...]):
        def run(*leaves):
            given, values = list(leaves[:split]), list(leaves[split:end])
            if any(laned):
                return _through_slots(parts, given, values, leaves[end:], laned, slots)
            return lax.while_loop(*parts(given), values)

        def outline(*leaves):
            lanes = lanes_of(leaves, laned)
            # As many as there are results, each like its state.
            return [
                leaf if flag else with_lanes(leaf, lanes)
                for leaf, flag in zip(leaves[split:end], laned[split:end], strict=True)
            ]

        return merging(lazily(run, outline), laned, level)

    leaves = [*given, *values, *(() if effort is None else [jnp.asarray(effort)])]
    return jax.tree.unflatten(form, level((False,) * len(leaves))(*leaves))


class _Slots(NamedTuple):
    """Lanes under way, and what has come of all (lanes last).

    **Attributes:**

    - `lane`: of each slot; the number of lanes where none is left for it.
    - `values`: of the slots.
    - `out`: of all lanes.
    - `turn`: how many lanes have been given to a slot.
    """

    lane: Int[Array, " slots"]
    values: list[Array]
    out: list[Array]
    turn: Int[Array, ""]


def _through_slots(parts, given, values, efforts, laned, width):
    """The loop for lanes, the last axis of what is flagged in `laned`, with so many slots."""
    flagged, of_values = laned[: len(given)], laned[len(given) : len(given) + len(values)]
    leaves = [*given, *values, *efforts]
    lanes = next(leaf.shape[-1] for leaf, flag in zip(leaves, laned, strict=True) if flag)
    values = [
        leaf if flag else jnp.broadcast_to(leaf[..., None], (*leaf.shape, lanes))
        for leaf, flag in zip(values, of_values, strict=True)
    ]
    axes = [-1 if flag else None for flag in flagged]

    def taken(leaf, lane):
        return jnp.take(leaf, lane, axis=-1, mode="clip")

    def over_slots(function, now, lane):
        own = [taken(a, lane) if flag else a for a, flag in zip(given, flagged, strict=True)]
        return jax.vmap(function, in_axes=(axes, -1), out_axes=-1)(own, now)

    def unfinished(now, lane):
        return over_slots(lambda given, now: parts(given).unfinished(now), now, lane)

    # Lanes that have nothing to do are not given to a slot.
    waiting = unfinished(values, jnp.arange(lanes))
    order = _order(waiting, efforts)
    waiting = jnp.sum(waiting)

    def lane_of(turn):
        return jnp.where(turn < waiting, taken(order, turn), lanes)

    def advance(slots: _Slots) -> _Slots:
        lane = slots.lane
        going = unfinished(slots.values, lane)
        new = over_slots(lambda given, now: parts(given).advance(now), slots.values, lane)
        new = [jnp.where(going, a, b) for a, b in zip(new, slots.values, strict=True)]
        done = ~unfinished(new, lane)
        place = jnp.where(done, lane, lanes)
        out = [a.at[..., place].set(b, mode="drop") for a, b in zip(slots.out, new, strict=True)]
        turn = slots.turn + jnp.cumsum(done)
        lane = jnp.where(done, lane_of(turn - 1), lane)
        new = [jnp.where(done, taken(a, lane), b) for a, b in zip(values, new, strict=True)]
        return _Slots(lane, new, out, turn[-1])

    first = lane_of(jnp.arange(min(width, lanes)))
    start = _Slots(first, [taken(a, first) for a in values], values, jnp.array(first.size))
    return lax.while_loop(lambda slots: jnp.any(slots.lane < lanes), advance, start).out


def _order(waiting: Bool[Array, " lanes"], efforts) -> Int[Array, " lanes"]:
    """The lanes that wait, those of more effort first, then all others."""
    if efforts:
        (effort,) = efforts
        return jnp.lexsort((-jnp.broadcast_to(effort, waiting.shape), ~waiting))
    # Counted: to sort takes ten times as long.
    numbers = jnp.arange(waiting.size)
    place = jnp.where(waiting, jnp.cumsum(waiting) - 1, waiting.size)
    return numbers.at[place].set(numbers, mode="drop")
