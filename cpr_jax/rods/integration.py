"""Integration of a rod: its tip, its whole shape, its energy."""

import enum
import functools
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..geometry import AbstractGeometry
from ..kernel import one_kernel
from .equations import RodEnergy, RodState, energy_density_at, right_hand_side
from .rod import Rod
from .segments import segments_of
from .solver import ExtrapolatedMidpoint, Scheme, Steps, as_scheme
from .tangents import differentiable

DEFAULT_STEPS = 10
"""Steps of order 10 along a rod: errors below 1e-9 of its length where it turns by up to 5 rad."""


class Readout(enum.Enum):
    """What an integration returns."""

    TIP = "tip"
    SHAPE = "shape"
    ENERGY = "energy"


def rod_tip(
    geometry: AbstractGeometry,
    rod: Rod,
    force: Float[Array, " d"],
    moment: Float[Array, " r"],
    steps: Steps = DEFAULT_STEPS,
) -> RodState:
    """The state at the end of a rod that starts at the origin along the first axis.

    Each segment of a rod takes `steps` steps of its own, so that steps end where stiffness jumps.
    Arrays may have further axes behind their components, for many rods at once.

    Differentiable to any order, in forward and in reverse mode: each derivative is a forward
    integration of the variational equations (8), of which reverse mode takes the transpose.

    **Arguments:**

    - `rod`: with its distributed load expressed in the axes of its base.
    - `force`, `moment`: `n(0)`, N, and `m(0)`, N·m, in the axes of the base.

    **Returns:**

    The tip's position, rotation, `n(l)` and `m(l)` in the axes of the base, each one array.
    """
    return _integrate(geometry, steps, Readout.TIP, rod, force, moment)


def rod_shape(
    geometry: AbstractGeometry,
    rod: Rod,
    force: Float[Array, " d"],
    moment: Float[Array, " r"],
    steps: int = DEFAULT_STEPS,
) -> RodState:
    """As `rod_tip`, at all ends of steps from the base to the tip, see `arc_lengths`."""
    return _integrate(geometry, steps, Readout.SHAPE, rod, force, moment)


def rod_energy(
    geometry: AbstractGeometry,
    rod: Rod,
    force: Float[Array, " d"],
    moment: Float[Array, " r"],
    steps: Steps = DEFAULT_STEPS,
) -> RodEnergy:
    """As `rod_tip`, with the energy of the rod and the integral of its positions."""
    return _integrate(geometry, steps, Readout.ENERGY, rod, force, moment)


def _integrate(geometry, steps, readout, rod, force, moment):
    leaves, treedef = jax.tree.flatten((rod, force, moment))
    many = jnp.ndim(rod.length)
    shapes = tuple(leaf.shape[: leaf.ndim - many] for leaf in leaves)
    if many:
        over = jnp.broadcast_shapes(*(leaf.shape[-many:] for leaf in leaves))
        leaves = [jnp.broadcast_to(a, (*s, *over)) for a, s in zip(leaves, shapes, strict=True)]
    nodes = None
    if readout is Readout.SHAPE:
        nodes = steps
    else:
        # Not a part of the program, which serves any number of steps.
        leaves, shapes = [*leaves, jnp.asarray(as_scheme(steps))], (*shapes, (3,))
    single = _traced_once(geometry, nodes, readout, treedef)
    return differentiable(single, geometry, treedef, shapes, many, nodes is None)(*leaves)


def _solve(geometry, scheme, readout, compact, rod, force, moment):
    """One integration by diffrax, for a single rod, on components."""
    steps, order, least = scheme
    segments = None
    if rod.further is None:
        rod = _components(rod)
    else:
        segments = segments_of(rod)
    zero = jnp.zeros_like(rod.length)
    start = RodState(
        position=(zero,) * geometry.d,
        rotation=tuple(zero + c for c in geometry.identity),
        force=(),
        moment=tuple(moment),
    )
    quadratures = (zero,) * (1 + geometry.d) if readout is Readout.ENERGY else ()
    y0 = jax.tree.leaves((start, quadratures))
    structure: Any = jax.tree.structure((start, quadratures))

    whole = readout is Readout.SHAPE

    def cross(y, force, rod):
        """From one end of a uniform rod to the other, and what is met on the way."""
        stride = rod.length / steps

        def force_after(t):
            # What is distributed is constant: the force changes linearly and is not integrated.
            if rod.force is None:
                return tuple(jnp.broadcast_to(n, jnp.shape(t)) for n in force)
            return tuple(n - t * stride * load for n, load in zip(force, rod.force, strict=True))

        def vector_field(t, y, args):
            state, quadratures = structure.unflatten(y)
            full = state._replace(force=force_after(t))
            rates = right_hand_side(geometry, full, rod)._replace(force=())
            if quadratures:
                quadratures = (energy_density_at(geometry, full, rod), *full.position)
            return [stride * rate for rate in jax.tree.leaves((rates, quadratures))]

        # Steps of one size need no controller: stepped by hand, a rod is traced in a tenth of the
        # operations that `diffeqsolve` makes of it, and every batch and derivative repeats those.
        term, solver = diffrax.ODETerm(vector_field), ExtrapolatedMidpoint(order, least, compact)

        def advance(y, t):
            y, *_ = solver.step(term, t, t + 1.0, y, None, None, made_jump=False)
            return y, y

        end = force_after(1.0 * steps)
        if whole:
            y, along = jax.lax.scan(advance, y, jnp.arange(float(steps)))
            return (y, end), (along, force_after(1.0 + jnp.arange(float(steps))))
        to_end = one_kernel(
            lambda y: jax.lax.fori_loop(0, steps, lambda k, y: advance(y, 1.0 * k)[0], y)
        )
        return (to_end(y), end), None

    begin = y0, tuple(force)
    if segments is None:
        ends, along = cross(y0, tuple(force), rod)
    else:
        # A loop over the segments: the compiled program does not grow with their number.
        def cross_segment(now, segment):
            y, force = now
            end, along = cross(y, force, _components(segment))
            return end, along if whole else end

        ends, along = jax.lax.scan(cross_segment, begin, segments)
        along = jax.tree.map(lambda values: values.reshape(-1), along)
    if whole:
        ends = jax.tree.map(jnp.append, begin, along)
    ys, forces = ends
    state, quadratures = structure.unflatten(ys)
    state = state._replace(force=forces, rotation=geometry.normalise(state.rotation))
    state = RodState(*(jnp.stack(part, axis=-1) for part in state))
    if readout is not Readout.ENERGY:
        return state
    positions = jnp.stack(quadratures[1:])
    if segments is not None:
        _, sums = structure.unflatten(along[0])
        positions = jnp.diff(jnp.stack(sums[1:], axis=-1), axis=0, prepend=0.0)
    return RodEnergy(quadratures[0], positions, state)


def _components(rod):
    """A rod on scalars: vectors become tuples."""
    return jax.tree.map(lambda leaf: tuple(leaf) if leaf.ndim else leaf, rod)


@functools.cache
def _traced_once(geometry, nodes, readout, treedef):
    """`_solve` on leaves, traced once. Batches and derivatives start from that trace.

    The numbers of the scheme are the last leaf, unless its steps are given as `nodes`.
    """

    @functools.partial(jax.jit, static_argnames="compact")
    def solve(*leaves, compact):
        *inputs, scheme = leaves if nodes is None else (*leaves, Scheme(nodes))
        return _solve(geometry, scheme, readout, compact, *treedef.unflatten(inputs))

    return solve
