"""A rod's tip as a function of all of its numbers, and differences of functions."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from cpr_jax.rods.integration import rod_tip
from cpr_jax.rods.rod import Rod


class Tip:
    """The tip as a function of one flat vector: the rod, `n(0)` and `m(0)`."""

    def __init__(self, geometry):
        rng = np.random.default_rng(5)
        d, r = geometry.d, geometry.r
        rod = Rod(
            length=jnp.asarray(0.8),
            curvature_compliance=jnp.asarray(rng.uniform(0.5, 2.0, r)),
            precurvature=jnp.asarray(rng.normal(size=r)),
            strain_compliance=jnp.asarray(rng.uniform(0.01, 0.05, d)),
            force=jnp.asarray(rng.normal(size=d)),
            moment=jnp.asarray(rng.normal(size=r)),
        )
        self.x, self.unravel = ravel_pytree(
            (rod, jnp.asarray(rng.normal(size=d)), jnp.asarray(rng.normal(size=r)))
        )
        self.geometry = geometry
        self.value = jax.jit(self)
        self.jacobian = jax.jit(jax.jacfwd(self))

    def __call__(self, x):
        return ravel_pytree(rod_tip(self.geometry, *self.unravel(x)))[0]


tip_of = functools.cache(Tip)
"""One `Tip` a geometry, so that its functions compile once."""


def differences(function, x, step):
    """Central differences of fourth order, the last axis along `x`."""
    columns = []
    for unit in step * np.eye(x.size):
        near = function(x + unit) - function(x - unit)
        far = function(x + 2.0 * unit) - function(x - 2.0 * unit)
        columns.append((8.0 * near - far) / (12.0 * step))
    return np.stack(columns, axis=-1)
