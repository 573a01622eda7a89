"""Critical values: how far a parameter may go until the robot loses its stability."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..analysis.parameters import Selection, select
from ..analysis.pieces import rods_in_pieces
from ..analysis.stability import count_unstable
from ..checks import check_finite, check_kind, check_positive, check_shape
from ..errors import InputError, check_integer
from ..geometry import floats
from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.equilibrium import Equilibrium, check_fits, check_solved
from ..statics.problem import Problem, forward_rows
from ..statics.reach import used_up
from ..statics.roots import find_root
from ..statics.status import SolveError, Status
from ..statics.unknowns import unknown_scales

_FARTHEST = 0.3
"""Largest change of an unknown in one step, dimensionless; larger ones are halved."""

_BACK = 1e-4
"""How far from where it came from, in dimensionless unknowns, a step back may end."""

_CLOSE = 1e-8
"""Largest residual of what is followed: rods pulled taut leave more rounding than a solve accepts,
and the number of unstable directions bears it."""

_NEAR, _FAR, _STEEPER = 1e-5, 1e-3, 3.0
"""Beside a fold the unknowns change like a square root. Over the nearer of these two shares of the
range they are ten times as steep then as over the farther one; a third of that is taken for it."""


_MOST = 20_000
"""Values beside the wanted points that are looked at, before a branch counts as lost."""

_BEHIND, _STRAIGHT = 1e-8, 1e-6
"""Half the distance, in shares of the range, at which is looked once more behind a value where the
stability changes or where nothing can be solved; and how far the unknowns may move on the way:
where a branch forks they move like a square root."""


class CriticalValue(NamedTuple):
    """Where an equilibrium changes its number of unstable directions.

    **Attributes:**

    - `value`: of the parameter, SI units; NaN where nothing changes before `stop`.
    - `before`, `after`: numbers of unstable directions before it and at the next point looked
        at; `after` is -1 where the branch folds back, so that the robot snaps to another one.
    - `y`: unknowns just before it, SI units.
    """

    value: float
    before: int
    after: int
    y: Float[np.ndarray, " n_y"]


def critical_value(
    robot: Robot,
    equilibrium: Equilibrium,
    parameter: str,
    stop: float,
    *,
    points: int = 40,
    rtol: float = 1e-9,
    steps: int = DEFAULT_STEPS,
) -> CriticalValue:
    """Buckling: the first value of a parameter at which the stability changes, motors held.

    The equilibrium is followed while the parameter goes from where it is to `stop`; between two
    points with different stability indices the value is bisected. The index sees what the sign
    of a determinant does not: two directions that become unstable together, as they do in a
    symmetric robot.

    **Arguments:**

    - `parameter`: a label, see `select`, such as `f_P_z` or `l1`.
    - `stop`: its last value, SI units.
    - `points`: how many values are looked at before bisecting.
    - `rtol`: accuracy of the value, relative to the range.

    **Raises:** `InputError` for a bad argument; `SolveError` where the equations can no longer be
    solved, though the branch does not fold back there, and where nothing is left of a rod.
    """
    check_kind("robot", robot, Robot, "a Robot")
    check_fits("equilibrium", equilibrium, robot)
    check_shape("stop", stop, ())
    check_finite("stop", stop)
    check_integer("points", points)
    check_integer("steps", steps)
    check_positive("rtol", rtol)
    check_solved("equilibrium", equilibrium)
    selection = select(robot, (parameter,), "parameter")
    start = float(selection.get(robot)[0])
    stop = float(stop)
    if stop == start:
        raise InputError(
            f"Argument `stop` must be a number other than the present value {start}, but it is "
            f"{stop!r}."
        )
    if selection.entries[0].positive and stop < 0.0:
        raise InputError(
            f"Argument `stop` must not be negative, as {parameter} cannot be, but it is {stop!r}."
        )
    held = floats(np.append(equilibrium.q_a, np.zeros(robot.n_p)))
    units = np.asarray(unknown_scales(robot))

    ends = []

    def look(value: float, y):
        out = _look(robot, selection, held, floats([value]), floats(y), steps)
        y, good, gone, index = (np.asarray(part) for part in out)
        ends.append(bool(gone))
        return (y, int(index)) if good and not gone else None

    def look_ahead(value: float):
        """Where the branch leads: what does not lead back lies on another one, behind a fold."""
        found = look(value, y)
        if found is None:
            return None
        back = look(low, found[0])
        ends[-1] = False
        if back is None or np.max(np.abs(back[0] - y) / units) > _BACK:
            return None
        return found

    found = look(start, equilibrium.y)
    if found is None:
        raise InputError("Argument `equilibrium` must be an equilibrium of `robot`.")
    y, before = found
    span = stop - start
    least, aside = rtol * abs(span), np.sign(span) * 2.0 * max(rtol, _BEHIND) * abs(span)

    def look_behind(value: float):
        """Beyond a single value at which nothing is known, if the branch runs straight there."""
        found = look(value + aside, y)
        if found is None or np.max(np.abs(found[0] - y) / units) > _STRAIGHT:
            return None
        return found

    low, step, way, looks = start, span / points, [(start, y)], 0
    while (stop - low) * np.sign(span) > least:
        looks += 1
        high = low + step if (stop - low - step) * np.sign(span) > 0.0 else stop
        found = look_ahead(high)
        if found is None:
            step *= 0.5
            if abs(step) >= least and looks <= points + _MOST:
                continue
            if ends[-1]:
                raise SolveError(
                    Status.OUT_OF_REACH,
                    f"The equilibrium of {robot.name} ends at {parameter} = {low:.6g}, where "
                    "nothing is left of a rod that its motor has drawn in.",
                )
            if abs(step) < least and _folds_back(way, units, span):
                return CriticalValue(low, before, -1, y)
            # Exactly at a critical value the equations may be singular.
            found = look_behind(low) if looks <= points + _MOST else None
            if found is None:
                raise SolveError(
                    Status.NOT_CONVERGED,
                    f"The equilibrium of {robot.name} could not be followed beyond {parameter} = "
                    f"{low:.6g}, where its branch does not fold back: its rods may be pulled taut "
                    "there, or take more integration steps, see `steps`.",
                )
            high, step = low + aside, span / points
        if found[1] == before:
            low, y = high, found[0]
            way.append((low, y))
            continue
        after = found[1]
        while abs(high - low) > least:
            middle = 0.5 * (low + high)
            if middle in (low, high):
                break
            found = look(middle, y)
            if found is not None and found[1] == before:
                low, y = middle, found[0]
            else:
                high = middle
        behind = look_behind(high)
        if behind is None or behind[1] != before:
            return CriticalValue(0.5 * (low + high), before, after, y)
        # Where a rod alone is singular its index is not known, at that value only.
        low, y = high + aside, behind[0]
        way.append((low, y))
    return CriticalValue(float("nan"), before, before, y)


def _folds_back(way: list[tuple[float, np.ndarray]], units: np.ndarray, span: float) -> bool:
    """Whether a branch that was followed to the end of its way folds back there."""
    end, last = way[-1]
    slopes = []
    for share in (_NEAR, _FAR):
        behind = [(abs((end - v) / span), y) for v, y in way if abs(end - v) >= share * abs(span)]
        if not behind:
            return True
        distance, y = behind[-1]
        slopes.append(np.max(np.abs(last - y) / units) / distance)
    return bool(slopes[0] > _STEEPER * slopes[1])


@program
def _look(robot: Robot, selection: Selection, held, value, y, steps: int):
    varied = selection.set(robot, value)
    root = find_root(Problem(varied, forward_rows(varied), held), y, steps=steps)
    moved = jnp.max(jnp.abs(root.y - y) / unknown_scales(robot))
    good = (root.residual < _CLOSE) & (moved < _FARTHEST)
    gone = used_up(varied, root.y[: robot.n_a])
    counted = count_unstable(varied, root.y, rods_in_pieces(varied, root.y, steps))
    return root.y, good, gone & good, counted.index
