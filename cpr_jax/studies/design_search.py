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
from ..statics.equilibrium import Equilibrium
from ..statics.solve import solve_inverse
from ..statics.status import SolveError, Status
from ..statics.unknowns import unknown_scales

_REFUSED = 10.0
"""What a design that does not work counts, in units of the objective at the start: the search goes
a tenth of the way from the last one that does, again and again."""

_LONGEST, _SHORTEST = 0.1, 2e-4
"""Steps in which configurations are followed to another design, of the range of a variable."""

_MOVED = 0.5
"""Largest change of a dimensionless unknown in one."""

SLACK = 1e-6
"""By how much a constraint may be missed."""

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
    - `best`: of those that work and fulfil the constraints the one of least objective; as long as
        there is none, the one that misses them least.
    - `unit`: of the objective: its absolute value at the start.
    - `refused`: why a design does not work that was tried between the last two that do, or since.
    """

    near: Trial
    best: Trial
    unit: float
    _last: Trial

    def __init__(self, build, names, low, span, objective, constraints, unstable):
        self.names, self.history = names, []
        self.refused, self._turned = "", False
        self._low, self._span = low, span
        self._build, self._objective, self._constraints = build, objective, constraints
        self._unstable = unstable

    def values(self, x: np.ndarray) -> dict[str, float]:
        """The design variables."""
        return dict(zip(self.names, (self._low + x * self._span).tolist(), strict=True))

    def begin(self, robot: Robot, points: np.ndarray, imposed, start) -> None:
        """Solves the first design from its home, point by point."""
        self._points, self._imposed = points, imposed
        self._units = np.asarray(unknown_scales(robot))
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
        self.best = first._replace(value=first.value / self.unit, slope=first.slope / self.unit)
        self._keep(self.best)

    def at(self, x: np.ndarray) -> Trial:
        """A design; one that does not work is far worse than the last one that does."""
        if not np.array_equal(self._last.x, x):
            trial = self._followed(np.clip(x, 0.0, 1.0))
            if trial.works:
                self._keep(trial._replace(x=np.array(x)))
            else:
                worse = self.near.value + _REFUSED
                self.refused, self._turned = trial.refused, True
                self._last = self.near._replace(x=np.array(x), value=worse, refused=trial.refused)
        return self._last

    def _followed(self, x: np.ndarray) -> Trial:
        """A design to which the configurations are followed from the last one that works.

        In steps: to close what gapes after a long one may lead to another branch.
        """
        begin, now = np.clip(self.near.x, 0.0, 1.0), self.near
        gone, stride = 0.0, min(1.0, _LONGEST / max(np.max(np.abs(x - begin)), _LONGEST))
        while gone < 1.0:
            end = 1.0 if gone + stride > 1.0 - 1e-9 else gone + stride
            trial = self._trial(begin + end * (x - begin), now.equilibria)
            if trial.works:
                trial = self._unless_far(trial, now)
            if not trial.works:
                stride *= 0.25
                if stride * np.max(np.abs(x - begin)) < _SHORTEST:
                    return trial
                continue
            now, gone = trial, end
        return now

    def _unless_far(self, trial: Trial, before: Trial) -> Trial:
        """Refuses a step in which a configuration has moved by more than it should."""
        moves = np.abs(np.asarray(_unknowns(trial.equilibria) - _unknowns(before.equilibria)))
        far = np.flatnonzero(np.max(moves / self._units, axis=1) > _MOVED)
        if len(far):
            return trial._replace(refused=f"the branch of point {far[0]} could not be followed")
        return trial

    def _keep(self, trial: Trial) -> None:
        if not self._turned:
            self.refused = ""
        self._turned = False
        self.near = self._last = trial
        if _missed(trial) < _missed(self.best) or (
            _missed(trial) == _missed(self.best) and trial.value < self.best.value
        ):
            self.best = trial
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
                value = _number("objective", self._objective(robot, here))
                if np.ndim(value):
                    raise InputError(
                        "Argument `objective` must return one number, but it returned an array of "
                        f"shape {np.shape(value)}."
                    )
                slack = jnp.zeros(0)
                if self._constraints is not None:
                    slack = jnp.ravel(_number("constraints", self._constraints(robot, here)))
                index = jnp.zeros((), int) if self._unstable else stability(robot, here).index
                return value, slack, here, index

            value, slack, here, index = jax.vmap(at)(points, near)
            return (value, slack), (value, slack, here, index)

        return jax.jacfwd(at_all, has_aux=True)(x)


def _missed(trial: Trial) -> float:
    """By how much constraints are not fulfilled; nothing within rounding of the search."""
    short = -float(np.min(trial.slack, initial=0.0))
    return short if short > SLACK else 0.0


def _unknowns(equilibria: Equilibrium) -> Array:
    """Those of stacked equilibria, `(points, n_y)`."""
    mu = equilibria.mu
    return jnp.concatenate([equilibria.q_a, equilibria.q_p, mu.reshape(len(mu), -1)], axis=1)


def _number(field: str, value: Any) -> Array:
    """What a function of the user has returned, as floating-point numbers."""
    try:
        array = jnp.asarray(value)
    except (TypeError, ValueError):
        array = jnp.zeros((), bool)
    if not jnp.issubdtype(array.dtype, jnp.floating):
        raise InputError(
            f"Argument `{field}` must return floating-point numbers, but it returned "
            f"{type(value).__name__} of type {array.dtype}."
        )
    return array
