"""How the platform answers to its motors and to loads at an equilibrium."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..errors import check_integer
from ..programs import brief_program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium, check_fits
from ..statics.linear import inverse, regular_inverse, row_axes
from ..statics.masking import where_solved
from ..statics.residual import residual
from ..statics.singular_values import evenness
from ..statics.turns import motion_jacobian
from ..statics.unknowns import scales, unknown_scales, unravel
from ..summary import in_notebook, summary
from .belonging import check_belongs


class Mobility(eqx.Module):
    """First-order answers of the platform, the robot staying in equilibrium (SI units).

    Motions are translations of `p_P`, m, then for a body small rotations about the world axes,
    rad; loads are forces, N, then moments about `p_P`, N·m.

    **Attributes:**

    - `jacobian`: motion per motion of the motors, shape `(n_p, n_a)`.
    - `compliance`: motion per load, the motors held, shape `(n_p, n_p)`.
    - `manipulability`: `√det(J Jᵀ)` of the rows of the position, `d` of them.
    - `condition`: smallest over largest singular value of these rows; 1 where the motors move the
        position alike in all directions, 0 where they cannot move it in one.
    """

    jacobian: Float[Array, "n_p n_a"]
    compliance: Float[Array, "n_p n_p"]
    manipulability: Float[Array, ""]
    condition: Float[Array, ""]

    _repr_pretty_ = in_notebook

    def __str__(self) -> str:
        return summary(
            self,
            "Mobility of the platform",
            jacobian=self.jacobian,
            compliance=self.compliance,
            manipulability=self.manipulability,
            condition=self.condition,
        )

    @property
    def stiffness(self) -> Float[Array, "n_p n_p"]:
        """Load per motion, the motors held: the inverse of `compliance`.

        NaN where the platform is rigid in a direction, as a straight rod that does not stretch
        holds it.
        """
        return regular_inverse(self.compliance)


def mobility(robot: Robot, equilibrium: Equilibrium, steps: int = DEFAULT_STEPS) -> Mobility:
    """The platform's motion per motor and per load at an equilibrium."""
    check_integer("steps", steps)
    check_fits("equilibrium", equilibrium, robot)
    found, left = _mobility(where_solved(robot, equilibrium).unnamed, equilibrium.y, steps)
    check_belongs(robot, equilibrium, left)
    return found


@brief_program
def _mobility(
    robot: Robot, y: Float[Array, " n_y"], steps: int
) -> tuple[Mobility, Float[Array, ""]]:
    """With the largest entry of the residual."""
    units = unknown_scales(robot)
    n_a, n_p, d = robot.n_a, robot.n_p, robot.geometry.d

    def rows(scaled):
        R_0 = residual(robot, unravel(robot, scaled * units), steps)
        return R_0, R_0

    matrix, R_0 = jax.jacfwd(rows, has_aux=True)(y / units)
    inverted = inverse(matrix[:, n_a:])[:n_p] * units[n_a : n_a + n_p, None]
    motion = motion_jacobian(robot, y[n_a : n_a + n_p])
    jacobian = -motion @ inverted @ matrix[:, :n_a] / units[:n_a]
    # The balance of the platform is `load - Σ wrenches`, in units of wrenches.
    compliance = -motion @ inverted[:, :n_p] / scales(robot).wrench(robot)[:n_p]
    stretch, _ = row_axes(jacobian[:d])
    found = Mobility(
        jacobian=jacobian,
        compliance=compliance,
        manipulability=jnp.prod(stretch),
        condition=evenness(stretch),
    )
    return found, jnp.max(jnp.abs(R_0))
