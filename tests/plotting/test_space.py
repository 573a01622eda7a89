"""Figures of robots in space: geometric facts about what is drawn."""

import dataclasses

import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import pytest
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import cpr_jax as cpr
from cpr_jax.plotting.solids import ellipsoid_surface, faces, outline, robot_solids
from cpr_jax.plotting.space import _lit, _Plate, plot_cloud_3d, plot_ellipsoid_3d, plot_robot_3d
from cpr_jax.plotting.style import BLUE, VERMILION
from cpr_jax.robots.catalogue_space import three_rfs

# Not right-handed, not along the axes, of three different lengths, in metres.
TURN = np.linalg.qr(np.array([[1.0, 2.0, 3.0], [2.0, -1.0, 1.0], [0.5, 1.0, -2.0]]))[0]
SEMI_AXES = np.array([0.03, 0.01, 0.004])
CENTER = np.array([0.01, -0.02, 0.3])


def skewed(sign):
    """An ellipsoid whose directions are right-handed or left-handed."""
    rows = TURN * np.array([[1.0], [1.0], [sign * np.linalg.det(TURN)]])
    return cpr.Ellipsoid(
        jnp.asarray(CENTER),
        jnp.asarray(rows.T @ np.diag(SEMI_AXES**2) @ rows),
        jnp.asarray(SEMI_AXES),
        jnp.asarray(rows),
        ("p_P_x", "p_P_y", "p_P_z"),
    )


@pytest.fixture(scope="module")
def solved():
    robot = three_rfs()
    equilibrium = cpr.solve_forward(robot, robot.home.q_a)
    return robot, equilibrium, cpr.shape(robot, equilibrium)


@pytest.fixture
def ax():
    figure, ax = plt.subplots(subplot_kw={"projection": "3d"})
    yield ax
    plt.close(figure)


def length_of_a_unit(ax):
    limits = np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()])
    return ax._box_aspect / np.ptp(limits, axis=1)


def inside_limits(ax, points):
    low, high = np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()]).T
    return np.all((points >= low) & (points <= high))


def test_rods_are_tubes_of_the_radius(solved):
    robot, _, shape = solved
    radius = 0.0017
    for rod, line in zip(robot_solids(robot, shape, radius).rods, shape.rods.position, strict=True):
        arms = rod[1:-1] - np.asarray(line)[:, None]
        assert np.allclose(np.linalg.norm(arms, axis=-1), radius, rtol=1e-9)
        # Across the centre line: the rod is unshearable.
        tangents = np.gradient(np.asarray(line), np.asarray(shape.s[0]), axis=0)[1:-1]
        assert np.max(np.abs(np.einsum("ksd,kd->ks", arms[1:-1], tangents))) < 1e-3 * radius
        assert np.allclose(rod[0], line[0], atol=1e-12)
        assert np.allclose(rod[-1], line[-1], atol=1e-12)


def test_motors_are_cylinders_about_their_axes(solved):
    robot, _, shape = solved
    for k, motor in enumerate(robot_solids(robot, shape).motors):
        angle = np.deg2rad(120.0 * k)
        tangent = np.array([-np.sin(angle), np.cos(angle), 0.0])
        arms = motor - np.asarray(shape.motors[k])
        along = arms @ tangent
        assert np.allclose(np.abs(along), np.abs(along[0, 0]))
        radii = np.linalg.norm(arms - along[..., None] * tangent, axis=-1)
        assert np.allclose(radii[[0, -1]], 0.0, atol=1e-12)
        assert np.allclose(radii[1:-1], radii[1, 0])


def test_rigid_segments_and_rails_are_drawn_where_they_are(solved):
    robot, _, shape = solved
    assert robot_solids(robot, shape).segments == []
    # A crank of leg 2 alone: from its motor to its passive joint.
    moved = shape._replace(pivots=shape.pivots.at[1, 2].add(-0.05))
    crank, segment = robot_solids(robot, moved).segments
    assert np.allclose(crank[[0, -1], 0], [shape.motors[1], moved.pivots[1]])
    assert np.allclose(segment[[0, -1], 0], [moved.pivots[1], shape.rods.position[1, 0]])


def test_corners_of_the_platform_are_the_joints(solved, ax):
    robot, equilibrium, shape = solved
    plot_robot_3d(robot, equilibrium, ax)
    base, platform = (plate for plate in ax.collections if isinstance(plate, _Plate))
    for plate, points in ((base, robot.legs.base_position), (platform, shape.joints)):
        corners = plate._faces[0]
        assert len(corners) == 3
        distances = np.linalg.norm(corners[:, None] - 1e3 * np.asarray(points), axis=-1)
        assert np.max(np.min(distances, axis=0)) < 1e-9


def test_outline_goes_round_in_the_plane_of_the_points():
    angles = np.deg2rad([200.0, 10.0, 130.0, 340.0, 60.0, 270.0])
    flat = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    points = np.concatenate([flat, [[0.1, 0.2, 0.0]]]) @ TURN + CENTER
    corners = outline(points)
    assert len(corners) == 6  # the inner point is none
    edges = np.roll(corners, -1, axis=0) - corners
    turns = np.cross(edges, np.roll(edges, -1, axis=0)) @ TURN[2]
    assert np.all(turns > 0.0) or np.all(turns < 0.0)
    line = np.outer([0.0, 2.0, 1.0], TURN[0])
    assert np.allclose(outline(line), line)


