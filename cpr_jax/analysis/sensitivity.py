"""Sensitivities of an equilibrium: Π_y with its labels, its kernel (13), (17)."""

from collections.abc import Mapping, Sequence

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from ..errors import InputError, check_integer
from ..geometry import floats, namespace
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium, check_fits
from ..statics.masking import where_solved
from ..statics.unknowns import (
    unknown_labels,
)
from ..summary import in_notebook, summary
from .belonging import check_belongs
from .parameters import Selection, ranges, select
from .slopes import Hold, Slopes, slopes_at


class Sensitivity(eqx.Module):
    """How an equilibrium answers to small changes of the parameters.

    **Attributes** (SI units):

    - `Pi_y`: `∂y/∂ρ` (9), rows as `rows`, columns as `columns`, shape `(n_y, n_ρ)`.
    - `Pi_tau`: `∂τ/∂ρ` of the motor torques, shape `(n_a, n_ρ)`.
    - `Pi_turn`: small rotations of a body about the world axes, rad, shape `(r, n_ρ)`; without
        rows for a point.
    - `delta`: half ranges δρ (6), shape `(n_ρ,)`.
    - `y`, `rho`: nominal unknowns and parameters.
    - `platform_stiffness`: `∂(Σ n_i)/∂p_P` with the motors held, and for a body the moments per
        small rotation about the world axes too, shape `(n_p, n_p)`, N/m, N, N·m. Symmetric where
        all loads have a potential; positive definite where the platform is stable; NaN where a leg
        is rigid in a direction, such as a straight rod that does not stretch.
    - `rows`, `columns`: labels of y and ρ; `column_units`: SI units of ρ.
    - `hold`: what was held.
    """

    Pi_y: Float[Array, "n_y n_rho"]
    Pi_tau: Float[Array, "n_a n_rho"]
    Pi_turn: Float[Array, "turns n_rho"]
    delta: Float[Array, " n_rho"]
    y: Float[Array, " n_y"]
    rho: Float[Array, " n_rho"]
    platform_stiffness: Float[Array, "n_p n_p"]
    rows: tuple[str, ...] = eqx.field(static=True)
    columns: tuple[str, ...] = eqx.field(static=True)
    column_units: tuple[str, ...] = eqx.field(static=True)
    hold: Hold = eqx.field(static=True)

    @property
    def kernel(self) -> Float[Array, "n_y n_y"]:
        """State sensitivity kernel `K = Π_y W Π_yᵀ`, `W = diag(δρ²)` (13)."""
        xp = namespace(self.Pi_y, self.delta)
        scaled = xp.multiply(self.Pi_y, self.delta)
        return floats(scaled @ scaled.T)

    @property
    def tube_radius(self) -> Float[Array, " n_y"]:
        """`√K_jj` of each state: how far the ellipsoid reaches along it."""
        xp = namespace(self.Pi_y, self.delta)
        return floats(xp.sqrt(xp.sum(xp.multiply(self.Pi_y, self.delta) ** 2, axis=1)))

    def indices(self, rows: str | Sequence[str]) -> tuple[int, ...]:
        """Places of the rows that a label, or the part of it before an axis, names (16)."""
        names = (rows,) if isinstance(rows, str) else tuple(rows)
        found = []
        for name in names:
            hits = [
                i
                for i, row in enumerate(self.rows)
                if row == name or (name and row.rpartition("_")[0] == name)
            ]
            if not hits:
                raise InputError(
                    f"Argument `rows` must name states ({', '.join(self.rows)}), but it names "
                    f"{name!r}."
                )
            found += hits
        return tuple(found)

    def Pi(self, rows: str | Sequence[str] = "p_P") -> Float[Array, "n_r n_rho"]:
        """`Π_{y_r} = S Π_y` (16) of the named rows."""
        xp = namespace(self.Pi_y)
        return floats(xp.asarray(self.Pi_y)[np.array(self.indices(rows))])

    @property
    def Pi_p(self) -> Float[Array, "d n_rho"]:
        """`∂p_P/∂ρ` of the end-effector's position."""
        return self.Pi("p_P")

    _repr_pretty_ = in_notebook

    def __str__(self) -> str:
        return summary(
            self,
            f"Sensitivity to {', '.join(self.columns)} with the {self.hold.value} held",
            delta=self.delta,
            Pi_p=self.Pi_p,
            Pi_tau=self.Pi_tau,
            tube_radius=self.tube_radius,
        )


def sensitivity(
    robot: Robot,
    equilibrium: Equilibrium,
    parameters: Sequence[str] | None = None,
    delta: Mapping[str, float] | None = None,
    hold: Hold | str = Hold.MOTORS,
    steps: int = DEFAULT_STEPS,
) -> Sensitivity:
    """The sensitivity of an equilibrium to parameters of its robot.

    **Arguments:**

    - `parameters`: labels, see `select`; by default those with a declared uncertainty.
    - `delta`: half ranges δρ by label, where they differ from those of the robot.
    - `hold`: `"motors"` (the platform moves: the sensitivity of the end-effector) or
        `"platform"` (the imposed platform of (15) stays, the motors move).

    **Raises:** `ValueError` for labels or ranges that do not fit.
    """
    try:
        hold = Hold(hold)
    except ValueError:
        raise InputError(
            f"Argument `hold` must be 'motors' or 'platform', but it is {hold!r}."
        ) from None
    check_integer("steps", steps)
    check_fits("equilibrium", equilibrium, robot)
    selection = select(robot, parameters)
    if hold is Hold.PLATFORM and robot.n_a != robot.n_p:
        raise InputError(
            f"Argument `hold` must be 'motors' for {robot.name}: {robot.n_a} motors cannot hold "
            f"{robot.n_p} platform coordinates."
        )
    robot = where_solved(robot, equilibrium)
    half_ranges, y = ranges(robot, selection, delta), equilibrium.y
    slopes = slopes_at(robot, y, selection, steps)
    check_belongs(robot, equilibrium, slopes.residual)
    return named(robot, y, selection, half_ranges, slopes, hold)


def named(
    robot: Robot,
    y: Float[Array, " n_y"],
    selection: Selection,
    half_ranges: Float[Array, " n_rho"],
    slopes: Slopes,
    hold: Hold,
) -> Sensitivity:
    """Slopes with their labels."""
    answer = slopes.answers[hold.value]
    return Sensitivity(
        Pi_y=answer.Pi_y,
        Pi_tau=answer.Pi_tau,
        Pi_turn=answer.Pi_turn,
        delta=half_ranges,
        y=y,
        rho=slopes.rho,
        platform_stiffness=slopes.platform_stiffness,
        rows=unknown_labels(robot),
        columns=selection.labels,
        column_units=selection.units,
        hold=hold,
    )
