"""The sensitivity along a leg, Π_i(s) (7)–(8)."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..errors import InputError, check_integer
from ..programs import brief_program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS, rod_shape
from ..rods.segments import arc_lengths, segments_of
from ..statics.equilibrium import Equilibrium, check_fits
from ..statics.masking import where_solved
from ..statics.residual import leg_base, rod_from, to_world
from ..statics.unknowns import unravel
from .naming import segment_count
from .parameters import Selection, select


class LegSensitivity(eqx.Module):
    """`Π_i(s) = ∂x_i(s)/∂ρ_i` along a leg, its base state held: `Π_i(0) = 0` (7)–(8).

    The derivative is that of one cross-section: as a rod (or one of its segments) becomes longer,
    each stays at its share of the length rather than at its `s`.

    **Attributes:**

    - `s`: arc length, m, with what is fed, shape `(points,)`.
    - `Pi`: shape `(points, n_x, n_ρ)`; rows as `rows`: position, rotation (of the
        cross-section, rad, world axes), force, moment.
    - `rows`, `columns`: labels.
    """

    s: Float[Array, " points"]
    Pi: Float[Array, "points n_x n_rho"]
    rows: tuple[str, ...] = eqx.field(static=True)
    columns: tuple[str, ...] = eqx.field(static=True)


def leg_sensitivity(
    robot: Robot,
    equilibrium: Equilibrium,
    leg: int,
    parameters: Sequence[str] | None = None,
    points: int = 33,
) -> LegSensitivity:
    """The state sensitivity along leg `leg` (counted from 1), equations (7) and (8).

    **Arguments:**

    - `parameters`: labels of this leg's parameters; by default `k_b` and `r_c` of the leg (its
        precurvature `kappa` where it is straight), or of each segment of its rod.
    - `points`: number of equidistant arc lengths; of a rod with further segments, in each of them,
        both ends of which are among them. The integration takes at least `DEFAULT_STEPS` steps.
    """
    check_fits("equilibrium", equilibrium, robot)
    check_integer("points", points, least=2)
    check_integer("leg", leg)
    if leg > robot.n:
        raise InputError(f"Argument `leg` must be between 1 and {robot.n}, but it is {leg}.")
    if parameters is None:
        rests = segments_of(robot.leg(leg - 1).rod).precurvature[: segment_count(robot, leg - 1)]
        if isinstance(rests, jax.core.Tracer):
            raise InputError(
                "Argument `parameters` must be given inside a JAX transformation, where nobody can "
                "tell whether a rod is straight, but it is None."
            )
        names = [f"{leg}"] if len(rests) == 1 else [f"{leg}_{j + 1}" for j in range(len(rests))]
        parameters = tuple(
            f"{kind}{name}"
            for name, rest in zip(names, rests, strict=True)
            for kind in ("k_b", "r_c" if float(rest[-1]) != 0.0 else "kappa")
        )
    selection = select(robot, parameters)
    robot = where_solved(robot, equilibrium)
    finer = -(-DEFAULT_STEPS // (points - 1))
    s, Pi = _along_leg(robot, equilibrium.y, selection, leg - 1, (points - 1) * finer)
    s, Pi = s[::finer], Pi[::finer]
    # What follows are the segments that only other legs have.
    nodes = 1 + (segment_count(robot, leg - 1) or len(s)) * (points - 1)
    geometry = robot.geometry
    rows = (
        *(f"p_{axis}" for axis in geometry.axes),
        *(f"theta_{axis}" for axis in geometry.rotation_axes),
        *(f"n_{axis}" for axis in geometry.axes),
        *(f"m_{axis}" for axis in geometry.rotation_axes),
    )
    return LegSensitivity(s=s[:nodes], Pi=Pi[:nodes], rows=rows, columns=selection.labels)


@brief_program
def _along_leg(robot, y, selection: Selection, leg: int, steps: int):
    geometry = robot.geometry
    state = unravel(robot, y)
    q = (robot.transmission @ state.q_a)[leg]

    def shape(rho):
        varied = selection.set(robot, rho).leg(leg)
        # The base state is held, whatever the parameters do to what is before it.
        rod = rod_from(geometry, geometry.frame(fixed.rotation), varied, q)
        along = rod_shape(geometry, rod, fixed.force, fixed.moment, steps)
        return jax.vmap(lambda x: to_world(geometry, fixed, x))(along)

    fixed = leg_base(geometry, robot.leg(leg), q, state.mu[leg])
    rho = selection.get(robot)
    nominal = shape(rho)

    def deviation(rho):
        varied = shape(rho)
        turn = jax.vmap(
            lambda new, old: jnp.stack(geometry.log(geometry.compose(new, geometry.inverse(old))))
        )(varied.rotation, nominal.rotation)
        return jnp.concatenate([varied.position, turn, varied.force, varied.moment], axis=1)

    return arc_lengths(fixed.rod, steps), jax.jacfwd(deviation)(rho)
