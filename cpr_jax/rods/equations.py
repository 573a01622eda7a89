"""The rod's differential equation: the only right-hand side, for the plane and for space."""

from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..geometry import AbstractGeometry, Components
from .rod import Rod


class RodState(NamedTuple):
    """The state `x(s) = [g, n, m]` of a rod at arc length `s` (2).

    `force` and `moment` are what the material beyond `s` exerts on the material before `s`, in
    the axes in which `position` and `rotation` are given. Each is a tuple of scalars inside an
    integration and one array outside.
    """

    position: Any
    rotation: Any
    force: Any
    moment: Any


class RodEnergy(NamedTuple):
    """What accumulates along a rod, and its tip.

    **Attributes:**

    - `energy`: elastic energy, J.
    - `positions`: `∫ p ds`, m², shape `(d,)`; over each segment of a rod that has further ones,
        `(1 + k, d)`.
    - `tip`: as of `rod_tip`.
    """

    energy: Float[Array, ""]
    positions: Float[Array, " d"]
    tip: RodState


def strains(rod: Rod, force: Components, moment: Components) -> tuple[Any, Components]:
    """Local strain beyond the tangent (`None` if unstrained) and local curvature, 1/m.

    **Arguments:**

    - `force`, `moment`: in local axes.
    """
    curvature = tuple(
        compliance * m + rest
        for compliance, m, rest in zip(
            rod.curvature_compliance, moment, rod.precurvature, strict=True
        )
    )
    if rod.strain_compliance is None:
        return None, curvature
    return tuple(c * n for c, n in zip(rod.strain_compliance, force, strict=True)), curvature


def _in_local_axes(geometry: AbstractGeometry, rows: Any, state: RodState, rod: Rod):
    """Force, unless nothing gives way to it, and moment; `rows` of the state's rotation."""
    moment = geometry.to_local(rows, state.moment)
    if rod.strain_compliance is None:
        return (), moment
    return geometry.unrotate(rows, state.force), moment


def right_hand_side(geometry: AbstractGeometry, state: RodState, rod: Rod) -> RodState:
    """`x' = f(x, ρ)`, equations (2) and (14), in compliance form.

    With the tangent `e_1`, the compliances `C_v`, `C_u` and the load `f`, `l`:

        p' = R (e_1 + C_v Rᵀ n)         n' = -f
        R' = R [C_u Rᵀ m + 1/r_c]×      m' = -p' × n - l
    """
    rows = geometry.rows(state.rotation)
    strain, curvature = strains(rod, *_in_local_axes(geometry, rows, state, rod))
    direction = geometry.tangent(rows)
    if strain is not None:
        stretched = geometry.rotate(rows, strain)
        direction = tuple(t + v for t, v in zip(direction, stretched, strict=True))
    moment = tuple(-c for c in geometry.cross(direction, state.force))
    if rod.moment is not None:
        moment = tuple(m - load for m, load in zip(moment, rod.moment, strict=True))
    if rod.force is None:
        force = tuple(0.0 * n for n in state.force)
    else:
        force = tuple(-load + 0.0 * n for load, n in zip(rod.force, state.force, strict=True))
    return RodState(direction, geometry.rate(state.rotation, curvature), force, moment)


def strain_energy_density(rod: Rod, force: Components, moment: Components) -> Float[Array, ""]:
    """Elastic energy per length, N: `½ m·C_u m + ½ n·C_v n` in local axes."""
    energy = sum(c * m * m for c, m in zip(rod.curvature_compliance, moment, strict=True))
    if rod.strain_compliance is not None:
        energy += sum(c * n * n for c, n in zip(rod.strain_compliance, force, strict=True))
    return 0.5 * energy


def energy_density_at(geometry: AbstractGeometry, state: RodState, rod: Rod) -> Float[Array, ""]:
    """`strain_energy_density` of a state in other axes."""
    rows = geometry.rows(state.rotation)
    return strain_energy_density(rod, *_in_local_axes(geometry, rows, state, rod))


def rates_at_end(geometry: AbstractGeometry, end: Any, rod: Rod) -> Any:
    """How a `RodState` or a `RodEnergy` of a uniform rod grows with its length."""
    tip = end.tip if isinstance(end, RodEnergy) else end
    state = RodState(*(tuple(part) for part in tip))
    rates = RodState(*(jnp.stack(part) for part in right_hand_side(geometry, state, rod)))
    if isinstance(end, RodEnergy):
        return RodEnergy(energy_density_at(geometry, state, rod), tip.position, rates)
    return rates
