"""Legs of one robot, stacked along a first axis."""

import dataclasses
from collections.abc import Sequence

import jax
import numpy as np
from jaxtyping import Array, Float

from ..geometry import floats, namespace, unchanged
from ..rods.segments import alike
from .leg import Leg


def stack(legs: Sequence[Leg]) -> Leg:
    """One leg whose numbers are those of all; what a leg lacks is zero."""

    def none(leaf):
        return leaf is None

    def stacked(*leaves):
        present = [leaf for leaf in leaves if leaf is not None]
        if not present:
            return None
        xp = namespace(*present)
        zero = np.zeros(present[0].shape)
        return unchanged(xp.stack([zero if leaf is None else leaf for leaf in leaves]))

    joints = [leg.base_joint for leg in legs if leg.base_joint is not None]
    if joints:
        locked = jax.tree.map(lambda leaf: floats(np.zeros(leaf.shape)), joints[0])
        legs = [
            dataclasses.replace(leg, base_joint=locked) if leg.base_joint is None else leg
            for leg in legs
        ]
    rods = alike([leg.rod for leg in legs])
    turns = any(turns_any(leg.screw, leg.base_position.size) for leg in legs)
    legs = [
        dataclasses.replace(leg, rod=rod, turns=turns) for leg, rod in zip(legs, rods, strict=True)
    ]
    return jax.tree.map(stacked, *legs, is_leaf=none)


def turns_any(screw: Float[Array, "*legs freedoms"], d: int) -> bool:
    """Whether a motor, or any of several, may turn what it moves."""
    return isinstance(screw, jax.core.Tracer) or bool(np.any(np.asarray(screw)[..., d:]))
