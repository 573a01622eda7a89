"""All equilibria of a robot at one point or at one set of motor positions."""

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..analysis.pieces import rods_in_pieces
from ..analysis.stability import count_unstable
from ..checks import check_finite, check_kind, check_shape
from ..errors import InputError, check_integer
from ..geometry import Numbers, floats
from ..parallel import in_parallel, padded
from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.energy import bows_of, integrated, total_energy
from ..statics.equilibrium import Equilibrium, polish
from ..statics.periods import motor_periods
from ..statics.problem import (
    Problem,
    forward_rows,
    imposed_coordinates,
    imposed_rows,
    inverse_rows,
)
from ..statics.reach import used_up
from ..statics.roots import find_root
from ..statics.solve import solve_forward, solve_inverse
from ..statics.status import Status
from ..statics.unknowns import unknown_scales
from .starts import even_starts, recombined

_LANES = 512

_ROUNDS = 3
"""How often new starts are made from the legs of what was found."""

_APART = 1e-6
"""Distance from which two solutions are different, in dimensionless unknowns."""


class AllEquilibria(NamedTuple):
    """Every equilibrium that was found, the least energy first (SI units).

    **Attributes:**

    - `y`: unknowns `(q_a, q_p, μ)`, motors that turn within half a turn (of their legs, behind
        gears) unless `q_a` was given, `(found, n_y)`.
    - `energy`: total potential energy, J.
    - `unstable`: number of unstable directions with the motors held; 0 is stable.
    - `bows`: which way and how far each rod bows, `(found, n)`: they name the branch.
    - `hits`: how many starts ended at each.
    - `unseen`: Chao's lower bound on how many more there are, from those that were hit once and
        twice.
    """

    y: Float[np.ndarray, "found n_y"]
    energy: Float[np.ndarray, " found"]
    unstable: np.ndarray
    bows: Float[np.ndarray, "found n"]
    hits: np.ndarray
    unseen: float

    def equilibrium(self, robot: Robot, k: int, steps: int = DEFAULT_STEPS) -> Equilibrium:
        """The k-th as an `Equilibrium`, to start a map, a sensitivity or a study from."""
        return equilibrium_at(robot, self.y[k], "search", steps)


def equilibrium_at(
    robot: Robot, y: Float[np.ndarray, " n_y"], branch: str, steps: int = DEFAULT_STEPS
) -> Equilibrium:
    """The `Equilibrium` with unknowns that are known, SI units."""
    imposed = inverse_rows(robot) if robot.n_a == robot.n_p else forward_rows(robot)
    here = jnp.asarray(y)[: robot.n_a + robot.n_p]
    solved, any_error = np.asarray(int(Status.SOLVED)), np.asarray(np.inf)
    scheme = np.asarray(steps)
    return polish(robot.unnamed, imposed, here, jnp.asarray(y), solved, any_error, branch, scheme)


