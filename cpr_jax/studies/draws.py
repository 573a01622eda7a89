"""Random parameters."""

import enum

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int


class Distribution(enum.Enum):
    """How the parameters vary."""

    GAUSSIAN = "gaussian"
    """Independent Gaussians with σ = δ/3, as in the paper."""
    ELLIPSOID = "ellipsoid"
    """Uniform in the ellipsoid (11)."""
    BOX = "box"
    """Uniform in the intervals (6)."""


def draw(
    distribution: Distribution,
    delta: Float[Array, " n_rho"],
    seed: Int[Array, ""],
    numbers: Int[Array, " samples"],
) -> Float[Array, "samples n_rho"]:
    """Random `Δρ`; each sample has a key of its own, by its number."""
    key = jax.random.key(seed)

    def one(number):
        return delta * _unit(distribution, jax.random.fold_in(key, number), delta.size)

    return jax.vmap(one)(numbers)


def _unit(distribution: Distribution, key, size: int) -> Float[Array, " n_rho"]:
    """One random `Δρ / δ`."""
    if distribution is Distribution.GAUSSIAN:
        return jax.random.normal(key, (size,)) / 3.0
    if distribution is Distribution.BOX:
        return jax.random.uniform(key, (size,), minval=-1.0, maxval=1.0)
    direction, radius = jax.random.split(key)
    vector = jax.random.normal(direction, (size,))
    return vector / jnp.linalg.norm(vector) * jax.random.uniform(radius) ** (1.0 / size)
