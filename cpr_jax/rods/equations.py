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


def strains(
    geometry: AbstractGeometry, state: RodState, rod: Rod
) -> tuple[Components | None, Components]:
    """Local strain beyond the tangent (`None` if unstrained) and local curvature, 1/m."""
    moment = geometry.to_local(state.rotation, state.moment)
    curvature = tuple(
        compliance * m + rest
        for compliance, m, rest in zip(
            rod.curvature_compliance, moment, rod.precurvature, strict=True
        )
    )
    if rod.strain_compliance is None:
        return None, curvature
    force = geometry.unrotate(state.rotation, state.force)
    return tuple(c * n for c, n in zip(rod.strain_compliance, force, strict=True)), curvature


def right_hand_side(geometry: AbstractGeometry, state: RodState, rod: Rod) -> RodState:
    """`x' = f(x, ρ)`, equations (2) and (14), in compliance form.

    With the tangent `e_1`, the compliances `C_v`, `C_u` and the load `f`, `l`:

        p' = R (e_1 + C_v Rᵀ n)         n' = -f
        R' = R [C_u Rᵀ m + 1/r_c]×      m' = -p' × n - l
    """
    strain, curvature = strains(geometry, state, rod)
    direction = geometry.tangent(state.rotation)
    if strain is not None:
        stretched = geometry.rotate(state.rotation, strain)
        direction = tuple(t + v for t, v in zip(direction, stretched, strict=True))
    moment = tuple(-c for c in geometry.cross(direction, state.force))
    if rod.moment is not None:
        moment = tuple(m - load for m, load in zip(moment, rod.moment, strict=True))
    if rod.force is None:
        force = tuple(0.0 * n for n in state.force)
    else:
        force = tuple(-load + 0.0 * n for load, n in zip(rod.force, state.force, strict=True))
    return RodState(direction, geometry.rate(state.rotation, curvature), force, moment)


def strain_energy_density(
    geometry: AbstractGeometry, state: RodState, rod: Rod
) -> Float[Array, ""]:
    """Elastic energy per length, N: `½ m·C_u m + ½ n·C_v n` in local axes."""
    moment = geometry.to_local(state.rotation, state.moment)
    energy = sum(c * m * m for c, m in zip(rod.curvature_compliance, moment, strict=True))
    if rod.strain_compliance is not None:
        force = geometry.unrotate(state.rotation, state.force)
        energy += sum(c * n * n for c, n in zip(rod.strain_compliance, force, strict=True))
    return 0.5 * energy


def rates_at_end(geometry: AbstractGeometry, end: Any, rod: Rod) -> Any:
    """How a `RodState` or a `RodEnergy` of a uniform rod grows with its length."""
    tip = end.tip if isinstance(end, RodEnergy) else end
    state = RodState(*(tuple(part) for part in tip))
    rates = RodState(*(jnp.stack(part) for part in right_hand_side(geometry, state, rod)))
    if isinstance(end, RodEnergy):
        return RodEnergy(strain_energy_density(geometry, state, rod), tip.position, rates)
    return rates
