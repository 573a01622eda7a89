"""Compiled functions that the tests of one rod share."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.rods.integration import rod_tip

LANES = 8
"""Every batch is filled up to this, so that all share one compiled program."""


@functools.cache
def _compiled(geometry, steps):
    return jax.jit(jax.vmap(lambda rod, n, m: rod_tip(geometry, rod, n, m, steps)))


@pytest.fixture(scope="session")
def tip():
    """`tip(geometry, rods, forces, moments)`: tips of up to `LANES` rods with their wrenches."""

    def call(geometry, rods, forces, moments, steps=16):
        count = len(forces)

        def fill(leaf):
            leaf = np.asarray(leaf, float)
            return np.concatenate([leaf, np.repeat(leaf[-1:], LANES - count, axis=0)])

        if not isinstance(rods, list):
            filled = jax.tree.map(fill, rods)
        else:
            filled = jax.tree.map(lambda *leaves: fill(jnp.stack(leaves)), *rods)
        tips = _compiled(geometry, steps)(filled, fill(forces), fill(moments))
        return jax.tree.map(lambda leaf: np.asarray(leaf[:count]), tips)

    return call


@pytest.fixture(params=[PLANE, SPACE], ids=repr, scope="module")
def geometry(request):
    """Both geometries, one after the other."""
    return request.param
