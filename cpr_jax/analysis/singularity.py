"""Singular curves: Type 1 and Type 2 loci, traced by continuation of an extended system."""

import enum
from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..parallel import in_parallel
from ..programs import program
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..statics.correction import linearised
from ..statics.linear import inverse_with_sign, solve_many_with_sign
from ..statics.problem import Problem, forward_rows, imposed_coordinates
from ..statics.unknowns import unknown_scales

_CLOSE = 1e-9
_ITERATIONS = 8
_ITERATIONS_OF_STARTS = 25
_FIRST = 0.2
"""Longest first step along a curve, in dimensionless unknowns."""

_TURN = 0.1
"""Wanted angle between the tangents at both ends of a step, in radians."""

_MISS = 0.1
"""Largest correction of a prediction, in steps: what is farther away may be another branch."""

_ASIDE = 1e-4
"""Length of the differences of Jacobians, in dimensionless unknowns."""

_NUMBERS = 80
"""Unknowns of all points that are corrected in one call: most calls have few points, what fills
them up is calculated in vain, and takes the longer the more unknowns a robot has."""


class SingularityType(enum.Enum):
    """Which motion becomes free (Gosselin and Angeles)."""

    TYPE_1 = "type-1"
    """Platform held: `A_q = ∂R₀/∂(q_a, μ)` is singular; the branch folds there.

    Where other coordinates are imposed than all those of the platform, they are what is held.
    """
    TYPE_2 = "type-2"
    """Motors held: `A_p = ∂R₀/∂(q_p, μ)` is singular; the platform loses its stiffness."""


class SingularCurve(NamedTuple):
    """Points of one curve, in order.

    **Attributes:**

    - `y`: unknowns in SI units, shape `(points, n_y)`.
    - `closed`: whether it ends where it starts; the first point then is repeated at the end.
    """

    y: Float[np.ndarray, "points n_y"]
    closed: bool


class _Lane(NamedTuple):
    """A point of a curve: dimensionless y, unit tangent, borders of the singular matrix."""

    z: Float[Array | np.ndarray, "*lanes n_y"]
    tangent: Float[Array | np.ndarray, "*lanes n_y"]
    left: Float[Array | np.ndarray, "*lanes n_r"]
    right: Float[Array | np.ndarray, "*lanes n_r"]
    converged: Bool[Array | np.ndarray, "*lanes"]


def trace_curves(
    robot: Robot,
    kind: SingularityType,
    starts: Float[np.ndarray, "starts n_y"],
    along: Float[np.ndarray, " starts"],
    axes: tuple[int, int],
    *,
    box: Float[np.ndarray, "2 2"],
    spacing: float,
    imposed: tuple[int, ...] | None = None,
    belongs: Callable[[Float[np.ndarray, "k n_y"]], Bool[np.ndarray, " k"]] | None = None,
    max_points: int = 2000,
    steps: int = DEFAULT_STEPS,
) -> list[SingularCurve]:
    """Traces the curves `{R₀ = 0, det A = 0}` through given neighbourhoods.

    Each start is pulled onto a curve; from starts far enough apart the curves are followed by
    pseudo-arclength, all at once, until they meet each other's starts, close, or leave the box.
    Folds and cusps of the projection onto the axes are ordinary points of the curve.

    **Arguments:**

    - `starts`: unknowns near a curve, SI units.
    - `along`: for each start, which of the two axes (0 or 1) may change while it is pulled.
    - `axes`: the two entries of `(q_a, q_p)` that vary; other platform coordinates are held.
    - `box`: lower and upper corner; a curve ends at its first point outside.
    - `spacing`: wanted distance of the points in the axes' units.
    - `imposed`: places in `(q_a, q_p)` of what an inverse problem imposes, by default the platform
        coordinates.
    - `belongs`: tells of dimensionless unknowns whether they are on the sheet that is of
        interest; a curve ends where it leaves it.
    """
    units = np.asarray(unknown_scales(robot))
    if len(starts) == 0:
        return []
    places = imposed_coordinates(robot) if imposed is None else imposed
    tracer = _Tracer(robot, kind, axes, places, box, spacing, belongs, steps)
    lanes = tracer.seeds(np.asarray(starts) / units, np.asarray(along))
    curves = _joined(tracer.trace(lanes, max_points), 2.0 * _FIRST)
    return [SingularCurve(points * units, closed) for points, closed in curves]


