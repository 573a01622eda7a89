"""The workspace map of the paper's robot, on a coarse grid."""

import dataclasses
import json

import numpy as np
import pytest
import xarray as xr

from cpr_jax.analysis.sensitivity import sensitivity
from cpr_jax.errors import InputError
from cpr_jax.plotting.map_figure import figure_of_map
from cpr_jax.plotting.workspace import plot_map
from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.statics.energy import integrated
from cpr_jax.statics.solve import solve_inverse
from cpr_jax.statics.status import Status
from cpr_jax.studies.limits import Limits
from cpr_jax.studies.results import save_dataset
from cpr_jax.studies.workspace import workspace_map
from tests.oracles.planar_shooting import PlanarRobot, energy, forward, inverse, residual

SPACING = 0.006


@pytest.fixture(scope="module")
def robot():
    return rfrfr()


@pytest.fixture(scope="module")
def mapped(robot):
    return workspace_map(robot, spacing=SPACING)


def unknowns(dataset, i, j):
    cell = dataset.isel(y=i, z=j)
    point = [float(cell["y"]), float(cell["z"])]
    return np.concatenate([cell["q_a"].values, point, cell["mu"].values.reshape(-1)])


def chosen(dataset, count, seed=0):
    """Random solved cells that are not beside a singularity, where shooting is ill-posed."""
    good = (dataset["index"].values >= 0) & (dataset["sigma_t2"].values > 4e-3)
    good &= dataset["sigma_t1"].values > 4e-3
    cells = np.argwhere(good)
    return cells[np.random.default_rng(seed).choice(len(cells), count, replace=False)]


def test_half_the_workspace_is_mapped_and_every_cell_says_why(mapped):
    assert mapped["y"].values[0] == 0.0
    status, index = mapped["status"].values, mapped["index"].values
    assert set(np.unique(status)) == {Status.SOLVED, Status.OUT_OF_REACH, Status.BEYOND_FOLD}
    np.testing.assert_array_equal(status == Status.SOLVED, index >= 0)
    for name in ("semi_axis_max", "Pi_p", "q_a", "energy", "sigma_t1"):
        finite = np.isfinite(mapped[name].values).reshape(*status.shape, -1)
        np.testing.assert_array_equal(np.all(finite, axis=-1), index >= 0)
    assert np.nanmax(mapped["residual"].values) < 1e-10


def test_cells_without_a_solution_are_where_geometry_says(mapped):
    """Out of reach is farther from a motor than a straight leg is long."""
    y, z = np.meshgrid(mapped["y"], mapped["z"], indexing="ij")
    far = np.max([np.hypot(y + side, z) for side in (-0.1, 0.1)], axis=0) > 0.045 + 0.25 + 0.035
    np.testing.assert_array_equal(mapped["status"].values == Status.OUT_OF_REACH, far)


def test_cells_are_equilibria_of_the_shooting_model(mapped):
    model = PlanarRobot()
    for i, j in chosen(mapped, 12):
        y = unknowns(mapped, i, j)
        np.testing.assert_allclose(residual(model, y), 0.0, atol=1e-7)
        cell = mapped.isel(y=i, z=j)
        np.testing.assert_allclose(float(cell["energy"]), energy(model, y), rtol=1e-7)


def test_sensitivity_and_velocity_of_cells_beside_differences(mapped):
    """Central differences of forward solves by shooting; semi-axes by their definition."""
    delta = mapped["delta"].values
    for i, j in chosen(mapped, 3, seed=1):
        cell = mapped.isel(y=i, z=j)
        Pi, J = _differences(unknowns(mapped, i, j))
        np.testing.assert_allclose(cell["Pi_p"], Pi, rtol=0, atol=2e-5 * np.max(np.abs(Pi)))
        axes = np.linalg.svd(Pi * delta, compute_uv=False)
        np.testing.assert_allclose(
            [cell["semi_axis_max"], cell["semi_axis_min"]], axes, rtol=0, atol=1e-4 * axes[0]
        )
        np.testing.assert_allclose(cell["manipulability"], abs(np.linalg.det(J)), rtol=1e-4)


