"""The interactive view: its meshes are those of the robot, closed and to scale."""

import sys

import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.plotting.interactive import view_robot
from cpr_jax.plotting.solids import robot_solids
from cpr_jax.robots.catalogue_space import three_rfs

pytest.importorskip("plotly")


@pytest.fixture(scope="module")
def solved():
    robot = three_rfs()
    equilibrium = cpr.solve_forward(robot, robot.home.q_a)
    ellipsoid = cpr.ellipsoid(cpr.sensitivity(robot, equilibrium))
    return robot, equilibrium, cpr.shape(robot, equilibrium), ellipsoid


@pytest.fixture(scope="module")
def figure(solved):
    robot, equilibrium, _, ellipsoid = solved
    return view_robot(robot, equilibrium, ellipsoid, scale=5.0, radius=0.002)


def trace(figure, name):
    (found,) = (trace for trace in figure.data if trace.name == name)
    return found


def vertices(trace):
    return np.stack([trace.x, trace.y, trace.z], axis=1) / 1e3


def volume(trace):
    """By the divergence theorem: right only if the triangles close the surface and face outward."""
    a, b, c = (vertices(trace)[np.array(index)] for index in (trace.i, trace.j, trace.k))
    return np.sum(np.cross(a, b) * c) / 6.0


def test_rods_are_tubes_to_scale(solved, figure):
    robot, _, shape, _ = solved
    drawn = vertices(trace(figure, "rods"))
    expected = np.concatenate([g.reshape(-1, 3) for g in robot_solids(robot, shape, 0.002).rods])
    assert np.allclose(drawn, expected, atol=1e-12)
    # A prism of 16 sides along three rods of 0.3 m.
    area = 8.0 * 0.002**2 * np.sin(np.pi / 8.0)
    assert volume(trace(figure, "rods")) == pytest.approx(3 * 0.3 * area, rel=1e-3)


def test_mouse_shows_arc_length(solved, figure):
    _, _, shape, _ = solved
    rods = trace(figure, "rods")
    assert len(rods.text) == len(rods.x)
    assert rods.hoverinfo == "text"
    for i in range(3):
        place = 1e3 * np.asarray(shape.rods.position[i, 25])
        distance = np.linalg.norm(np.stack([rods.x, rods.y, rods.z], axis=1) - place, axis=1)
        nearest = np.argsort(distance)[:16]
        assert {rods.text[k] for k in nearest} == {f"rod {i + 1}<br>s = 150 mm"}


def test_platform_has_the_area_between_the_joints(solved, figure):
    _, _, shape, _ = solved
    platform = trace(figure, "platform")
    a, b, c = (vertices(platform)[np.array(n)] for n in (platform.i, platform.j, platform.k))
    drawn = 0.5 * np.sum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    p, q, r = np.asarray(shape.joints)
    assert drawn == pytest.approx(0.5 * np.linalg.norm(np.cross(q - p, r - p)), rel=1e-9)


def test_ellipsoid_is_magnified(solved, figure):
    ellipsoid = solved[-1]
    mesh = trace(figure, "ellipsoid × 5")
    assert np.allclose(ellipsoid.level(vertices(mesh)), 25.0, rtol=1e-6)
    ball = 4.0 / 3.0 * np.pi * 125.0 * float(np.prod(ellipsoid.semi_axes))
    assert volume(mesh) == pytest.approx(ball, rel=0.02)


def test_layout(figure):
    scene = figure.layout.scene
    assert scene.aspectmode == "data"
    titles = [scene[f"{axis}axis"].title.text for axis in "xyz"]
    assert titles == ["x (mm)", "y (mm)", "z (mm)"]
    assert all(trace.showlegend is not False for trace in figure.data)


def test_cloud_is_parted_and_magnified(solved):
    robot, equilibrium, _, ellipsoid = solved
    center = np.asarray(ellipsoid.center)
    offsets = 1e-3 * np.array([[1.0, 0.0, 0.0], [0.0, 3.0, 0.0], [np.nan] * 3])
    study = cpr.MonteCarlo(**{name: None for name in cpr.MonteCarlo._fields})._replace(
        q_p=np.pad(center + offsets, ((0, 0), (0, 3))),
        status=np.array([cpr.Status.SOLVED, cpr.Status.SOLVED, cpr.Status.LOST]),
        inside=np.array([True, False, False]),
        ellipsoid=ellipsoid,
    )
    figure = view_robot(robot, equilibrium, samples=study, scale=10.0)
    for name, offset in (("samples inside", offsets[0]), ("samples outside", offsets[1])):
        assert np.allclose(vertices(trace(figure, name)), center + 10.0 * offset)


def test_planar_robots_lie_in_their_plane():
    robot = cpr.rfrfr()
    equilibrium = cpr.solve_inverse(robot, (0.06, 0.18))
    ellipsoid = cpr.ellipsoid(cpr.sensitivity(robot, equilibrium))
    figure = view_robot(robot, equilibrium, ellipsoid, radius=0.002)
    rods = vertices(trace(figure, "rods")).reshape(2, -1, 16, 3)[:, 1:-1]
    line = np.asarray(cpr.shape(robot, equilibrium).rods.position)
    arms = rods - np.pad(line, ((0, 0), (0, 0), (1, 0)))[:, :, None]
    assert np.allclose(np.linalg.norm(arms, axis=-1), 0.002, rtol=1e-9)
    rim = vertices(trace(figure, "ellipsoid"))
    assert np.all(rim[:, 0] == 0.0)
    assert np.max(ellipsoid.level(rim[:, 1:])) == pytest.approx(1.0)
    # Its motors turn about x.
    motors = vertices(trace(figure, "motors"))
    assert set(np.round(np.abs(motors[:, 0]), 12)) == {0.006}
    assert not any(trace.name == "platform" for trace in figure.data)


def test_missing_plotly_is_named(solved, monkeypatch):
    robot, equilibrium, *_ = solved
    monkeypatch.setitem(sys.modules, "plotly.graph_objects", None)
    with pytest.raises(cpr.InputError, match=r"pip install 'cpr_jax\[notebook\]'"):
        view_robot(robot, equilibrium)
