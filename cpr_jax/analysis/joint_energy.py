"""What the free motions of joints add to the second variation of the energy."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..geometry import AbstractGeometry, Components
from ..robots.leg import Leg
from ..statics.linear import negative_eigenvalues
from ..statics.residual import base_wrench, leg_base
from .pieces import variation


def released_base(geometry: AbstractGeometry, leg: Leg, q, mu, units, carried):
    """What a passive joint adds to a rod whose base was held.

    **Arguments:**

    - `carried`: stiffness of the rod, its tip under dead loads, against turns of its base.

    **Returns:** tangents `∂(p, φ, n, m)(0)` in the joint's unknowns; wrenches that would resist its
    free motions with a stiffness of one; the number of negative directions among these motions.
    """
    d, f = geometry.d, geometry.freedoms
    joint = leg.base_joint
    assert joint is not None
    here = leg_base(geometry, leg, q, mu)
    free, released = joint.free, joint.free[d:]

    def move(mu):
        return variation(geometry, leg_base(geometry, leg, q, mu), here)

    force, moment = jnp.split(base_wrench(geometry, here), [d])
    steps = jnp.where(free > 0.5, units[:f], units[f:])
    tangents = jax.jacfwd(move)(mu) / units[:, None] * steps
    carrier = geometry.compose(geometry.exp(leg.base_rotation), geometry.exp(leg.screw[d:] * q))
    outer = geometry.compose(carrier, geometry.exp(joint.rotation))
    Q = axes_of(geometry, released, outer, here.rotation)
    slides = jnp.zeros_like(tangents).at[f:].set(Q * free)

    arm = here.position - here.joint
    moment = moment + geometry.moment_of(arm, force)
    scale = units[f] * units[0]
    K = carried + geometry.lever(arm, force) / scale
    axes = Q[d:, d:]
    K = axes.T @ K @ axes - bent(geometry, released, Q, moment) / scale
    inner = released[:, None] * K * released + jnp.diag(1.0 - released)
    return tangents, slides, negative_eigenvalues(inner)


def bent(geometry: AbstractGeometry, released, axes, moment) -> Float[Array, "r r"]:
    """Second derivative of a universal joint's energy, since its later axis turns with the other.

    Turns α about `a`, then β about `b`, make `α a + β b + ½ α β a × b` of a rotation vector.
    """
    d = geometry.d
    turned = jax.vmap(lambda axis: geometry.bracket(axis, moment))(axes[d:, d:].T)
    product = -0.5 * (turned @ axes[d:, d:]) * released[:, None] * geometry.later(released)
    return product + product.T


def carried_work(
    geometry: AbstractGeometry, axes, force, moment
) -> Float[Array, "freedoms freedoms"]:
    """Work of a wrench on the motions of a joint along its axes, per motion that carries them."""
    d = geometry.d
    slides = jax.vmap(lambda axis: geometry.moment_of(axis, force))(axes[:d, :d].T)
    turns = jax.vmap(lambda axis: 0.5 * geometry.bracket(axis, moment))(axes[d:, d:].T)
    return jnp.zeros_like(axes).at[:, d:].set(jnp.concatenate([slides, turns]))


def axes_of(
    geometry: AbstractGeometry, released, outer: Components, leg: Components
) -> Float[Array, "freedoms freedoms"]:
    """Columns: the axes of a joint's outer frame for positions, then its own for rotations."""
    d, r = geometry.d, geometry.r
    arms = geometry.matrix(outer)
    turns = geometry.joint_axes(released, geometry.frame(outer), geometry.frame(leg))
    return jnp.zeros((d + r, d + r)).at[:d, :d].set(arms).at[d:, d:].set(turns)