def test_sensitivity_of_cells_is_that_of_single_solves(robot, mapped):
    """Cells are solved to the end before they are looked at: beside a fold little else will do."""
    for i, j in chosen(mapped, 8, seed=2):
        cell = mapped.isel(y=i, z=j)
        single = solve_inverse(robot, (float(cell["y"]), float(cell["z"])))
        np.testing.assert_allclose(cell["q_a"], single.q_a, rtol=0, atol=1e-8)
        Pi = np.asarray(sensitivity(robot, single).Pi_p)
        np.testing.assert_allclose(cell["Pi_p"], Pi, rtol=0, atol=1e-6 * np.max(np.abs(Pi)))


def _differences(y):
    """Motion of the platform per unit of k_b1, r_c1, k_b2, r_c2, and per unit of the motors."""

    def end(x):
        model = PlanarRobot(k_b=(x[2], x[4]), curvature=(1.0 / x[3], 1.0 / x[5]))
        return forward(model, x[:2], y)[2:4]

    x = np.array([*y[:2], 0.0183, -1.0, 0.0183, 1.0])
    steps = np.array([1e-5, 1e-5, 1e-6, 1e-4, 1e-6, 1e-4])
    columns = [
        (end(x + h * unit) - end(x - h * unit)) / (2.0 * h)
        for h, unit in zip(steps, np.eye(6), strict=True)
    ]
    return np.stack(columns[2:], axis=1), np.stack(columns[:2], axis=1)


def test_neighbours_lead_to_one_another(robot, mapped):
    """Followed from cell to cell in steps of a quarter, as nobody would map; but for the seam."""
    seam = mapped["seam"].values == 1
    index = mapped["index"].values
    pairs = []
    for offset in ((1, 0), (0, 1)):
        here = np.argwhere(index >= 0)
        there = here + offset
        inside = np.all(there < index.shape, axis=1)
        here, there = here[inside], there[inside]
        both = index[tuple(there.T)] >= 0
        both &= ~(seam[tuple(here.T)] & seam[tuple(there.T)])
        pairs += list(zip(here[both], there[both], strict=True))
    picked = np.random.default_rng(3).choice(len(pairs), 10, replace=False)
    for k in picked:
        (i, j), (m, n) = pairs[k]
        y = unknowns(mapped, i, j)
        goal = unknowns(mapped, m, n)
        # By shooting in four steps, each from the one before.
        for share in np.linspace(0.25, 1.0, 4):
            point = (1.0 - share) * unknowns(mapped, i, j)[2:4] + share * goal[2:4]
            y = inverse(PlanarRobot(), point, y)
        np.testing.assert_allclose(y[:2], goal[:2], rtol=0, atol=1e-6)


