"""The search for a design: what is evaluated, and from where."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..analysis.stability import stability
from ..errors import InputError
from ..programs import quick_jit
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium, solve_inverse
from ..statics.status import SolveError, Status

_REFUSED = 10.0
"""What a design that does not work counts, in units of the objective at the start: the search goes
a tenth of the way from the last one that does, again and again."""

Build = Callable[[dict[str, Array]], Robot]
Measure = Callable[[Robot, Equilibrium], Array]


class Trial(NamedTuple):
    """A design between its bounds, each from 0 to 1, and the objective in units of the start's."""

    x: np.ndarray
    value: float
    slope: np.ndarray
    slack: np.ndarray
    slack_slope: np.ndarray
    equilibria: Equilibrium
    refused: str

    @property
    def works(self) -> bool:
        """Whether all its configurations are there."""
        return not self.refused


class Search:
    """Evaluates designs, each followed from the last that works.

    **Attributes:**

    - `near`: the last design that works.
    - `unit`: of the objective: its absolute value at the start.
    - `refused`: why a design does not work that was tried between the last two that do, or since.
    """

    near: Trial
    unit: float
    _last: Trial

    def __init__(self, build, names, low, span, objective, constraints, unstable):
        self.names, self.history = names, []
        self._low, self._span = low, span
        self._build, self._objective, self._constraints = build, objective, constraints
        self._unstable = unstable
        self.refused, self._turned = "", False

    def values(self, x: np.ndarray) -> dict[str, float]:
        """The design variables."""
        return dict(zip(self.names, (self._low + x * self._span).tolist(), strict=True))

    def begin(self, robot: Robot, points: np.ndarray, imposed, start) -> None:
        """Solves the first design from its home, point by point."""
        self._points, self._imposed = points, imposed
        solved = [solve_inverse(robot, point, imposed=imposed, throw=False) for point in points]
        for point, one in zip(points, solved, strict=True):
            status = Status(int(one.status))
            if status != Status.SOLVED:
                raise SolveError(
                    status, f"No equilibrium of the start at {point.tolist()}: {status.message}."
                )
        equilibria = jax.tree.map(lambda *leaves: jnp.stack(leaves), *solved)
        x = (np.array([start[name] for name in self.names], float) - self._low) / self._span
        self._evaluate = quick_jit(self._traced)
        self.unit = 1.0
        first = self._trial(x, equilibria)
        if not first.works:
            raise InputError(f"Argument `start` must be a design that works, but {first.refused}.")
        self.unit = abs(first.value) or 1.0
        self._keep(first._replace(value=first.value / self.unit, slope=first.slope / self.unit))

    def at(self, x: np.ndarray) -> Trial:
        """A design; one that does not work is far worse than the last one that does."""
        if not np.array_equal(self._last.x, x):
            trial = self._trial(np.clip(x, 0.0, 1.0), self.near.equilibria)
            if trial.works:
                self._keep(trial._replace(x=np.array(x)))
            else:
                worse = self.near.value + _REFUSED
                self.refused, self._turned = trial.refused, True
                self._last = self.near._replace(x=np.array(x), value=worse, refused=trial.refused)
        return self._last

    def _keep(self, trial: Trial) -> None:
        if not self._turned:
            self.refused = ""
        self._turned = False
        self.near = self._last = trial
        self.history.append((self.values(np.clip(trial.x, 0.0, 1.0)), trial.value * self.unit))

    def inequalities(self) -> list[dict[str, Any]]:
        """The constraints, as SciPy takes them."""
        if self.near.slack.size == 0:
            return []
        count = len(self.names)
        return [
            {
                "type": "ineq",
                "fun": lambda x: self.at(x).slack.ravel(),
                "jac": lambda x: self.at(x).slack_slope.reshape(-1, count),
            }
        ]

    def _trial(self, x: np.ndarray, near: Equilibrium) -> Trial:
        (slopes, slack_slopes), (values, slack, found, index) = self._evaluate(x, near)
        numbers = np.column_stack([values, slopes, slack, slack_slopes.reshape(len(values), -1)])
        return Trial(
            x,
            float(np.mean(values)) / self.unit,
            np.mean(slopes, axis=0) / self.unit,
            np.asarray(slack),
            np.asarray(slack_slopes),
            found,
            self._refusal(np.asarray(found.status), np.asarray(index), numbers),
        )

    def _refusal(self, status: np.ndarray, index: np.ndarray, numbers: np.ndarray) -> str:
        """Why a design does not work, in words, or nothing."""
        unsolved = np.flatnonzero(status != Status.SOLVED)
        unstable = np.flatnonzero(index != 0)
        strange = np.flatnonzero(~np.all(np.isfinite(numbers), axis=1))
        if len(unsolved):
            why = Status(int(status[unsolved[0]])).message
            return f"there is no equilibrium at point {unsolved[0]}: {why}"
        if len(unstable):
            return f"point {unstable[0]} is unstable"
        if len(strange):
            return f"the objective or a constraint is not finite at point {strange[0]}"
        return ""

    def _traced(self, x, near: Equilibrium):
        """Derivatives of objective and constraints at each point, then their values."""
        points = jnp.asarray(self._points)

        def at_all(x):
            numbers = self._low + x * self._span
            robot = self._build(dict(zip(self.names, numbers, strict=True)))

            def at(point, guess):
                here = solve_inverse(robot, point, imposed=self._imposed, guess=guess, throw=False)
                value = jnp.asarray(self._objective(robot, here))
                slack = jnp.zeros(0)
                if self._constraints is not None:
                    slack = jnp.ravel(self._constraints(robot, here))
                index = jnp.zeros((), int) if self._unstable else stability(robot, here).index
                return value, slack, here, index

            value, slack, here, index = jax.vmap(at)(points, near)
            return (value, slack), (value, slack, here, index)

        return jax.jacfwd(at_all, has_aux=True)(x)
