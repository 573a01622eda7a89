"""Rods of several segments: put together, taken apart, made alike."""

import dataclasses
import functools
import operator
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..errors import InputError
from ..geometry import AbstractGeometry, namespace, unchanged
from .rod import Rod, Segments

_NUMBERS = tuple(field.name for field in dataclasses.fields(Segments))


def segmented_rod(rods: Sequence[Rod]) -> Rod:
    """Joins rods end to end, rigidly and with one tangent, into one rod of several segments.

    Across a joint between segments position, rotation, force and moment are continuous, while
    curvature and strain (2) jump with the compliances. An effect that only some rods have (a
    distributed load, extensibility) becomes a zero for the others.

    **Arguments:**

    - `rods`: from the base to the tip, at least one; each may consist of segments itself.

    **Returns:** a `Rod` whose length is the sum of all lengths, m.

    **Raises:** `InputError` where no rod is given.
    """
    if isinstance(rods, Rod):
        raise InputError("Argument `rods` must be a list of rods, but it is one rod.")
    parts = [part for rod in rods for part in _parts(rod)]
    if len({np.shape(part.precurvature) for part in parts}) > 1:
        raise InputError("Argument `rods` must hold rods of one geometry, but they are of two.")
    if not parts:
        raise InputError("Argument `rods` must hold at least one rod, but it is empty.")
    first, rest = parts[0], parts[1:]
    if not rest:
        return first
    missing = [name for name in _NUMBERS if all(getattr(part, name) is None for part in parts)]
    shapes = {
        name: next(np.shape(getattr(p, name)) for p in parts if getattr(p, name) is not None)
        for name in _NUMBERS
        if name not in missing
    }

    def number(part: Rod, name: str):
        value = getattr(part, name)
        return np.zeros(shapes[name]) if value is None else value

    def stacked(name: str):
        values = [number(part, name) for part in rest]
        xp = namespace(*values)
        return unchanged(xp.stack([xp.asarray(value) for value in values]))

    own = {name: unchanged(number(first, name)) for name in shapes}
    # From the base on, in the order in which a robot file that is read again adds them up.
    lengths = [namespace(part.length).asarray(part.length) for part in parts]
    own["length"] = unchanged(lengths[0] + functools.reduce(operator.add, lengths[1:]))
    return Rod(**own, further=Segments(**{name: stacked(name) for name in shapes}))


def _parts(rod: Rod) -> list[Rod]:
    """The segments of a rod, one by one."""
    if rod.further is None:
        return [rod]
    segments, count = segments_of(rod), rod.further.length.shape[-1] + 1
    return [jax.tree.map(lambda leaf, j=j: leaf[j], segments) for j in range(count)]


def first_length(rod: Rod) -> Float[Array, "*batch"]:
    """Length of the first segment, m."""
    if rod.further is None:
        return rod.length
    return rod.length - jnp.sum(rod.further.length, axis=-1)


def segments_of(rod: Rod) -> Rod:
    """The segments of one rod as uniform rods stacked along a first axis, from base to tip."""
    if rod.further is None:
        return jax.tree.map(lambda leaf: leaf[None], rod)

    def chain(name: str):
        first = first_length(rod) if name == "length" else getattr(rod, name)
        rest = getattr(rod.further, name)
        return None if first is None else jnp.concatenate([first[None], rest])

    return Rod(**{name: chain(name) for name in _NUMBERS})


def arc_lengths(rod: Rod, steps: int) -> Float[Array, " nodes"]:
    """Where an integration of one rod with `steps` equal steps in each segment stops, m.

    `steps + 1` arc lengths from 0 to the rod's length for a uniform rod, `steps` more for each
    further segment.
    """
    fractions = jnp.linspace(0.0, 1.0, steps + 1)
    if rod.further is None:
        return fractions * rod.length
    lengths = segments_of(rod).length
    begins = jnp.cumsum(lengths) - lengths
    inside = begins[:, None] + lengths[:, None] * fractions[1:]
    return jnp.append(0.0, inside)


def loads_inward(geometry: AbstractGeometry, frame, segments: Segments) -> Segments:
    """Segments with their distributed loads turned from world axes into those of a frame."""
    force, moment = segments.force, segments.moment
    if force is not None:
        force = jax.vmap(lambda load: geometry.inward(frame, load))(force)
    if moment is not None:
        moment = jax.vmap(lambda load: geometry.moment_inward(frame, load))(moment)
    return dataclasses.replace(segments, force=force, moment=moment)


def alike(rods: Sequence[Rod]) -> list[Rod]:
    """Rods with as many further segments each as that which has the most.

    What is added at their tips has no length, and zeros for all other numbers: neither the rods nor
    the meaning of their numbers change.
    """
    counts = [0 if rod.further is None else rod.further.length.shape[-1] for rod in rods]
    return [
        _extended(rod, max(counts) - count) if max(counts) > count else rod
        for rod, count in zip(rods, counts, strict=True)
    ]


def _extended(rod: Rod, added: int) -> Rod:
    def numbers(name: str):
        first = getattr(rod, name)
        if first is None:
            return None
        zeros = np.zeros((added, *np.shape(first)))
        if rod.further is None:
            return unchanged(zeros)
        rest = getattr(rod.further, name)
        xp = namespace(rest)
        return unchanged(xp.concatenate([xp.asarray(rest), zeros]))

    return dataclasses.replace(rod, further=Segments(**{name: numbers(name) for name in _NUMBERS}))
