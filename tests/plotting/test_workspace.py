"""Figures of workspace maps: units of the axes, and ellipses in slices of space."""

import equinox as eqx
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import cpr_jax as cpr
from cpr_jax.plotting.map_figure import figure_of_map
from cpr_jax.plotting.workspace import plot_ellipses, plot_map

SPACE = ("p_P_x", "p_P_y", "p_P_z", "phi_P_x", "phi_P_y", "phi_P_z")
PARAMETERS = 5


@pytest.fixture
def ax():
    figure, ax = plt.subplots()
    yield ax
    plt.close(figure)


def made_up_map(names, labels=SPACE):
    """A map with random sensitivities, of a few cells over two coordinates."""
    random = np.random.default_rng(5)
    units = ["rad" if name.startswith("phi") else "m" for name in names]
    lines = [0.1 + 0.01 * np.arange(5), 0.2 + 0.02 * np.arange(4)]
    shape = (5, 4)
    Pi_p = random.normal(size=(*shape, len(labels), PARAMETERS))
    delta = 10.0 ** random.uniform(-3, -2, PARAMETERS)
    d = sum(label.startswith("p_") for label in labels)
    directions, semi_axes, _ = np.linalg.svd(Pi_p[..., :d, :] * delta)
    over = tuple(names)
    return xr.Dataset(
        {
            "status": (over, np.zeros(shape, int)),
            "index": (over, np.zeros(shape, int)),
            "stable": (over, np.ones(shape, int)),
            "Pi_p": ((*over, "coordinate", "parameter"), Pi_p),
            "delta": (("parameter",), delta),
            "semi_axis_max": (over, semi_axes[..., 0], {"units": "m"}),
            "semi_axis_min": (over, semi_axes[..., -1], {"units": "m"}),
            "direction": ((*over, "space"), directions[..., :, 0]),
            "sigma_t2": (over, random.uniform(0.1, 1.0, shape), {"units": "1"}),
            "t1_line": (("curve", "point", "axis"), [[[0.1, 0.2], [0.14, 0.26]]]),
            "t2_line": (("curve", "point", "axis"), np.full((1, 2, 2), np.nan)),
        },
        coords={
            "axis": list(names),
            **{n: (n, v, {"units": u}) for n, v, u in zip(names, lines, units, strict=True)},
            "coordinate": list(labels),
        },
    )


def test_lines_go_with_the_cells_of_a_transposed_map(ax):
    dataset = made_up_map(("y", "z"), ("p_P_y", "p_P_z"))
    for drawn in (dataset, dataset.transpose("z", "y", ...)):
        ax = plot_map(drawn, colorbar=False)
        ends = np.array([[100.0, 200.0], [140.0, 260.0]])
        lines = [line.get_xydata() for line in ax.lines if np.all(np.isfinite(line.get_xydata()))]
        expected = ends if drawn is dataset else ends[:, ::-1]
        np.testing.assert_allclose(lines[0], expected)
        plt.close(ax.figure)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: (d.drop_vars("Pi_p"), [[0.12, 0.22]]), "`dataset` must have sensitivities"),
        (lambda d: (d, (0.12, 0.22)), "`points` must be rows of 2 numbers"),
        (lambda d: (d, [[0.12, 1.0]]), "`points` must be on the map, whose z goes from 0.2 to"),
        (lambda d: (d.expand_dims("x"), [[0.12, 0.22]]), "must be a map over two coordinates"),
    ],
)
def test_what_no_ellipses_can_be_drawn_of_is_named(ax, change, message):
    dataset, points = change(made_up_map(("y", "z"), ("p_P_y", "p_P_z")))
    with pytest.raises(cpr.InputError, match=message):
        plot_ellipses(dataset, points, ax)


