"""One equilibrium from a guess, with its implicit derivative."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Float, Int

from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Steps
from .correction import linearised
from .newton import LaneAdjoint, LaneNewton
from .problem import Problem, full_residual
from .status import Status
from .unknowns import unknown_scales

TOLERANCE = 1e-10
"""A solution's largest residual, in units of `scales(robot)`."""


class Root(NamedTuple):
    """Outcome of one root find.

    **Attributes:**

    - `y`: the unknowns in SI units, meaningful where `status` is solved.
    - `status`: a `Status` code.
    - `residual`: largest entry of the dimensionless residual at `y`.
    - `sign`: sign of `det ∂R/∂y`; it changes where the branch folds.
    - `iterations`: of Newton's method.
    - `jacobian`: `∂R/∂y` at the root in the dimensionless unknowns, if it was asked for.
    """

    y: Float[Array, " n_y"]
    status: Int[Array, ""]
    residual: Float[Array, ""]
    sign: Float[Array, ""]
    iterations: Int[Array, ""]
    jacobian: Float[Array, "n_y n_y"] | None = None


def find_root(
    problem: Problem,
    guess: Float[Array, " n_y"],
    *,
    steps: Steps = DEFAULT_STEPS,
    max_iterations: int = 20,
    max_step: float = 1.0,
    atol: float = 1e-9,
    verify: bool = True,
    look: bool = False,
) -> Root:
    """Newton's method from a guess (SI units). Differentiable in every leaf of `problem`.

    Once the residual is below `atol` one more Newton step is added, which squares the error.
    With `verify` the residual is evaluated once more at the root; without, it is the one before
    the last Newton step, an upper bound, and the caller is to look at the root itself. With `look`
    the Jacobian and the residual at the root come from one more pass of the iteration.
    """
    units = unknown_scales(problem.robot)
    solution: optx.Solution = optx.root_find(
        lambda scaled, args: full_residual(scaled, *args),
        LaneNewton(
            atol=atol,
            max_step=max_step,
            look=look,
            linearise=_linearise,
        ),
        jax.lax.stop_gradient(guess) / units,
        args=(problem, jnp.asarray(steps)),
        max_steps=max_iterations + look,
        adjoint=LaneAdjoint(),
        throw=False,
    )
    scaled = solution.value
    left = solution.stats["norm"]
    converged = jnp.asarray(solution.result == optx.RESULTS.successful)
    if look:
        converged = converged & (left < TOLERANCE)
    elif verify:
        frozen, still = jax.lax.stop_gradient((scaled, problem))
        left = jnp.max(jnp.abs(full_residual(frozen, still, steps)))
        converged = converged & (left < TOLERANCE)
    finite = jnp.isfinite(solution.stats["norm"])
    status = jnp.where(
        converged,
        Status.SOLVED,
        jnp.where(finite, Status.NOT_CONVERGED, Status.NOT_FINITE),
    )
    stats = solution.stats
    return Root(scaled * units, status, left, stats["sign"], stats["num_steps"], stats["jacobian"])


def _linearise(scaled, args):
    problem, steps = args
    return linearised(problem, scaled, steps)
