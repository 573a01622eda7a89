"""From an equilibrium of the same robot, or of one like it, to another."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Steps
from .continuation import Track
from .unknowns import base_freedoms, ravel, unravel
from .ways import follow_path, gap_of, straight

_FACTORS = 2.0 ** np.linspace(-3.0, 3.0, 33)
"""By which wrenches of a neighbour are scaled, and ..."""

_NEAR = 2.0 ** (np.array([[0.1875], [0.0375], [0.0]]) * np.linspace(-1.0, 1.0, 11))
"""... how far on to both sides around those of which the joints gape less than at the next ones."""


@program
def from_neighbour(
    robot: Robot,
    imposed: Float[Array, "n_a n_q"],
    y: Float[Array, " n_y"],
    goal: Float[Array, " n_q"],
    steps: Steps,
) -> tuple[Float[Array, " n_y"], Track]:
    """Follows the branch of an equilibrium, of this robot or of one like it, to a goal.

    **Returns:** where the way begins, see `fitted`, and the way.
    """
    start = fitted(robot, y, steps)
    begin = start[: robot.n_a + robot.n_p]
    return start, follow_path(robot, imposed, start, straight(begin, goal), steps)


def fitted(robot: Robot, y: Float[Array, " n_y"], steps: Steps = DEFAULT_STEPS) -> Array:
    """Unknowns of a robot with other numbers, their wrenches scaled to where its joints gape least.

    A softer rod that carried the old wrenches would bend further than the branch allows. What the
    platform lacks to its equilibrium does not count: another load on it is no reason for the rods
    to have another shape, and to follow it is what the way is for.
    """
    state = unravel(robot, y)
    moves = base_freedoms(robot) > 0.5

    def strained(factor):
        return jnp.where(moves, state.mu, factor * state.mu)

    def missing(factor):
        scaled = ravel(state._replace(mu=strained(factor)))
        left = jnp.max(jnp.abs(gap_of(robot, scaled, steps)[robot.n_p :]))
        return jnp.where(jnp.isfinite(left), left, jnp.inf)

    def closer(factors, near):
        gaps = jax.vmap(missing)(factors)
        beside = jnp.pad(gaps, 1, constant_values=jnp.inf)
        lowest = (gaps <= beside[:-2]) & (gaps <= beside[2:])
        _, places = jax.lax.top_k(
            jnp.where(lowest, -gaps, -jnp.inf), len(_FACTORS) // _NEAR.shape[1]
        )
        around = factors[places, None] * near
        return around.reshape(-1), factors[jnp.argmin(gaps)]

    # The right valley is so narrow that between two factors a wrong one may look deeper. A loop
    # keeps one copy of the integration in the compiled program.
    _, best = jax.lax.scan(closer, jnp.asarray(_FACTORS), jnp.asarray(_NEAR))
    return ravel(state._replace(mu=strained(best[-1])))