def compile_tracing(
    robot: Robot, axes: tuple[int, int], imposed: tuple[int, ...], steps: int
) -> None:
    """Compiles what `trace_curves` runs, for robots and axes like these."""
    box = np.zeros((2, 2))
    tracer = _Tracer(robot, SingularityType.TYPE_1, axes, imposed, box, 1.0, None, steps)
    nothing = np.full((1, robot.n_y), np.nan)
    borders = np.zeros((1, tracer.columns.shape[1]))
    tracer.correct(_Lane(nothing, nothing, borders, borders, np.zeros(1, bool)), nothing)


class _Tracer:
    """Lockstep tracing of many pieces, which are then joined."""

    def __init__(self, robot, kind, axes, imposed, box, spacing, belongs, steps):
        self.robot, self.axes, self.steps = robot, np.array(axes), steps
        keep = np.ones(robot.n_y, bool)
        motors = list(range(robot.n_a))
        keep[motors if kind is SingularityType.TYPE_2 else list(imposed)] = False
        eye = np.eye(robot.n_y)
        held = [k for k in sorted(imposed) if k not in axes]
        self.columns, self.held = eye[:, keep], eye[held].reshape(-1, robot.n_y)
        self.units = np.asarray(unknown_scales(robot))[self.axes]
        self.box, self.spacing, self.belongs = np.asarray(box), spacing, belongs
        self.width = max(1, _NUMBERS // robot.n_y)

    def correct(self, lanes: _Lane, predicted) -> _Lane:
        """Pulls predictions onto the curve, perpendicular to the tangents; pads to one size."""
        count = len(predicted)
        width = self.width
        size = width * -(-count // width)
        pick = np.minimum(np.arange(size), count - 1)

        def some(k: int) -> _Lane:
            part = pick[k : k + width]
            chosen = _Lane(*(np.asarray(leaf)[part] for leaf in lanes))
            ahead = np.asarray(predicted)[part]
            return _correct(self.robot, self.columns, self.held, chosen, ahead, self.steps)

        parts = in_parallel(some, range(0, size, width))
        return _Lane(*(np.concatenate(leaves)[:count] for leaves in zip(*parts, strict=True)))

    def seeds(self, z, along) -> _Lane:
        """Starts pulled onto their curves while one of the axes is held."""
        count, n_y = z.shape
        fixed = self.axes[1 - along]
        tangent = np.eye(n_y)[fixed]
        borders = np.zeros((count, self.columns.shape[1]))
        blank = _Lane(z, tangent, borders, borders, np.ones(count, bool))
        found = self.correct(blank, z)
        usable = found.converged & self.inside(found.z) & self.wanted(found.z)
        return _Lane(*(leaf[usable] for leaf in found))

    def inside(self, z):
        place = z[..., self.axes] * self.units
        slack = 1e-9
        return np.all((place >= self.box[0] - slack) & (place <= self.box[1] + slack), axis=-1)

    def wanted(self, z):
        return np.ones(len(z), bool) if self.belongs is None else self.belongs(z)

    def longest(self, tangent):
        """Steps that move as far as points shall be apart."""
        speed = np.linalg.norm(tangent[..., self.axes] * self.units, axis=-1)
        return self.spacing / np.maximum(speed, 1e-12)

    def first(self, tangent):
        """Steps where it is not known yet how much the curve turns."""
        return np.minimum(_FIRST, self.longest(tangent))

    def spread(self, lanes: _Lane) -> _Lane:
        """Starts that are far enough apart to share the work."""
        chosen: list[int] = []
        reach = 6.0 * self.first(lanes.tangent)
        for k, z in enumerate(lanes.z):
            away = np.linalg.norm(z - lanes.z[chosen], axis=1)
            if np.all(away > np.maximum(reach[k], reach[chosen])):
                chosen.append(k)
        return _Lane(*(leaf[chosen] for leaf in lanes))

    def trace(self, seeds: _Lane, max_points: int) -> list[tuple[np.ndarray, bool]]:
        if len(seeds.z) == 0:
            return []
        seeds = self.spread(seeds)
        forward, links = self.march(seeds, seeds, 1.0, max_points)
        reached = set(links.values())
        first = [k for k in range(len(seeds.z)) if k not in reached]
        backward: dict[int, list] = {k: [] for k in first}
        if first:
            lanes = _Lane(*(leaf[first] for leaf in seeds))
            pieces, _ = self.march(lanes, lanes, -1.0, max_points)
            backward = {k: pieces[i][::-1] for i, k in enumerate(first)}
        curves = []
        left = set(range(len(seeds.z)))
        for start in [*first, *range(len(seeds.z))]:
            if start not in left:
                continue
            points = [*backward.get(start, []), seeds.z[start]]
            here = start
            while True:
                left.discard(here)
                points += forward[here]
                if here not in links or links[here] not in left:
                    break
                here = links[here]
                points.append(seeds.z[here])
            closed = links.get(here) == start
            if closed:
                points.append(seeds.z[start])
            if len(points) > 1:
                curves.append((np.array(points), closed))
        return curves

    def march(self, lanes: _Lane, seeds: _Lane, direction: float, max_points: int):
        """Follows every lane until it meets a seed, leaves the box or fails."""
        count = len(lanes.z)
        pieces: list[list[np.ndarray]] = [[] for _ in range(count)]
        links: dict[int, int] = {}
        active = np.arange(count)
        now = lanes._replace(tangent=direction * lanes.tangent)
        stride = self.first(now.tangent)
        bend = np.zeros_like(now.z)
        for _ in range(max_points):
            if len(active) == 0:
                break
            predicted = now.z + stride[:, None] * (now.tangent + 0.5 * stride[:, None] * bend)
            new = self.correct(now, predicted)
            turn = np.arccos(np.clip(np.sum(new.tangent * now.tangent, axis=1), -1.0, 1.0))
            missed = np.linalg.norm(new.z - predicted, axis=1) > _MISS * stride
            wanted = self.wanted(new.z)
            # What ends a curve is approached in short steps, or its last one would be missing.
            late = ~wanted & (stride > self.first(now.tangent))
            good = new.converged & (turn < 3.0 * _TURN) & ~missed & ~late
            tiny = ~good & (stride < 1e-6)
            going = np.zeros(len(active), bool)
            for i, lane in enumerate(active):
                if not good[i]:
                    going[i] = not tiny[i]
                    continue
                step = new.z[i] - now.z[i]
                length = np.linalg.norm(step)
                offsets = seeds.z - now.z[i]
                ahead = offsets @ step / length
                aside = np.linalg.norm(offsets - ahead[:, None] * step / length, axis=1)
                alike = direction * seeds.tangent @ now.tangent[i] > 0.0
                met = (ahead > 1e-9) & (ahead <= length * 1.001) & (aside < 0.2 * length) & alike
                if np.any(met):
                    links[int(lane)] = int(np.argmin(np.where(met, ahead, np.inf)))
                    continue
                leaves = not self.inside(new.z[i])
                changes = not wanted[i]
                if not changes:
                    pieces[lane].append(np.asarray(new.z[i]))
                going[i] = not (leaves or changes)
            turned = (new.tangent - now.tangent) / stride[:, None]
            bend = np.where(good[:, None], turned, bend)[going]
            grown = stride * np.clip(_TURN / np.maximum(turn, 1e-12), 0.5, 2.0)
            grown = np.minimum(grown, self.longest(new.tangent))
            stride = np.where(good, grown, 0.4 * stride)[going]
            now = _Lane(
                *(
                    np.where(good.reshape(-1, *[1] * (a.ndim - 1)), b, a)[going]
                    for a, b in zip(now, new, strict=True)
                )
            )
            active = active[going]
        return pieces, links


def _joined(curves: list[tuple[np.ndarray, bool]], reach: float) -> list[tuple[np.ndarray, bool]]:
    """Pieces whose ends meet, as one: where a curve was pulled at from both sides."""
    closed = [curve for curve in curves if curve[1]]
    open_ = [points for points, is_closed in curves if not is_closed]
    joined = True
    while joined:
        joined = False
        for i, first in enumerate(open_):
            for j, second in enumerate(open_):
                if i == j:
                    continue
                ends = (first, first[::-1]), (second, second[::-1])
                ways = [(np.linalg.norm(a[-1] - b[0]), a, b) for a in ends[0] for b in ends[1]]
                gap, a, b = min(ways, key=lambda way: way[0])
                if gap < reach:
                    merged = np.concatenate([a, b])
                    open_ = [c for k, c in enumerate(open_) if k not in (i, j)] + [merged]
                    joined = True
                    break
            if joined:
                break
    return closed + [(points, False) for points in open_]


@program
def _correct(robot, columns, held, lanes: _Lane, predicted, steps: int) -> _Lane:
    """Newton's method on `R₀ = 0`, the held coordinates, `g = 0` and `t·(z - z_predicted) = 0`.

    `g` is the last unknown of the bordered system `[A b; cᵀ 0] (v, g) = (0, 1)`, which vanishes
    where A is singular and has the sign of `det A`; b and c follow the null vectors.
    """
    n_r = robot.n_y - robot.n_a
    problem = Problem(robot, forward_rows(robot), jnp.zeros(robot.n_a + robot.n_p))

    def linearise(z):
        R, by_z = linearised(problem, z, steps)
        return by_z[:n_r], R[:n_r]

    def one(lane: _Lane, predicted):
        def newton(state):
            z, left, right, _, count, _ = state
            # What det A does along z needs second derivatives in one direction: differences of
            # Jacobians along the null vector known so far cost no second tangents of the rods.
            aside = _ASIDE * (columns @ right)
            around = jnp.stack([z, z + aside, z - aside])
            (J, ahead, behind), (R_0, *_) = jax.vmap(linearise)(around)
            A = J @ columns
            blank = jnp.sum(jnp.abs(left)) == 0.0
            inverted, _ = inverse_with_sign(A)
            # Inverse iteration finds the null vectors where none are known yet.
            guess = jnp.ones(A.shape[0])
            v = _unit(inverted @ _unit(inverted.T @ _unit(inverted @ guess)))
            u = _unit(inverted.T @ _unit(inverted @ _unit(inverted.T @ guess)))
            left, right = jnp.where(blank, u, left), jnp.where(blank, v, right)
            bordered = jnp.block([[A, left[:, None]], [right[None], jnp.zeros((1, 1))]])
            last = jnp.zeros(A.shape[0] + 1).at[-1].set(1.0)
            solved, sign = inverse_with_sign(bordered)
            v, g = (solved @ last)[:-1], solved[-1, -1]
            w = solved[-1, :-1]
            # With this orientation g has the sign of det A, and tangents one along a curve.
            flip = jnp.where(sign < 0.0, -1.0, 1.0)
            slope = -flip * (w @ (ahead - behind)) / (2.0 * _ASIDE)
            system = jnp.concatenate([J, held, slope[None], lane.tangent[None]])
            gap = jnp.concatenate(
                [
                    R_0,
                    held @ (z - predicted),
                    flip * g[None],
                    (lane.tangent @ (z - predicted))[None],
                ]
            )
            rights = jnp.column_stack([-gap, jnp.zeros(gap.size).at[-1].set(1.0)])
            moved, orientation = solve_many_with_sign(system, rights)
            norm = jnp.max(jnp.abs(gap))
            tangent = _unit(moved[:, 1])
            step = moved[:, 0]
            cut = jnp.minimum(1.0, 0.3 / jnp.max(jnp.abs(step)))
            # Without null vectors there is no slope yet: the first turn is for them.
            z = jnp.where(blank, z, z + cut * step)
            norm = jnp.where(blank, jnp.inf, norm)
            tangent = jnp.where(blank, lane.tangent, tangent)
            return z, _unit(w), _unit(v), norm, count + 1, (tangent, orientation)

        fresh = jnp.sum(jnp.abs(lane.left)) == 0.0
        most = jnp.where(fresh, _ITERATIONS_OF_STARTS, _ITERATIONS)

        def unfinished(state):
            return (state[3] > _CLOSE) & (state[4] < most)

        one = jnp.ones((), predicted.dtype)
        facts = (lane.tangent, one)
        first = (predicted, lane.left, lane.right, jnp.inf * one, jnp.array(0), facts)
        z, left, right, norm, _, (tangent, orientation) = jax.lax.while_loop(
            unfinished, newton, first
        )
        # A fresh tangent is oriented by the determinant, later ones by their predecessor.
        tangent = tangent * jnp.where(fresh & (orientation < 0.0), -1.0, 1.0)
        converged = (norm <= _CLOSE) & jnp.all(jnp.isfinite(z))
        return _Lane(z, tangent, left, right, converged)

    return jax.vmap(one)(lanes, predicted)


def _unit(vector):
    return vector / jnp.sqrt(jnp.sum(vector**2))
