"""Singular curves followed from many starts at once."""

import numpy as np

from ..parallel import in_parallel
from ..statics.unknowns import unknown_scales
from .singular_points import Lane, correct_points

_FIRST = 0.2
"""Longest first step along a curve, in dimensionless unknowns."""

_TURN = 0.1
"""Wanted angle between the tangents at both ends of a step, in radians."""

_MISS = 0.1
"""Largest correction of a prediction, in steps: what is farther away may be another branch."""

_NUMBERS = 80
"""Unknowns of all points that are corrected in one call: most calls have few points, what fills
them up is calculated in vain, and takes the longer the more unknowns a robot has."""


class Tracer:
    """Lockstep tracing of many pieces, which are then joined.

    **Arguments:** as `trace_curves`, and

    - `fixed`: the unknowns whose columns the singular matrix lacks.
    """

    def __init__(self, robot, fixed, axes, imposed, box, spacing, belongs, steps):
        self.robot, self.axes, self.steps = robot, np.array(axes), steps
        keep = np.ones(robot.n_y, bool)
        keep[list(fixed)] = False
        eye = np.eye(robot.n_y)
        held = [k for k in sorted(imposed) if k not in axes]
        self.columns, self.held = eye[:, keep], eye[held].reshape(-1, robot.n_y)
        self.units = np.asarray(unknown_scales(robot))[self.axes]
        self.box, self.spacing, self.belongs = np.asarray(box), spacing, belongs
        self.width = max(1, _NUMBERS // robot.n_y)

    def correct(self, lanes: Lane, predicted) -> Lane:
        """Pulls predictions onto the curve, perpendicular to the tangents; pads to one size."""
        count = len(predicted)
        width = self.width
        size = width * -(-count // width)
        pick = np.minimum(np.arange(size), count - 1)

        def some(k: int) -> Lane:
            part = pick[k : k + width]
            chosen = Lane(*(np.asarray(leaf)[part] for leaf in lanes))
            ahead = np.asarray(predicted)[part]
            return correct_points(self.robot, self.columns, self.held, chosen, ahead, self.steps)

        parts = in_parallel(some, range(0, size, width))
        return Lane(*(np.concatenate(leaves)[:count] for leaves in zip(*parts, strict=True)))

    def seeds(self, z, along) -> Lane:
        """Starts pulled onto their curves while one of the axes is held."""
        count, n_y = z.shape
        fixed = self.axes[1 - along]
        tangent = np.eye(n_y)[fixed]
        borders = np.zeros((count, self.columns.shape[1]))
        blank = Lane(z, tangent, borders, borders, np.ones(count, bool))
        found = self.correct(blank, z)
        usable = found.converged & self.inside(found.z) & self.wanted(found.z)
        return Lane(*(leaf[usable] for leaf in found))

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

    def spread(self, lanes: Lane) -> Lane:
        """Starts that are far enough apart to share the work."""
        chosen: list[int] = []
        reach = 6.0 * self.first(lanes.tangent)
        for k, z in enumerate(lanes.z):
            away = np.linalg.norm(z - lanes.z[chosen], axis=1)
            if np.all(away > np.maximum(reach[k], reach[chosen])):
                chosen.append(k)
        return Lane(*(leaf[chosen] for leaf in lanes))

    def trace(self, seeds: Lane, max_points: int) -> list[tuple[np.ndarray, bool]]:
        """The points of each curve, and whether it is closed."""
        if len(seeds.z) == 0:
            return []
        seeds = self.spread(seeds)
        forward, links = self.march(seeds, seeds, 1.0, max_points)
        reached = set(links.values())
        first = [k for k in range(len(seeds.z)) if k not in reached]
        backward: dict[int, list] = {k: [] for k in first}
        if first:
            lanes = Lane(*(leaf[first] for leaf in seeds))
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
        return _joined(curves, 2.0 * _FIRST)

    def march(self, lanes: Lane, seeds: Lane, direction: float, max_points: int):
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
            now = Lane(
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