def test_the_left_half_is_the_mirror_image(robot, mapped):
    whole = workspace_map(robot, spacing=0.012, box=((-0.09, 0.15), (0.09, 0.27)))
    axes = whole["semi_axis_max"].values
    np.testing.assert_allclose(axes, axes[::-1], rtol=1e-7)
    shared = mapped["semi_axis_max"].sel(y=whole["y"][whole["y"] > -1e-9], z=whole["z"])
    np.testing.assert_allclose(axes[len(axes) // 2 :], shared, rtol=1e-7)


def test_refinement_beside_a_map_that_is_fine_everywhere(robot, mapped):
    refined = workspace_map(robot, spacing=4 * SPACING, refine=2)
    xr.testing.assert_equal(refined["y"], mapped["y"])
    level = refined["level"].values
    assert set(np.unique(level)) == {0, 1, 2}
    fine, whole = refined["semi_axis_max"].values, mapped["semi_axis_max"].values
    both = np.isfinite(fine) & np.isfinite(whole)
    # Where it is fine it is the same.
    same = both & (level == 2)
    np.testing.assert_allclose(fine[same], whole[same], rtol=1e-8)
    # A block's number is not far from those of the cells it stands for.
    assert np.max(np.abs(np.log(fine[both] / whole[both]))) < np.log(1.6)
    assert np.mean(np.isfinite(fine) == np.isfinite(whole)) > 0.99
    # Cells that were solved by themselves.
    blocks = sum(np.sum(level == k) / 4 ** (2 - k) for k in range(3))
    assert blocks < 0.6 * level.size
    for line in ("t1_line", "t2_line"):
        ends = [np.nanmax(m[line].values[..., 1]) for m in (refined, mapped)]
        assert ends[0] == pytest.approx(ends[1], abs=SPACING)


def test_limits_mark_cells_and_keep_their_numbers(robot):
    box = ((0.0, 0.15), (0.06, 0.25))
    free = workspace_map(robot, spacing=0.012, box=box)
    torque = np.max(np.abs(free["motor_torque"].values), axis=-1)
    limit = float(np.median(torque))
    limited = workspace_map(robot, spacing=0.012, box=box, limits=Limits(torque=limit))
    beyond = limited["status"].values == Status.BEYOND_LIMITS
    np.testing.assert_array_equal(beyond, torque > limit)
    assert 0 < beyond.sum() < beyond.size
    np.testing.assert_array_equal(limited["semi_axis_max"], free["semi_axis_max"])
    # Of each motor by itself.
    each = Limits(motors=(-np.inf, (2.2, np.inf)), torque=(np.inf, limit))
    limited = workspace_map(robot, spacing=0.012, box=box, limits=each)
    beyond = (np.abs(free["motor_torque"].values[..., 1]) > limit) | (free["q_a"][..., 0] > 2.2)
    np.testing.assert_array_equal(limited["status"].values == Status.BEYOND_LIMITS, beyond)
    stored = json.loads(limited.attrs["configuration"])["limits"]
    assert stored["torque"] == [np.inf, limit]


def test_the_dataset_is_labelled_and_survives_a_file(mapped, tmp_path):
    assert mapped["status"].dims == ("y", "z")
    assert mapped["t2_line"].dims == ("curve", "point", "axis")
    for name in mapped.data_vars:
        assert "long_name" in mapped[name].attrs, name
    save_dataset(mapped, tmp_path / "map.nc")
    with xr.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as again:
        xr.testing.assert_identical(again.load(), mapped)


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"spacing": -1.0}, "spacing"),
        ({"refine": -1}, "refine"),
        ({"steps": 0}, "steps"),
        ({"resume": True}, "out"),
        ({"refine": 1.5}, "refine"),
        ({"axes": ("y", "y")}, "axes"),
        ({"axes": ("y", "x")}, "axes"),
        ({"box": ((0.0, 0.0), (0.001, 0.001))}, "box"),
        ({"spacing": 1.0}, "spacing"),
        ({"box": ((0.0, 0.0), (np.inf, 0.1))}, "box"),
        ({"spacing": 1e-6}, "spacing"),
        ({"limits": {"torque": 1.0}}, "limits"),
        ({"parameters": ("nothing",)}, "parameters"),
    ],
)
def test_mistakes_are_named(robot, options, field):
    with pytest.raises(InputError, match=f"`{field}`"):
        workspace_map(robot, **options)


def test_a_box_in_millimetres_is_named(robot):
    with pytest.raises(InputError, match=r"`box` must lie beside the seed.* hardly are"):
        workspace_map(robot, spacing=10.0, box=((0.0, 0.0), (100.0, 200.0)))


def test_what_a_cell_is_does_not_depend_on_its_neighbours(robot, mapped):
    """Steep ways between coarse cells are followed as well as those between fine ones."""
    finer = workspace_map(robot, spacing=SPACING / 2)
    common = {
        name: [x for x in mapped[name].values if np.min(np.abs(finer[name].values - x)) < 1e-9]
        for name in ("y", "z")
    }
    some, same = (made.sel(common, method="nearest") for made in (mapped, finer))
    differ = some["status"].values != same["status"].values
    assert np.count_nonzero(differ) <= 3
    # Beside the seam a cell belongs to either sheet.
    away = ~differ & (some["status"].values == Status.SOLVED) & (some.y.values > 0.02)[:, None]
    assert np.count_nonzero(away) > 2500
    gap = np.max(np.abs(some["q_a"].values - same["q_a"].values)[away])
    assert gap < 1e-8


