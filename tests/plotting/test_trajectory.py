"""Figures of trajectories: what is drawn is what the dataset says."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import cpr_jax as cpr
from cpr_jax.plotting.trajectory import plot_path, plot_trajectory


def made_up(happened, reached=0.09, axes="yz", certain=False):
    """A trajectory of ten stops, 10 mm apart, of which those up to `reached` are solved."""
    random = np.random.default_rng(3)
    s = 0.01 * np.arange(10)
    solved = s <= reached + 1e-12

    def column(*shape):
        values = random.uniform(1.0, 2.0, (10, *shape))
        values[~solved] = np.nan
        return values

    labels = [f"p_P_{axis}" for axis in axes]
    Pi_p = column(len(axes), 3)
    delta = np.array([1e-3, 2e-3, 3e-3])
    semi_axes = np.full((10, len(axes)), np.nan)
    semi_axes[solved] = np.linalg.svd(Pi_p[solved] * delta, compute_uv=False)
    waypoint = np.zeros(10, int)
    waypoint[[0, 4, 9]] = 1
    variables = {
        "q_a": (("s", "motor"), column(2), {"units": "rad"}),
        "motor_torque": (("s", "motor"), column(2), {"units": "N m"}),
        "q_p": (("s", "coordinate"), column(len(axes))),
        "sigma_t1": (("s",), column()),
        "sigma_t2": (("s",), column()),
        "stable": (("s",), solved.astype(int)),
        "waypoint": (("s",), waypoint),
    }
    if not certain:
        variables |= {
            "semi_axis_max": (("s",), semi_axes[:, 0]),
            "semi_axis_min": (("s",), semi_axes[:, -1]),
            "Pi_p": (("s", "coordinate", "parameter"), Pi_p),
            "delta": (("parameter",), delta),
        }
    return xr.Dataset(
        variables,
        coords={
            "s": ("s", s, {"units": "m"}),
            "motor": ["q1", "q2"],
            "imposed": labels[-2:],
            "coordinate": labels,
            "space": list(axes),
        },
        attrs={"reached": reached, "events": json.dumps(happened)},
    )


UNSTABLE = [
    {"s": 0.02, "event": "unstable", "index": 1},
    {"s": 0.05, "event": "stable", "index": 0},
    {"s": 0.065, "event": "end", "status": "beyond_fold"},
]


@pytest.fixture
def figure():
    drawn = []
    yield drawn.append
    for one in drawn:
        plt.close(one)


def test_panels_hold_the_curves_in_their_units(figure):
    dataset = made_up([])
    drawn = plot_trajectory(dataset)
    figure(drawn)
    motors, torques, spread, _ = drawn.axes
    for k in range(2):
        x, y = motors.lines[k].get_data()
        np.testing.assert_allclose(x, 1e3 * dataset["s"])
        np.testing.assert_allclose(y, np.rad2deg(dataset["q_a"].values[:, k]))
        np.testing.assert_allclose(torques.lines[k].get_ydata(), dataset["motor_torque"][:, k])
    np.testing.assert_allclose(spread.lines[0].get_ydata(), 1e3 * dataset["semi_axis_max"])
    assert torques.get_ylabel() == "torques (N·m)"
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == ["waypoint"]


def test_grounds_are_where_the_events_say(figure):
    drawn = plot_trajectory(made_up(UNSTABLE, reached=0.065))
    figure(drawn)
    for ax in drawn.axes:
        unstable, missed = ax.patches
        assert (unstable.get_x(), unstable.get_width()) == pytest.approx((20.0, 30.0))
        assert (missed.get_x(), missed.get_width()) == pytest.approx((65.0, 25.0))
    names = [text.get_text() for text in drawn.legends[0].get_texts()]
    assert names == ["unstable", "not reached", "waypoint"]


def test_what_stays_unstable_is_so_to_the_end(figure):
    drawn = plot_trajectory(made_up(UNSTABLE[:1]))
    figure(drawn)
    (ground,) = drawn.axes[0].patches
    assert ground.get_x() + ground.get_width() == pytest.approx(90.0)


def test_limits_have_a_ground_of_their_own(figure):
    limits = [{"s": 0.0, "event": "beyond limits"}, {"s": 0.03, "event": "within limits"}]
    drawn = plot_trajectory(made_up(limits))
    figure(drawn)
    (ground,) = drawn.axes[0].patches
    assert (ground.get_x(), ground.get_width()) == pytest.approx((0.0, 30.0))
    assert drawn.legends[0].get_texts()[0].get_text() == "beyond a limit"


def test_what_is_no_trajectory_is_refused(figure):
    drawn, ax = plt.subplots()
    figure(drawn)
    for call in (plot_trajectory, cpr.events, lambda data: plot_path(data, ax)):
        with pytest.raises(ValueError, match="`dataset` must be one of `trajectory`"):
            call(made_up([]).assign_attrs(events=None).drop_attrs())


def test_without_uncertainties_there_are_three_panels(figure):
    drawn = plot_trajectory(made_up([], certain=True))
    figure(drawn)
    assert len(drawn.axes) == 3


@pytest.mark.parametrize(("axes", "rows"), [(None, (1, 2)), (("x", "z"), (0, 2))])
def test_a_path_is_drawn_in_its_plane_with_ellipses_of_its_sensitivities(figure, axes, rows):
    dataset, rng = made_up([], reached=0.065, axes="xyz"), np.random.default_rng(0)
    drawn, ax = plt.subplots()
    figure(drawn)
    plot_path(dataset, ax, axes=axes, ellipses=2)
    places = 1e3 * dataset["q_p"].values[:, rows]
    np.testing.assert_allclose(np.stack(ax.lines[0].get_data(), axis=1), places)
    for patch, k in zip(ax.patches, (0, 6), strict=True):
        np.testing.assert_allclose(patch.center, places[k])
        spread = 1e3 * dataset["Pi_p"].values[k][list(rows)] * dataset["delta"].values
        # How far it reaches in any direction is what the kernel says.
        normals = rng.normal(size=(20, 2))
        angle = np.deg2rad(patch.angle)
        along = normals @ [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        reach = np.linalg.norm(along * [0.5 * patch.width, 0.5 * patch.height], axis=1)
        np.testing.assert_allclose(reach, np.linalg.norm(normals @ spread, axis=1), rtol=1e-9)
        axes_of_it = np.linalg.svd(spread, compute_uv=False)
        np.testing.assert_allclose((patch.width, patch.height), 2.0 * axes_of_it)


def test_planes_are_named_by_positions(figure):
    drawn, ax = plt.subplots()
    figure(drawn)
    with pytest.raises(
        ValueError, match=r"`axes` must be two of the platform's coordinates \(y, z"
    ):
        cpr.plot_path(made_up([]), ax, axes=("x", "y"))
