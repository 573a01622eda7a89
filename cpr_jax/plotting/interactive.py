"""An interactive view of robots in space, for notebooks, by plotly.

Planar robots lie in the plane x = 0.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.ellipsoid import Ellipsoid
from ..errors import InputError
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.status import Status
from ..studies.outcome import MonteCarlo
from .solids import (
    SIDES,
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

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


def view_robot(
    robot: Robot,
    equilibrium: Equilibrium,
    ellipsoid: Ellipsoid | None = None,
    samples: MonteCarlo | None = None,
    *,
    scale: float = 1.0,
    radius: float | None = None,
    unit: float = 1e3,
) -> "Figure":
    """A robot that a mouse turns, with its uncertainty; the mouse shows arc lengths on rods.

    **Arguments:**

    - `ellipsoid`: of the position of the end-effector.
    - `samples`: draws the cloud of a Monte Carlo study.
    - `scale`: magnifies ellipsoid and cloud about their centre; they are small beside robots.
    - `radius`: with which rods are drawn, m; by default one that is visible.
    - `unit`: factor from m to the unit of the axes; 1000 shows millimetres.

    **Returns:** a plotly figure; a notebook shows it, `write_html` saves it.
    """
    try:
        import plotly.graph_objects as go
    except ImportError:
        raise InputError(
            "Function `view_robot` must have plotly, but it is not installed: "
            "`pip install 'cpr_jax[notebook]'`."
        ) from None
    drawn = solved_shape(robot, equilibrium)
    solids = robot_solids(robot, drawn, radius)
    hover = [
        f"rod {i + 1}<br>s = {unit * s:.4g} {unit_name(unit)}"
        for i, row in enumerate(np.asarray(drawn.s))
        for s in np.repeat([row[0], *row, row[-1]], SIDES)
    ]
    surfaces = {
        "rods": (BLUE, {"text": hover, "hoverinfo": "text"}),
        "segments": (BLACK, {}),
        "motors": (GREY, {}),
        "joints": ("white", {}),
    }
    figure = go.Figure()
    for name, (colour, look) in surfaces.items():
        if grids := getattr(solids, name):
            figure.add_trace(_mesh(go, grids, unit, name, color=colour, **look))
    if robot.oriented:
        # The first row is the centre, the second the outline.
        plate = outline(world(drawn.joints))
        grid = np.stack([np.broadcast_to(plate.mean(axis=0), plate.shape), plate])
        figure.add_trace(_mesh(go, [grid], unit, "platform", color=GREY, opacity=0.5))
    d = robot.geometry.d
    point = unit * world(equilibrium.q_p[:d])
    figure.add_trace(_markers(go, point[None], "end-effector", VERMILION, 4.0))
    if samples is not None:
        places = unit * world(magnified(samples.q_p[:, :d], samples.ellipsoid.center, scale))
        solved = samples.status == Status.SOLVED
        for name, colour, where in (
            ("inside", BLUE, solved & samples.inside),
            ("outside", VERMILION, solved & ~samples.inside),
        ):
            figure.add_trace(_markers(go, places[where], f"samples {name}", colour, 1.5))
    if ellipsoid is not None:
        surface = ellipsoid_surface(ellipsoid, scale)
        name = "ellipsoid" if scale == 1.0 else f"ellipsoid × {scale:g}"
        figure.add_trace(_mesh(go, [surface], unit, name, color=ORANGE, opacity=0.4))
    named = f" ({unit_name(unit)})" if unit_name(unit) else ""
    figure.update_layout(
        scene={
            "aspectmode": "data",
            **{f"{axis}axis": {"title": {"text": axis + named}} for axis in "xyz"},
        },
        title={"text": robot.name},
        legend={"itemsizing": "constant"},
        margin={"l": 0, "r": 0, "t": 40, "b": 0},
    )
    return figure


def _mesh(go: Any, grids: Sequence[np.ndarray], unit: float, name: str, **look: Any) -> Any:
    """One plotly mesh of several surfaces."""
    sizes = [grid[..., 0].size for grid in grids]
    corners = [
        start + faces(np.arange(size).reshape(*grid.shape[:2], 1))[..., 0]
        for grid, size, start in zip(grids, sizes, np.cumsum([0, *sizes]), strict=False)
    ]
    a, b, c, d = np.concatenate(corners).T
    x, y, z = unit * np.concatenate([grid.reshape(-1, 3) for grid in grids]).T
    triangles = {"i": [*a, *a], "j": [*b, *c], "k": [*c, *d]}
    look = {"hoverinfo": "name", "showlegend": True, "name": name, **look}
    return go.Mesh3d(x=x, y=y, z=z, **triangles, **look)


def _markers(go: Any, points: np.ndarray, name: str, color: str, size: float) -> Any:
    x, y, z = points.T
    look = {"color": color, "size": size}
    return go.Scatter3d(x=x, y=y, z=z, mode="markers", marker=look, name=name, hoverinfo="name")
