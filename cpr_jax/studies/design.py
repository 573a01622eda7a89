"""Design optimisation: numbers of a robot that make it best over many configurations."""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.optimize import minimize

from ..analysis.ellipsoid import ellipsoid
from ..analysis.sensitivity import sensitivity
from ..checks import check_positive, finite_rows
from ..errors import InputError, check_integer, shown
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.problem import imposed_coordinates
from ..statics.unknowns import unknown_labels
from ..summary import in_notebook, summary
from .design_search import SLACK, Build, Measure, Search


class Design(NamedTuple):
    """The optimal design, or the best of those that were tried where the search has not converged.

    **Attributes:**

    - `values`: of the design variables.
    - `robot`: with them.
    - `objective`: its mean over the points.
    - `equilibria`: of the robot at the points, stacked along a first axis.
    - `slack`: the constraints there, `(points, m)`; negative where one is not fulfilled.
    - `history`: values and objective of every design that was tried and works, the start first.
    - `converged`: whether it is a minimum as far as the first derivatives tell. It is not where the
        search ended beside designs that do not work: a constraint is then to keep it off them.
    - `message`: how the search ended.
    """

    values: dict[str, float]
    robot: Robot
    objective: float
    equilibria: Equilibrium
    slack: Float[np.ndarray, "points m"]
    history: list[tuple[dict[str, float], float]]
    converged: bool
    message: str

    def equilibrium(self, k: int) -> Equilibrium:
        """That at the k-th point."""
        return jax.tree.map(lambda leaf: leaf[k], self.equilibria)

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        in_notebook(self, printer, cycle)

    def __str__(self) -> str:
        found = "Best design" if self.converged else "Not converged, the best design"
        return summary(
            self,
            f"{found} of {len(self.history)} that work: {self.message}",
            values=", ".join(f"{name} = {value:.6g}" for name, value in self.values.items()),
            objective=self.objective,
            slack=np.min(self.slack) if self.slack.size else "no constraints",
        )


def position_spread(robot: Robot, equilibrium: Equilibrium) -> Float[Array, ""]:
    """The root of the sum of the squared semi-axes of the position's ellipsoid (17), m.

    Unlike the largest semi-axis it is smooth where two of them are the same.
    """
    return jnp.sqrt(jnp.trace(ellipsoid(sensitivity(robot, equilibrium)).kernel))


def optimise_design(
    build: Build,
    start: Mapping[str, float],
    bounds: Mapping[str, Sequence[float]],
    points: Sequence[Sequence[float]] | Float[np.ndarray, "points n_a"],
    objective: Measure = position_spread,
    *,
    imposed: Sequence[str] | None = None,
    constraints: Measure | None = None,
    unstable: bool = False,
    iterations: int = 100,
    tolerance: float = 1e-6,
) -> Design:
    """The design of least mean objective over configurations, within bounds and constraints.

    Sequential quadratic programming (SciPy's SLSQP) with derivatives through the solves. Each
    configuration is followed from design to design, in steps of at most a tenth of the range of a
    variable, and shorter ones where it moves far. Designs at which one of them is lost, or
    unstable, are refused, and the search turns back from them.

    **Arguments:**

    - `build`: makes a robot from values of the design variables, under `jax.jit`, such as
        `lambda x: rfrfr(l=x["l"], d=x["d"])`.
    - `start`, `bounds`: where the search begins, and lowest and highest value of each variable.
    - `points`: imposed coordinates of the configurations, SI units.
    - `objective`: what to minimise, a number of a robot and one of its equilibria.
    - `imposed`: which coordinates `points` holds, as in `solve_inverse`.
    - `constraints`: numbers that must not be negative at any of the points, an array of a robot and
        one of its equilibria, such as `lambda robot, e: 1.0 - (e.motor_torques / 0.5) ** 2`.
    - `unstable`: whether unstable configurations are allowed.
    - `iterations`: at most.
    - `tolerance`: change of the objective at which it ends, relative to that of the start.

    **Raises:** `ValueError` for a bad argument; `SolveError` where the start has no solution at one
    of the points.
    """
    names = _checked_names(start, bounds)
    check_integer("iterations", iterations)
    check_positive("tolerance", tolerance)
    low, high = np.array([bounds[name] for name in names], float).T
    search = Search(build, names, low, high - low, objective, constraints, unstable)
    robot = build({name: jnp.asarray(float(start[name])) for name in names})
    if not isinstance(robot, Robot):
        raise InputError(f"Argument `build` must return a Robot, but it returned {shown(robot)}.")
    labels = [unknown_labels(robot)[place] for place in imposed_coordinates(robot, imposed)]
    search.begin(robot, finite_rows("points", points, labels), imposed, start)

    with warnings.catch_warnings():
        # Rounding takes trial designs past their bounds; SciPy moves them back and says so.
        warnings.filterwarnings("ignore", "Values in x were outside bounds", RuntimeWarning)
        found = minimize(
            lambda x: search.at(x).value,
            search.near.x,
            jac=lambda x: search.at(x).slope,
            bounds=[(0.0, 1.0)] * len(names),
            constraints=search.inequalities(),
            method="SLSQP",
            options={"maxiter": iterations, "ftol": tolerance},
        )
    # To evaluate it once more may forget what stood in its way.
    refused = search.refused
    last = search.at(found.x)
    missed = -float(np.min(last.slack, initial=0.0))
    converged = bool(found.success) and last.works and not refused and missed <= SLACK
    best = last if converged else search.best
    message = str(found.message)
    if refused:
        message = f"ended beside designs that do not work ({refused}): see `constraints`"
    elif missed > SLACK:
        point = int(np.argmin(np.min(last.slack, axis=1)))
        message = f"a constraint is missed by {missed:.3g} at point {point}: {message}"
    values = search.values(np.clip(best.x, 0.0, 1.0))
    return Design(
        values=values,
        robot=build({name: jnp.asarray(value) for name, value in values.items()}),
        objective=best.value * search.unit,
        equilibria=best.equilibria,
        slack=best.slack,
        history=search.history,
        converged=converged,
        message=message,
    )


def _checked_names(start: Mapping[str, float], bounds: Mapping[str, Sequence[float]]) -> list[str]:
    for field, table in (("start", start), ("bounds", bounds)):
        if not isinstance(table, Mapping) or not table:
            what = "is empty" if table == {} else f"is {shown(table)}"
            raise InputError(f"Argument `{field}` must be a table by name, but it {what}.")
    if set(start) != set(bounds):
        raise InputError(
            f"Argument `bounds` must have the names of `start` ({', '.join(start)}), but it has "
            f"{', '.join(bounds)}."
        )
    for name, value in start.items():
        ends = bounds[name]
        if np.shape(ends) != (2,) or not _are_numbers(ends) or not ends[0] < ends[1]:
            raise InputError(
                f"Argument `bounds[{name!r}]` must be a lowest and a highest value, but it is "
                f"{ends!r}."
            )
        if np.shape(value) != () or not _are_numbers(value) or not ends[0] <= value <= ends[1]:
            raise InputError(
                f"Argument `start[{name!r}]` must be a number within its bounds {ends!r}, but it "
                f"is {shown(value)}."
            )
    return list(start)


def _are_numbers(values: object) -> bool:
    try:
        return bool(np.all(np.isfinite(np.asarray(values, float))))
    except (TypeError, ValueError):
        return False
