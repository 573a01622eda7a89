"""Robots in space, their uncertainty ellipsoids and clouds, for papers.

Planar robots lie in the plane x = 0.
"""

from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from ..analysis.ellipsoid import Ellipsoid
from ..errors import InputError
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.shape import Shape
from ..studies.outcome import MonteCarlo
from .solids import (
    ellipsoid_surface,
    faces,
    magnified,
    outline,
    robot_solids,
    solved_shape,
    unit_name,
    world,
)
from .style import BLACK, BLUE, GREY, ORANGE, VERMILION

# What is drawn later covers what is drawn earlier, see `_Plate`.
_BEHIND, _SOLID, _BEFORE, _CLOUD, _SURFACE, _POINT = range(1, 7)


def plot_robot_3d(
    robot: Robot,
    equilibrium: Equilibrium,
    ax: Axes,
    *,
    color: str = BLUE,
    alpha: float = 1.0,
    unit: float = 1e3,
    radius: float | None = None,
) -> Shape:
    """Draws rods, rigid segments, motors, joints, base, platform and end-effector of a robot.

    Further robots, ellipsoids and clouds may follow on the same axes.

    **Arguments:**

    - `ax`: three-dimensional axes, `plt.subplots(subplot_kw={"projection": "3d"})`.
    - `color`: of the rods.
    - `unit`: factor from m to the unit of the axes; 1000 draws millimetres.
    - `radius`: with which rods are drawn, m; by default one that is visible.

    **Returns:** the shape that was drawn, in m.
    """
    axes = _three_dimensional(ax)
    drawn = solved_shape(robot, equilibrium)
    solids = robot_solids(robot, drawn, radius)
    colours = {"rods": color, "segments": "0.25", "motors": "0.45", "joints": "0.97"}
    named = [(unit * faces(g), c) for name, c in colours.items() for g in getattr(solids, name)]
    quads = np.concatenate([part for part, _ in named])
    paint = np.concatenate([_lit(part, colour) for part, colour in named])
    # One collection: its faces are sorted by depth, several collections only as wholes. Edges in
    # the colour of the faces close the seams between them; translucent ones would show.
    edges: Any = {"edgecolors": paint if alpha == 1.0 else "none", "linewidths": 0.3}
    axes.add_collection3d(
        Poly3DCollection(quads, facecolors=paint, alpha=alpha, zorder=_SOLID, **edges)
    )
    plates = [(robot.legs.base_position, 0.1 * alpha)]
    if robot.oriented:
        plates.append((drawn.joints, 0.4 * alpha))
    for corners, opacity in plates:
        plate = unit * outline(world(corners))
        axes.add_collection3d(_Plate(plate, quads, opacity))
    point = unit * world(equilibrium.q_p[: robot.geometry.d])
    axes.plot(*point[:, None], "o", ms=3, color=VERMILION, alpha=alpha, zorder=_POINT)
    _dress(axes, unit)
    return drawn