@pytest.mark.parametrize("elevation, before", [(20.0, True), (-20.0, False)])
def test_platform_covers_the_rods_when_seen_from_above(solved, ax, elevation, before):
    robot, equilibrium, _ = solved
    plot_robot_3d(robot, equilibrium, ax)
    ax.view_init(elev=elevation, azim=-55.0)
    ax.figure.canvas.draw()
    base, platform = (plate for plate in ax.collections if isinstance(plate, _Plate))
    solids = next(c for c in ax.collections if not isinstance(c, _Plate))
    assert (platform.get_zorder() > solids.get_zorder()) == before
    assert (base.get_zorder() < solids.get_zorder()) == before


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_surface_of_an_ellipsoid(sign):
    ellipsoid = skewed(sign)
    offset = (ellipsoid_surface(ellipsoid) - CENTER).reshape(-1, 3)
    level = np.einsum("ki,ij,kj->k", offset, np.linalg.inv(ellipsoid.kernel), offset)
    assert np.allclose(level, 1.0, rtol=1e-9)
    # Faces look outward whichever hand the semi-axes are of.
    corners = faces(ellipsoid_surface(ellipsoid)) - CENTER
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert np.all(np.sum(normals * corners.mean(axis=1), axis=1) > 0.0)
    tripled = (ellipsoid_surface(ellipsoid, 3.0) - CENTER).reshape(-1, 3)
    assert np.allclose(tripled, 3.0 * offset)
    assert np.allclose(np.ptp(offset @ TURN.T, axis=0), 2.0 * SEMI_AXES, rtol=1e-2)


def test_drawn_ellipsoid_has_the_unit_and_its_principal_sections(ax):
    ellipsoid = skewed(1.0)
    plot_ellipsoid_3d(ellipsoid, ax, scale=2.0)
    corners = ax.collections[0]._faces.reshape(-1, 3) / 1e3
    sections = [np.stack(line.get_data_3d(), axis=1) / 1e3 for line in ax.lines]
    for points in (corners, *sections):
        assert np.allclose(ellipsoid.level(points), 4.0, rtol=1e-9)
    # Each section lies in the plane of two semi-axes and goes all the way round.
    normals = set()
    for points in sections:
        along = (points - CENTER) @ np.asarray(ellipsoid.directions).T
        normals.add(int(np.argmin(np.ptp(along, axis=0) / SEMI_AXES)))
        spans = np.sort(np.ptp(along, axis=0) / SEMI_AXES)
        assert np.allclose(spans, [0.0, 4.0, 4.0], atol=1e-6)
        assert np.allclose(points[0], points[-1])
    assert normals == {0, 1, 2}


def test_all_directions_have_one_scale(solved, ax):
    robot, equilibrium, shape = solved
    plot_robot_3d(robot, equilibrium, ax)
    assert np.allclose(length_of_a_unit(ax), length_of_a_unit(ax)[0])
    assert inside_limits(ax, 1e3 * np.asarray(shape.rods.position).reshape(-1, 3))
    # What is added later fits as well, and has the same scale.
    far = 1.5 * np.asarray(shape.joints)
    plot_cloud_3d(far, ax)
    assert np.allclose(length_of_a_unit(ax), length_of_a_unit(ax)[0])
    assert inside_limits(ax, 1e3 * far)
    assert [ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()] == ["x (mm)", "y (mm)", "z (mm)"]


def test_cloud_is_parted_and_magnified(ax):
    points = np.array([[0.0, 0.0, 0.1], [0.01, 0.0, 0.1], [np.nan] * 3, [0.0, 0.03, 0.1]])
    inside = np.array([True, True, False, False])
    plot_cloud_3d(points, ax, inside=inside, center=points[0], scale=2.0)
    dots, crosses = (np.stack(line.get_data_3d(), axis=1) for line in ax.lines)
    assert np.allclose(dots, [[0.0, 0.0, 100.0], [20.0, 0.0, 100.0]])
    assert np.allclose(crosses, [[0.0, 60.0, 100.0]])
    assert [line.get_color() for line in ax.lines] == [BLUE, VERMILION]


def test_a_cloud_is_taken_from_a_study(ax):
    robot = cpr.rfrfr()
    study = cpr.monte_carlo(robot, cpr.solve_inverse(robot, (0.0, 0.2)), 200)
    plot_cloud_3d(study, ax)
    dots, crosses = (np.stack(line.get_data_3d(), axis=1) for line in ax.lines)
    assert np.allclose(dots[:, 1:], 1e3 * study.q_p[study.inside])
    assert np.allclose(crosses[:, 1:], 1e3 * study.q_p[~study.inside])


def test_light_comes_from_above():
    up = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    above, below = _lit(np.stack([up, up[::-1]]), "white")[:, 0]
    assert above > 0.9 > 0.6 > below


def test_mistakes_are_named(solved, ax):
    robot, equilibrium, _ = solved
    points = np.zeros((4, 3))
    other = dataclasses.replace(skewed(1.0), labels=("q1", "q2", "q3"))
    figure, flat = plt.subplots()
    lost = dataclasses.replace(equilibrium, status=jnp.asarray(cpr.Status.LOST))
    calls = {
        "ax": lambda: plot_robot_3d(robot, equilibrium, flat),
        "equilibrium": lambda: plot_robot_3d(robot, lost, ax),
        "radius": lambda: plot_robot_3d(robot, equilibrium, ax, radius=-1.0),
        "scale": lambda: plot_ellipsoid_3d(skewed(1.0), ax, scale=0.0),
        "ellipsoid": lambda: plot_ellipsoid_3d(other, ax),
        "center": lambda: plot_cloud_3d(points, ax, scale=2.0),
        "inside": lambda: plot_cloud_3d(points, ax, inside=[True]),
        "points": lambda: plot_cloud_3d(points[0], ax),
    }
    for name, call in calls.items():
        with pytest.raises(cpr.InputError, match=rf"^Argument `{name}` must .*, but "):
            call()
    plt.close(figure)
    assert not any(isinstance(c, Poly3DCollection) for c in ax.collections)