def test_without_uncertainties_all_but_the_sensitivities_is_there(robot):
    certain = dataclasses.replace(robot, uncertainty={})
    options = {"spacing": 0.06, "refine": 1}
    bare, full = workspace_map(certain, **options), workspace_map(robot, spacing=0.06)
    missing = {"semi_axis_max", "semi_axis_min", "ellipse_area", "direction", "Pi_p", "delta"}
    assert set(full.data_vars) - set(bare.data_vars) == missing
    coarse = bare.sel(y=full.y, z=full.z, method="nearest")
    for name in ("q_a", "energy", "sigma_t2", "status"):
        np.testing.assert_allclose(coarse[name], full[name], rtol=1e-9, atol=1e-12)
    assert [ax.get_title() for ax in figure_of_map(bare, robot).axes[:1]] == ["(a) dexterity"]
    with pytest.raises(InputError, match="`variable` must be one over y and z"):
        plot_map(bare)


def test_what_the_integration_leaves_is_told(robot, mapped):
    """Beside where tips end with four times the steps, which leave nothing."""
    assert float(mapped["tip_error"].max()) < 1e-8
    with pytest.warns(UserWarning, match=r"With 5 integration steps the tips .* `tip_error`"):
        rough = workspace_map(robot, spacing=0.03, box=((0.0, -0.06), (0.18, 0.24)), steps=5)
    solved = np.argwhere(rough["status"].values == Status.SOLVED)
    told, exact = [], []
    for i, j in solved[::4]:
        y = unknowns(rough, i, j)
        few, many = (integrated(robot, y, steps) for steps in (5, 20))
        apart = np.linalg.norm(few.tips.position - many.tips.position, axis=1) / 0.25
        told.append(float(rough["tip_error"][i, j]))
        exact.append(np.max(apart))
    assert len(told) > 10
    assert 1e-6 < np.max(exact) < 1e-3
    ratio = np.array(told) / np.array(exact)
    assert np.all((ratio > 0.1) & (ratio < 10.0))


def test_what_polishing_does_not_mend_is_no_solution(robot, monkeypatch):
    """With a tolerance that nothing meets, no cell is called solved and none has numbers."""
    from cpr_jax.studies import cells, workspace

    monkeypatch.setattr(workspace, "TOLERANCE", 0.0)
    monkeypatch.setattr(cells, "TOLERANCE", 0.0)
    dataset = workspace_map(robot, spacing=0.02, box=((0.0, 0.18), (0.06, 0.24)))
    assert np.all(dataset["status"].values == Status.NOT_CONVERGED)
    assert np.all(np.isnan(dataset["semi_axis_max"].values))
    assert np.all(dataset["index"].values == -1)


def test_limits_may_be_numbers_of_numpy():
    """A map keeps them as JSON."""
    limits = Limits(motors=np.array([-1.0, 4.0]), torque=np.float32(0.5), moment=np.int64(1))
    assert limits == Limits(motors=(-1.0, 4.0), torque=0.5, moment=1.0)
    assert Limits(motors=(np.zeros(2), 4)) == Limits(motors=((0.0, 0.0), 4.0))
    kinds = {type(value) for value in (*limits.motors, limits.torque, limits.moment)}
    assert kinds == {float}


def test_cells_at_the_edge_of_a_refined_map_are_close_by(robot):
    """Where the box ends within the workspace, between two cells of the coarse lattice."""
    box = ((0.02, 0.15), (0.105, 0.235))
    found = workspace_map(robot, spacing=0.01, refine=1, box=box)
    assert np.all(found["status"].values == Status.SOLVED)
    for k, name in enumerate(("y", "z")):
        away = np.abs(found["q_p"].values[..., k] - np.moveaxis(np.atleast_2d(found[name]), 1, k))
        assert np.max(away) < 0.01