def plot_ellipsoid_3d(
    ellipsoid: Ellipsoid,
    ax: Axes,
    *,
    scale: float = 1.0,
    color: str = ORANGE,
    alpha: float = 0.35,
    unit: float = 1e3,
    label: str | None = None,
) -> None:
    """Draws the translucent surface of a position's uncertainty ellipsoid.

    **Arguments:**

    - `scale`: magnification about its centre; ellipsoids are small beside robots.
    - `unit`: factor from m to the unit of the axes; 1000 draws millimetres.
    """
    axes = _three_dimensional(ax)
    surface = unit * ellipsoid_surface(ellipsoid, scale)
    look: Any = {"alpha": alpha, "edgecolors": "none", "zorder": _SURFACE, "label": label}
    axes.add_collection3d(Poly3DCollection(faces(surface), facecolors=color, **look))
    # Its principal sections show how it lies; shades would mix with what shines through.
    rows, turns = (size // 2 for size in surface.shape[:2])
    sections = [surface[rows, np.arange(-1, 2 * turns)]]
    for turn in (0, turns // 2):
        sections.append(np.concatenate([surface[:, turn], surface[::-1, turn + turns]]))
    for section in sections:
        axes.plot(*section.T, color=BLACK, lw=0.4, alpha=0.6, zorder=_SURFACE)
    _dress(axes, unit)


def plot_cloud_3d(
    points: Float[np.ndarray, "k d"] | MonteCarlo,
    ax: Axes,
    *,
    inside: np.ndarray | None = None,
    center: Float[np.ndarray, " d"] | None = None,
    scale: float = 1.0,
    color: str = BLUE,
    unit: float = 1e3,
) -> None:
    """Draws a cloud of end-effectors.

    Points with NaN, samples without an equilibrium, have no place here.

    **Arguments:**

    - `points`: m, shape `(k, d)`, or a study, of which it takes these and what is `inside`.
    - `inside`: whether each point is inside its ellipsoid, shape `(k,)`: dots inside, crosses
        outside.
    - `center`, `scale`: the magnification about a point, m, shape `(d,)`, as of an ellipsoid.
    - `color`: of the dots.
    - `unit`: factor from m to the unit of the axes; 1000 draws millimetres.
    """
    axes = _three_dimensional(ax)
    if isinstance(points, MonteCarlo):
        inside = points.inside if inside is None else inside
        points = points.q_p[:, : points.ellipsoid.center.size]
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InputError(
            f"Argument `points` must have shape (k, 2) or (k, 3), but its shape is {points.shape}."
        )
    if center is None and scale != 1.0:
        raise InputError("Argument `center` must be given where `scale` is not 1, but it is None.")
    places = unit * world(magnified(points, 0.0 if center is None else center, scale))
    solved = np.all(np.isfinite(places), axis=1)
    groups: list[tuple] = [(solved, ".", 1.6, 0.0, color, None)]
    if inside is not None:
        inside = np.asarray(inside, bool)
        if inside.shape != solved.shape:
            raise InputError(
                f"Argument `inside` must have an entry for each of the {len(solved)} points, but "
                f"its shape is {inside.shape}."
            )
        groups = [
            (solved & inside, ".", 1.6, 0.0, color, "inside"),
            (solved & ~inside, "x", 2.6, 0.6, VERMILION, "outside"),
        ]
    for where, marker, size, edge, colour, label in groups:
        axes.plot(
            *places[where].T,
            marker,
            ms=size,
            mew=edge,
            color=colour,
            alpha=0.6,
            rasterized=True,
            zorder=_CLOUD,
            label=label,
        )
    _dress(axes, unit)


class _Plate(Poly3DCollection):
    """A flat plate before or behind the solids, as the view has it.

    A plane separates what is behind it from what is before it, whereas its depth, that of its
    middle, tells little about a face as large as this.
    """

    def __init__(self, corners: np.ndarray, solids: np.ndarray, opacity: float) -> None:
        fill, rim = to_rgba(GREY, opacity), to_rgba(BLACK, 1.2 * opacity)
        super().__init__([corners], facecolors=fill, edgecolors=rim, linewidths=0.5)
        center = corners.mean(axis=0)
        self._normal = np.linalg.svd(corners - center)[2][-1]
        self._side = np.sign(self._normal @ (solids.mean(axis=(0, 1)) - center))

    def do_3d_projection(self) -> float:
        axes = self.axes
        elevation, azimuth = np.deg2rad([axes.elev, axes.azim])
        level = np.cos(elevation)
        viewer = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
        self.set_zorder(_BEHIND if self._side * (self._normal @ viewer) > 0.0 else _BEFORE)
        return super().do_3d_projection()


def _three_dimensional(ax: Axes) -> Axes3D:
    if not isinstance(ax, Axes3D):
        raise InputError(
            "Argument `ax` must be three-dimensional, as of "
            '`plt.subplots(subplot_kw={"projection": "3d"})`, but it is flat.'
        )
    return ax


def _lit(quads: np.ndarray, color: str) -> np.ndarray:
    """Colours of faces in a light from above, shape `(m, 3)`."""
    # Diagonals have a normal even where two corners are one.
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    light = np.array([0.4, -0.5, 0.77])
    return np.array(to_rgb(color)) * (0.7 + 0.3 * normals @ light)[:, None]


def _dress(axes: Axes3D, unit: float) -> None:
    """Equal scales in all directions around all that was drawn; labels; white panes."""
    # Depth is in the order of drawing, within collections, and in `_Plate`.
    axes.computed_zorder = False
    axes.autoscale_view()
    limits = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()])
    spans = np.ptp(limits, axis=1)
    # A flat robot gets some depth, or else its ticks would coincide.
    spans = np.maximum(spans, 0.3 * spans.max())
    # Labels stand outside of the box, where matplotlib leaves no room for them.
    level, upright = np.linalg.norm(spans[:2]), spans[2]
    zoom = min(0.9, np.linalg.norm(spans) * min(0.72 / level, 0.62 / upright))
    axes.set_box_aspect(tuple(spans), zoom=float(zoom))
    for k, (name, middle, span) in enumerate(zip("xyz", limits.mean(axis=1), spans, strict=True)):
        ends = (middle - 0.5 * span, middle + 0.5 * span)
        getattr(axes, f"set_{name}lim")(*ends, auto=None)
        # matplotlib moves labels from an axis by shares of the other two; here by a length.
        share = zoom * np.linalg.norm(np.delete(spans, k)) / np.linalg.norm(spans)
        tick, title = (6.5, 15.5) if name == "z" else (4.3, 14.2)
        label = f"{name} ({unit_name(unit)})" if unit_name(unit) else name
        getattr(axes, f"set_{name}label")(label, labelpad=title / share - 21.0)
        axes.tick_params(axis=name, pad=tick / share - 8.0)
        axis = getattr(axes, f"{name}axis")
        axis.set_pane_color("0.97")
        axis.set_major_locator(MaxNLocator(max(3, round(5 * span / spans.max()))))
    axes.grid(False)