def test_ellipses_of_a_planar_map_have_its_semi_axes(ax):
    dataset = made_up_map(("y", "z"), ("p_P_y", "p_P_z"))
    plot_ellipses(dataset, np.array([[0.121, 0.239]]), ax, scale=2.0)
    (patch,) = ax.patches
    cell = dataset.isel(y=2, z=2)
    np.testing.assert_allclose(patch.center, (120.0, 240.0))
    assert patch.width == pytest.approx(4e3 * float(cell["semi_axis_max"]))
    assert patch.height == pytest.approx(4e3 * float(cell["semi_axis_min"]))
    along = np.deg2rad(patch.angle)
    across = np.array([-np.sin(along), np.cos(along)])
    assert abs(across @ cell["direction"].values) < 1e-12


@pytest.mark.parametrize("names", [("x", "y"), ("x", "z"), ("z", "phi_P_y"), ("phi_P_z", "y")])
def test_ellipses_in_a_slice_are_shadows_of_the_ellipsoid(ax, names):
    """In every direction of the slice the ellipse reaches as far as the ellipsoid does."""
    dataset = made_up_map(names)
    plot_ellipses(dataset, np.array([[0.11, 0.26]]), ax)
    (patch,) = ax.patches
    labels = [name if name.startswith("phi") else f"p_P_{name}" for name in names]
    factors = np.array([np.rad2deg(1.0) if name.startswith("phi") else 1e3 for name in names])
    np.testing.assert_allclose(patch.center, factors * [0.11, 0.26])
    cell = dataset.isel({names[0]: 1, names[1]: 3})
    spread = cell["Pi_p"].sel(coordinate=labels).values * dataset["delta"].values
    turn = np.deg2rad(patch.angle)
    halves = 0.5 * np.array([patch.width, patch.height])
    for angle in np.linspace(0.0, np.pi, 7):
        direction = np.array([np.cos(angle), np.sin(angle)])
        drawn = np.linalg.norm(halves * [np.cos(angle - turn), np.sin(angle - turn)])
        assert drawn == pytest.approx(np.linalg.norm((direction * factors) @ spread), rel=1e-12)


@pytest.mark.parametrize(
    ("names", "labels", "aspect"),
    [
        (("x", "y"), ["x (mm)", "y (mm)"], 1.0),
        (("z", "phi_P_y"), ["z (mm)", r"$\varphi_y$ (°)"], "auto"),
        (("phi_P_x", "phi_P_y"), [r"$\varphi_x$ (°)", r"$\varphi_y$ (°)"], 1.0),
    ],
)
def test_axes_have_their_units(ax, names, labels, aspect):
    plot_map(made_up_map(names), ax=ax, robot=cpr.three_rfs())
    assert [ax.get_xlabel(), ax.get_ylabel()] == labels
    assert ax.get_aspect() == aspect
    factors = [np.rad2deg(1.0) if name.startswith("phi") else 1e3 for name in names]
    np.testing.assert_allclose(ax.lines[0].get_xydata()[1], factors * np.array([0.14, 0.26]))
    # No motor of a spatial robot lies in the slice.
    assert not any(line.get_marker() == "o" for line in ax.lines)


def test_motors_are_drawn_in_the_plane_of_a_planar_robot(ax):
    robot = cpr.three_rfr()
    labels = ("p_P_y", "p_P_z", "phi_P_x")
    plot_map(made_up_map(("z", "y"), labels), ax=ax, robot=robot)
    (line,) = (line for line in ax.lines if line.get_marker() == "o")
    expected = 1e3 * np.asarray(robot.legs.base_position)[:, ::-1]
    np.testing.assert_allclose(line.get_xydata(), expected)
    # The legend names motors where one of them is in view.
    near = robot.legs.base_position.at[1].set(jnp.array([0.12, 0.24]))
    beside = eqx.tree_at(lambda r: r.legs.base_position, robot, near)
    cases = ((("y", "z"), beside, True), (("y", "z"), robot, False))
    for names, shown, motors in (*cases, (("y", "phi_P_x"), beside, False)):
        figure = figure_of_map(made_up_map(names, labels), shown)
        (legend,) = figure.legends
        assert ("motor" in [text.get_text() for text in legend.get_texts()]) == motors
        plt.close(figure)
