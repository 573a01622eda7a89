"""Many ways along a branch at once, at once where that works and step by step where not."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Float

from ..parallel import in_parallel, on_devices
from ..robots.robot import Robot
from ..rods.solver import Steps, as_scheme
from ..statics.advance import Nearby, advance, advance_many
from ..statics.continuation import DEVIATION
from ..statics.status import Status

LANES = 128
"""Ways in one call of a compiled program."""

_FIRST = 0.3
_SHORTEST = 5e-3
_STILL = 0.1
"""A way ends where steps of less than `_SHORTEST` of it are needed and the unknowns, dimensionless,
move by less than this in one: along a steep branch short steps are no sign of a fold."""
_ROUNDS = 60


class Follower(NamedTuple):
    """Follows a branch of a robot to other imposed coordinates.

    **Attributes:**

    - `imposed`: which of `(q_a, q_p)` are, as rows.
    - `axes`: the entries of `(q_a, q_p)` that vary.
    - `steps`: of the integration.
    - `many`: whether there is so much to follow that a longer compilation pays.
    """

    robot: Robot
    imposed: Float[Array, "n_a n_q"]
    axes: tuple[int, int]
    steps: Steps
    many: bool = False

    def compile(self) -> None:
        """Compiles what it needs: it runs once on NaN, on which every iteration stops at once."""
        robot = self.robot
        rows = (1, robot.n_y), (1, robot.n_a + robot.n_p)
        self.advance(*(np.full(shape, np.nan) for shape in rows))

    def advance(
        self, guess: Float[np.ndarray, "ways n_y"], goal: Float[np.ndarray, "ways n_q"]
    ) -> Nearby:
        """`statics.advance` for any number of ways, in batches of one size, in numpy."""
        program = advance_many if self.many else advance
        places = on_devices((self.robot, self.imposed))
        # As an array: Python numbers would be compiled in.
        scheme = np.asarray(as_scheme(self.steps))

        def batch(k: int) -> Nearby:
            lanes = [_filled(part[k : k + LANES]) for part in (guess, goal)]
            here, rows = places[k // LANES % len(places)]
            found = program(here, rows, self.axes, lanes[0], lanes[1], scheme)
            return Nearby(*(np.asarray(leaf) for leaf in found))

        parts = in_parallel(batch, range(0, len(guess), LANES))
        return Nearby(*(np.concatenate(leaf)[: len(guess)] for leaf in zip(*parts, strict=True)))

    def creep(
        self,
        start: Float[np.ndarray, "ways n_y"],
        begin: Float[np.ndarray, "ways n_q"],
        goal: Float[np.ndarray, "ways n_q"],
    ) -> Nearby:
        """Follows the branch from `begin` to `goal` in steps as small as they need be.

        A step counts if it converges near its tangent prediction and keeps the sign of the
        Jacobian's determinant. A way ends where steps shorter than 0.5 % of it would be needed: at
        a fold, from which corrections fly away. Where they stay near and still do not converge,
        rounding is in the way, as in rods that are pulled taut.

        **Returns:** the last point on the branch of each way; its status is `SOLVED` at the goal,
        `LOST` at a fold, `NOT_CONVERGED` where even the start is no equilibrium, where steps ran
        out, or where rounding may be all that is in the way.
        """
        now = self.advance(start, begin)
        now = Nearby(*(leaf.copy() for leaf in map(np.asarray, now)))
        status = np.full(len(start), int(Status.NOT_CONVERGED))
        progress, stride = np.zeros(len(start)), np.full(len(start), _FIRST)
        going = np.flatnonzero(now.status == Status.SOLVED)
        for _ in range(_ROUNDS):
            if len(going) == 0:
                break
            # Land on the goal rather than leave a sliver.
            end = progress[going] + stride[going]
            end = np.where(end > 1.0 - _SHORTEST, 1.0, end)
            taken = (end - progress[going])[:, None]
            way = (goal - begin)[going]
            moved = np.einsum("lnk,lk->ln", now.slope[going], (taken * way)[:, list(self.axes)])
            target = begin[going] + end[:, None] * way
            new = self.advance(now.y[going] + moved, target)
            good = (new.status == Status.SOLVED) & (new.sign == now.sign[going])
            good &= new.deviation < DEVIATION
            for leaf, found in zip(now, new, strict=True):
                leaf[going[good]] = np.asarray(found)[good]
            progress[going[good]] = end[good]
            growth = 0.7 * np.sqrt(DEVIATION / np.maximum(new.deviation, 1e-12))
            stride[going] = taken[:, 0] * np.where(good, np.clip(growth, 0.3, 3.0), 0.3)
            status[going[progress[going] >= 1.0]] = Status.SOLVED
            near = (new.status != Status.SOLVED) & (new.deviation < DEVIATION)
            ended = np.where(near, int(Status.NOT_CONVERGED), int(Status.LOST))
            ahead = stride[going] * np.max(np.abs(moved / taken), axis=1)
            short = (stride[going] < _SHORTEST) & (ahead < _STILL) & (progress[going] < 1.0)
            status[going[short]] = ended[short]
            going = going[(progress[going] < 1.0) & ~short]
        return now._replace(status=status)


def _filled(rows: np.ndarray) -> np.ndarray:
    """Rows filled up to a batch, so that one program serves any number, with NaN: a lane that
    begins there has ended."""
    spare = np.full((LANES - len(rows), rows.shape[1]), np.nan)
    return np.concatenate([rows, spare])