def find_equilibria(
    robot: Robot,
    point: Numbers | None = None,
    q_a: Numbers | None = None,
    *,
    imposed: Sequence[str] | None = None,
    starts: int = 4096,
    seed: int = 0,
    steps: int = DEFAULT_STEPS,
) -> AllEquilibria:
    """All equilibria with the platform at a point, or with the motors at `q_a`.

    Newton's method from many starts that cover motor positions, platform poses and base wrenches
    evenly (a scrambled Sobol sequence), solutions told apart by their unknowns. One more start is
    the equilibrium on the branch of the robot's home, where it has one. It proves nothing about
    what it did not find; `unseen` estimates how much that is.

    **Arguments:**

    - `point`, `q_a`: one of them, SI units.
    - `imposed`: names of the coordinates that `point` holds, as in `solve_inverse`.
    - `starts`, `seed`: how many starts, and the seed of their scrambling.
    """
    check_kind("robot", robot, Robot, "a Robot")
    if (point is None) == (q_a is None):
        raise InputError("Arguments `point` and `q_a` must be given one and not the other.")
    check_integer("starts", starts)
    check_integer("seed", seed, least=0)
    check_integer("steps", steps)
    n_a = robot.n_a
    if point is not None:
        places, name, given = imposed_coordinates(robot, imposed), "point", point
    else:
        assert q_a is not None
        places, name, given = tuple(range(n_a)), "q_a", q_a
    check_shape(name, given, (n_a,))
    check_finite(name, given)
    values = np.asarray(given, float)
    target = np.zeros(n_a + robot.n_p)
    target[list(places)] = values
    problem = Problem(robot.unnamed, imposed_rows(robot, places), floats(target))

    units = np.asarray(unknown_scales(robot))
    coarse = max(2, (steps + 1) // 2)
    first = even_starts(robot, target, places, units, starts, seed)
    if robot.home is not None:
        solve = solve_forward if point is None else partial(solve_inverse, imposed=imposed)
        at_home = solve(robot, values, throw=False)
        if int(at_home.status) == Status.SOLVED:
            first = np.concatenate([np.asarray(at_home.y)[None], first])
    y, solved = _newton(problem, first, coarse)
    found = _principal(robot, y[solved], places)
    kept, hits = _distinct(found, units, np.ones(len(found), int))
    distinct = found[kept]
    for turn in range(_ROUNDS if len(distinct) else 0):
        y, solved = _newton(problem, recombined(robot, distinct, units, (seed, turn)), coarse)
        more = _principal(robot, np.concatenate([distinct, y[solved]]), places)
        kept, hits = _distinct(more, units, np.append(hits, np.ones(np.sum(solved), int)))
        distinct = more[kept]
    if len(distinct) == 0:
        return AllEquilibria(distinct, np.zeros(0), hits, np.zeros((0, robot.n)), hits, 0.0)
    looks = [_look(problem, floats(batch), steps) for batch in _batches(distinct)]
    y, good, energy, index, bows = (
        np.concatenate(part)[: len(distinct)] for part in zip(*looks, strict=True)
    )
    # Some are the same only now that they are solved to the end.
    y, hits = _principal(robot, y[good], places), hits[good]
    kept, hits = _distinct(y, units, hits)
    y, energy, index, bows = (part[kept] for part in (y, energy[good], index[good], bows[good]))
    order = np.argsort(energy, kind="stable")
    once, twice = np.sum(hits == 1), np.sum(hits == 2)
    unseen = once * (once - 1) / (2.0 * (twice + 1.0))
    y, energy, index, bows, hits = (part[order] for part in (y, energy, index, bows, hits))
    return AllEquilibria(y, energy, index, bows, hits, float(unseen))


def _batches(rows: np.ndarray) -> list[np.ndarray]:
    """Batches of one size."""
    return [padded(rows[k : k + _LANES], _LANES) for k in range(0, len(rows), _LANES)]


def _newton(problem: Problem, starts, steps: int):
    """Unknowns at the ends of Newton's method, and whether they are roots."""

    def roots(batch: np.ndarray):
        return [np.asarray(part) for part in _roots(problem, floats(batch), steps)]

    parts = in_parallel(roots, _batches(starts))
    return (np.concatenate(part)[: len(starts)] for part in zip(*parts, strict=True))


@program
def _roots(problem: Problem, starts, steps: int):
    def one(start):
        root = find_root(problem, start, steps=steps, max_iterations=40, verify=False)
        return root.y, root.status == Status.SOLVED

    return jax.vmap(one)(starts)


@program
def _look(problem: Problem, y, steps: int):
    robot = problem.robot

    def one(y):
        here = eqx.tree_at(
            lambda p: p.target,
            problem,
            jnp.where(problem.imposed.sum(0) > 0, problem.target, y[: problem.target.size]),
        )
        root = find_root(here, y, steps=steps)
        good = root.status == Status.SOLVED
        good &= jnp.max(jnp.abs(root.y - y) / unknown_scales(robot)) < 1e-3
        if robot.legs.feed is not None:
            good &= ~used_up(robot, root.y[: robot.n_a])
        rods = integrated(robot, root.y, steps)
        energy, bowed = total_energy(robot, root.y, rods), bows_of(robot, root.y, rods)
        counted = count_unstable(robot, root.y, rods_in_pieces(robot, root.y, steps))
        return root.y, good, energy, counted.index, bowed

    return jax.vmap(one)(y)


def _principal(robot: Robot, y: np.ndarray, places: Sequence[int]) -> np.ndarray:
    """The same configurations with motors within half a period, and a body within half a turn.

    So are passive joints at the base. What is imposed stays as it is.
    """
    periods = motor_periods(robot)
    free = [j for j in range(robot.n_a) if j not in places and np.isfinite(periods[j])]
    y = y.copy()
    y[:, free] = _within_half(y[:, free], periods[free])
    if robot.legs.base_joint is not None:
        _turn_back(robot, y)
    turns = range(robot.n_a + robot.geometry.d, robot.n_a + robot.n_p)
    if len(turns) and not any(k in places for k in turns):
        y[:, turns] = _within_half_a_turn(y[:, turns])
    return y


def _turn_back(robot: Robot, y: np.ndarray) -> None:
    """Leaves out whole turns of passive joints at the base, in place."""
    d, size = robot.geometry.d, robot.geometry.freedoms
    for leg, free in enumerate(np.asarray(robot.legs.base_joint.free)):  # type: ignore[union-attr]
        begin = robot.n_a + robot.n_p + leg * size + d
        turns = begin + np.flatnonzero(free[d:])
        # Up to two turn one after the other, three at once.
        if len(turns) < 3:
            y[:, turns] = _within_half(y[:, turns], np.full(len(turns), 2.0 * np.pi))
        else:
            y[:, turns] = _within_half_a_turn(y[:, turns])


def _within_half(values: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Up to half a period; what is as much as that has one sign, however it is rounded."""
    return values - periods * np.round(values / periods - _APART)


def _within_half_a_turn(vectors: np.ndarray) -> np.ndarray:
    """Rotation vectors `(k, r)` of the same orientations: whole turns about an axis change none.

    Half a turn about an axis is one about its opposite: of the two, that with a first component
    that is positive, however they are rounded.
    """
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    whole = 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
    vectors = vectors * (1.0 - whole / np.where(angle > 0.0, angle, 1.0))
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    first = np.argmax(np.abs(vectors) > _APART, axis=1)[:, None]
    other = (angle > np.pi - _APART) & (np.take_along_axis(vectors, first, axis=1) < 0.0)
    return np.where(other, vectors * (1.0 - 2.0 * np.pi / np.where(other, angle, 1.0)), vectors)


def _distinct(y: np.ndarray, units: np.ndarray, hits: np.ndarray) -> tuple[list, np.ndarray]:
    """Places of the first of all solutions that agree, and their hits together."""
    kept: list[int] = []
    counts: list[int] = []
    scaled = y / units
    for place, row in enumerate(scaled):
        gaps = np.max(np.abs(scaled[kept] - row), axis=1)
        if len(kept) and np.min(gaps) < _APART:
            counts[int(np.argmin(gaps))] += int(hits[place])
        else:
            kept.append(place)
            counts.append(int(hits[place]))
    return kept, np.array(counts, int)
