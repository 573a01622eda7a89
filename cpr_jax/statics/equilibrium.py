"""A static configuration of a robot, with what is known of it."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..errors import InputError
from ..programs import program
from ..robots.robot import Robot
from ..summary import in_notebook, summary
from .measures import Measures, measures_with
from .problem import Problem
from .reach import used_up
from .residual import base_wrench, leg_base
from .roots import find_root
from .status import Status
from .unknowns import State, ravel, unknown_scales, unravel


class Equilibrium(eqx.Module):
    """A static configuration of a robot, or the reason why there is none.

    Where `status` is not `SOLVED`, every physical number is NaN.

    **Attributes** (SI units, world axes):

    - `q_a`: motor positions, rad or m, shape `(n_a,)`.
    - `q_p`: position of the platform, m, and rotation vector of a body, rad, shape `(n_p,)`.
    - `mu`: the unknowns of the legs, see `State`, shape `(n, d + r)`.
    - `base_wrenches`: `n_i(0)`, N, then `m_i(0)`, N·m, at the base of each rod, `(n, d + r)`.
    - `status`: a `Status` code.
    - `residual`: largest entry of the residual in units of `scales(robot)`.
    - `measures`: conditioning, distance to singularities, motor torques, energy.
    - `branch`: how the branch was chosen: `home` or `search`, from whatever neighbours on it this
        one was then followed.
    """

    q_a: Float[Array, " n_a"]
    q_p: Float[Array, " n_p"]
    mu: Float[Array, "n freedoms"]
    base_wrenches: Float[Array, "n freedoms"]
    status: Int[Array, ""]
    residual: Float[Array, ""]
    measures: Measures
    branch: str = eqx.field(static=True)

    @property
    def y(self) -> Float[Array, " n_y"]:
        """The flat unknowns `(q_a, q_p, μ_1, …, μ_n)`."""
        return ravel(State(self.q_a, self.q_p, self.mu))

    _repr_pretty_ = in_notebook

    def __str__(self) -> str:
        if np.ndim(self.status) > 0 or isinstance(self.status, jax.core.Tracer):
            return repr(self)
        return summary(
            self,
            f"Equilibrium on the branch of '{self.branch}': {Status(int(self.status)).message}",
            q_a=self.q_a,
            q_p=self.q_p,
            motor_torques=self.motor_torques,
            energy=self.measures.energy,
            residual=self.residual,
            sigma_t1=self.measures.sigma_t1,
            sigma_t2=self.measures.sigma_t2,
        )

    @property
    def motor_torques(self) -> Float[Array, " n_a"]:
        """What the motors exert on the legs, N·m (N where they slide)."""
        return self.measures.motor_torques


@program
def polish(robot, imposed, target, y, outcome, tolerance, branch, steps):
    """The equilibrium at the end of a track, with its derivatives and its measures.

    **Arguments:**

    - `y`, `outcome`: the unknowns there and the status of the track.
    - `tolerance`: largest `Measures.unbalanced` that is accepted.
    """
    guess = jnp.where(outcome == Status.SOLVED, y, jnp.nan)
    root = find_root(Problem(robot, imposed, target), guess, steps=steps, look=True)
    assert root.jacobian is not None
    matrix, left = jax.lax.stop_gradient((root.jacobian, root.residual))
    # What is masked below must have derivatives all the same: zero times NaN is NaN.
    found = jnp.where(root.status == Status.SOLVED, root.y, 0.0)
    n_a, n_r = robot.n_a, robot.n_y - robot.n_a
    regular = np.concatenate([np.eye(n_r, n_a), np.eye(n_r)], axis=1)
    matrix = jnp.where(root.status == Status.SOLVED, matrix[:n_r], regular)
    measures = measures_with(robot, found, matrix, steps)
    stayed = jnp.max(jnp.abs(found - guess) / unknown_scales(robot)) < 1e-3
    status = jnp.where((root.status == Status.SOLVED) & ~stayed, Status.LOST, root.status)
    if robot.legs.feed is not None:
        gone = used_up(robot, found[: robot.n_a])
        status = jnp.where((status == Status.SOLVED) & gone, Status.OUT_OF_REACH, status)
    rough = ~(measures.unbalanced <= tolerance)
    status = jnp.where((status == Status.SOLVED) & rough, Status.INACCURATE, status)
    status = jnp.where(outcome == Status.SOLVED, status, outcome)
    solved = status == Status.SOLVED
    y = jnp.where(solved, root.y, jnp.nan)
    measures = jax.tree.map(lambda leaf: jnp.where(solved, leaf, jnp.nan), measures)
    state, wrenches = unravel(robot, y), base_wrenches(robot, unravel(robot, found))
    return Equilibrium(
        q_a=state.q_a,
        q_p=state.q_p,
        mu=state.mu,
        base_wrenches=jnp.where(solved, wrenches, jnp.nan),
        status=status,
        residual=jnp.where(solved, left, jnp.nan),
        measures=measures,
        branch=branch,
    )


def base_wrenches(robot: Robot, state: State) -> Float[Array, "n freedoms"]:
    """`Equilibrium.base_wrenches` of one configuration."""
    if robot.legs.base_joint is None:
        return state.mu
    geometry = robot.geometry

    def one(leg, q, mu):
        return base_wrench(geometry, leg_base(geometry, leg, q, mu))

    return jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu)


def check_fits(name: str, equilibrium: Any, robot: Robot) -> None:
    """Refuses what is no equilibrium, or one of a robot with other motors, legs or platform."""
    if not isinstance(equilibrium, Equilibrium):
        kind = type(equilibrium).__name__
        raise InputError(f"Argument `{name}` must be an Equilibrium, but it is a {kind}.")
    shapes = (*equilibrium.q_a.shape, *equilibrium.q_p.shape, *equilibrium.mu.shape)
    if np.ndim(equilibrium.status) > 0:
        raise InputError(
            f"Argument `{name}` must be one equilibrium, but it is a batch of "
            f"{np.shape(equilibrium.status)}: take one of them, or use `jax.vmap`."
        )
    expected = (robot.n_a, robot.n_p, robot.n, robot.geometry.freedoms)
    if shapes != expected:
        raise InputError(
            f"Argument `{name}` must be an equilibrium of a robot like {robot.name}, but its "
            f"motors, coordinates, legs and wrenches number {shapes} instead of {expected}."
        )


def check_solved(name: str, equilibrium: Equilibrium) -> None:
    """Refuses an equilibrium that is none; not within a transformation, where it is not known."""
    status = Status(int(equilibrium.status))
    if status != Status.SOLVED:
        raise InputError(f"Argument `{name}` must be solved, but its status is {status.name}.")
