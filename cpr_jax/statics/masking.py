"""Failed lanes of a batch, and derivatives that they are not to spoil."""

import jax
import jax.numpy as jnp

from ..outline import are_traced
from ..robots.robot import Robot
from .equilibrium import Equilibrium
from .status import Status


def where_solved(robot: Robot, equilibrium: Equilibrium) -> Robot:
    """The robot, whose numbers have no derivatives where the equilibrium is none.

    Those of NaN are NaN even if what was computed from it is masked: in reverse mode one failed
    lane would spoil the gradient of a whole batch in numbers that all lanes share.
    """
    if not are_traced(jax.tree.leaves(robot)):
        return robot
    solved = equilibrium.status == Status.SOLVED

    def one(leaf):
        if not isinstance(leaf, jax.core.Tracer):
            return leaf
        return jnp.where(solved, leaf, jax.lax.stop_gradient(leaf))

    return jax.tree.map(one, robot)
