"""Maps over three coordinates, of a robot with fewer motors than its platform has freedoms."""

import dataclasses
import json
import types

import numpy as np
import pytest
import xarray as xr

import cpr_jax as cpr
from cpr_jax.statics.status import Status
from cpr_jax.studies import volume as volumes
from cpr_jax.studies.workspace import workspace_map

IMPOSED = ("x", "y", "z")
BOX = ((-0.02, -0.01), (0.02, 0.01))


@pytest.fixture(scope="module")
def robot():
    return cpr.three_rfs()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("volume")


@pytest.fixture(scope="module")
def volume(robot, folder):
    """Two slices within reach and one beyond it."""
    return cpr.workspace_volume(
        robot, [0.26, 0.28, 0.5], imposed=IMPOSED, box=BOX, spacing=0.01, out=folder
    )


def test_one_file_is_left_with_all_units(volume, folder):
    assert [path.name for path in folder.iterdir()] == ["volume.nc"]
    with xr.open_dataset(folder / "volume.nc", engine="h5netcdf") as stored:
        xr.testing.assert_identical(stored.load()["q_p"], volume["q_p"])
        for axis in "xyz":
            assert stored[axis].attrs["units"] == "m"
    for cut, labels in ((volume.isel(y=0), ("z", "x")), (volume.isel(z=0), ("x", "y"))):
        ax = cpr.plot_map(cut)
        for label, name in zip((ax.get_xlabel(), ax.get_ylabel()), labels, strict=True):
            assert name in label and "(mm)" in label


def test_a_cell_has_the_numbers_of_a_single_solve(robot, volume):
    cell = volume.isel(z=1, y=0, x=0)
    point = [float(cell[axis]) for axis in "xyz"]
    alone = cpr.solve_inverse(robot, point, imposed=IMPOSED)
    assert np.linalg.norm(alone.q_p[3:]) > 0.01, "or the platform is not tilted"
    np.testing.assert_allclose(cell["q_p"], alone.q_p, rtol=0, atol=1e-8)
    for name in ("sigma_t2", "energy"):
        assert float(cell[name]) == pytest.approx(float(getattr(alone.measures, name)), rel=1e-6)


def test_an_interrupted_volume_goes_on(robot, volume, tmp_path, monkeypatch):
    made = []

    def interrupted(*arguments, **options):
        if made:
            raise KeyboardInterrupt
        made.append(workspace_map(*arguments, **options))
        return made[0]

    needs = {"imposed": IMPOSED, "box": BOX, "spacing": 0.01, "out": tmp_path}
    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(cpr.studies.volume, "workspace_map", interrupted)
        cpr.workspace_volume(robot, [0.26, 0.28, 0.5], **needs)
    with pytest.raises(ValueError, match=r"`resume` .* 1 finished part would be lost"):
        cpr.workspace_volume(robot, [0.26, 0.28, 0.5], **needs)
    again = cpr.workspace_volume(robot, [0.26, 0.28, 0.5], resume=True, **needs)
    xr.testing.assert_identical(again, volume)


def test_a_finished_volume_is_taken_up_and_no_other_written_over(
    robot, volume, folder, monkeypatch
):
    def made(*arguments, **options):
        raise AssertionError("nothing is to be computed")

    monkeypatch.setattr(cpr.studies.volume, "workspace_map", made)
    needs = {"imposed": IMPOSED, "box": BOX, "out": folder, "resume": True}
    again = cpr.workspace_volume(robot, [0.26, 0.28, 0.5], spacing=0.01, **needs)
    xr.testing.assert_identical(again, volume)
    for heights, spacing in (([0.26], 0.01), ([0.26, 0.28, 0.5], 0.02)):
        with pytest.raises(cpr.InputError, match="`resume` must go on with the same"):
            cpr.workspace_volume(robot, heights, spacing=spacing, **needs)


def test_whatever_may_be_given_can_be_stored(robot):
    """And is known to be so before anything is computed, not when all is to be written."""
    known = types.MappingProxyType({"k_b1": 1e-3})
    seed = cpr.solve_inverse(robot, (0.0, 0.0, 0.28), imposed=IMPOSED)
    given = {"delta": known, "parameters": known.keys(), "box": np.array(BOX), "resume": True}
    options = volumes._configuration(robot, seed, np.ones(1), ["x"], (0,), given)["options"]
    assert json.loads(json.dumps(options)) == {
        "delta": {"k_b1": 1e-3},
        "parameters": ["k_b1"],
        "box": [list(corner) for corner in BOX],
        "limits": None,
    }


def test_each_slice_belongs_to_its_height(robot, volume):
    """A cell is an equilibrium there: solved by itself it is the same one."""
    assert volume["status"].dims == ("z", "x", "y")
    assert np.all(volume["status"].sel(z=[0.26, 0.28]) == Status.SOLVED)
    cell = volume.sel(z=0.26).isel(x=-1, y=0)
    target = (float(cell.x), float(cell.y), 0.26)
    np.testing.assert_allclose(cell["q_p"].values[:3], target, rtol=0, atol=1e-12)
    alone = cpr.solve_inverse(robot, target, imposed=IMPOSED)
    np.testing.assert_allclose(alone.q_a, cell["q_a"].values, rtol=0, atol=1e-8)
    np.testing.assert_allclose(alone.q_p, cell["q_p"].values, rtol=0, atol=1e-8)
    axes = cpr.ellipsoid(cpr.sensitivity(robot, alone)).semi_axes
    assert float(cell["semi_axis_max"]) == pytest.approx(float(axes[0]), rel=1e-6)


def test_a_slice_whose_grid_is_apart_is_not_reached(robot, tmp_path):
    """At the axis the platform can be higher than beside it, where these slices are."""
    box = ((0.05, -0.01), (0.07, 0.01))
    beside = cpr.workspace_volume(
        robot, [0.25, 0.29], imposed=IMPOSED, box=box, spacing=0.01, out=tmp_path
    )
    alone = cpr.solve_inverse(robot, (0.0, 0.0, 0.29), imposed=IMPOSED, throw=False)
    assert int(alone.status) == Status.SOLVED
    assert np.all(beside["status"].sel(z=0.29) != Status.SOLVED)
    assert np.any(beside["status"].sel(z=0.25) == Status.SOLVED)
    assert [path.name for path in tmp_path.iterdir()] == ["volume.nc"]


def test_slices_of_a_robot_without_uncertainties_are_stacked():
    certain = dataclasses.replace(cpr.three_rfr(), uncertainty={})
    axes, box = ("y", "z", "phi_P_x"), ((-0.02, -0.02), (0.02, 0.02))
    long = ("p_P_y", "p_P_z", "phi_P_x")
    made = cpr.workspace_volume(certain, [0.0, 0.1], axes=long, box=box, spacing=0.02)
    assert made["status"].dims == (axes[2], *axes[:2])
    assert made["phi_P_x"].attrs["units"] == "rad"
    assert "delta" not in made and "Pi_p" not in made
    assert np.all(made["status"] == Status.SOLVED)
    assert np.all(np.isfinite(made["sigma_t2"]))


def test_a_slice_out_of_reach_says_so(volume):
    far = volume.sel(z=0.5)
    assert np.all(far["status"] == Status.BEYOND_FOLD)
    assert np.all(np.isnan(far["semi_axis_max"])) and np.all(far["index"] == -1)


def test_bad_input(robot):
    with pytest.raises(ValueError, match="`heights` must be ascending"):
        cpr.workspace_volume(robot, [0.3, 0.2], imposed=IMPOSED, box=BOX)
    for heights in ([np.nan], "ab"):
        with pytest.raises(ValueError, match="`heights` must be ascending"):
            cpr.workspace_volume(robot, heights, imposed=IMPOSED, box=BOX)
    with pytest.raises(ValueError, match="`limits` must be"):
        cpr.workspace_volume(robot, [0.3], imposed=IMPOSED, box=BOX, limits={"torque": 1})
    with pytest.raises(ValueError, match="`box` must be given"):
        cpr.workspace_volume(robot, [0.3], imposed=IMPOSED)
    with pytest.raises(ValueError, match="`imposed` must contain the third axis"):
        cpr.workspace_volume(robot, [0.3], imposed=("x", "y", "phi_P_z"), box=BOX)
    for axes in (("x", "y", "p_P_y"), ("x", "y")):
        with pytest.raises(ValueError, match="`axes` must name three coordinates"):
            cpr.workspace_volume(robot, [0.3], axes=axes, imposed=IMPOSED, box=BOX)
    with pytest.raises(ValueError, match="name 3 of them"):
        cpr.workspace_map(robot)
    with pytest.raises(ValueError, match="`imposed` must contain the axes"):
        cpr.workspace_map(robot, imposed=("z", "phi_P_x", "phi_P_y"), axes=("x", "y"))


def test_a_seed_is_an_equilibrium_of_the_robot(robot):
    lost = cpr.solve_inverse(robot, (0.0, 0.0, 9.0), imposed=IMPOSED, throw=False)
    with pytest.raises(ValueError, match="`seed` must be solved"):
        cpr.workspace_volume(robot, [0.3], lost, imposed=IMPOSED, box=BOX)
    other = cpr.solve_inverse(cpr.rfrfr(), (0.0, 0.2))
    with pytest.raises(ValueError, match="`seed` must be an equilibrium of a robot like"):
        cpr.workspace_volume(robot, [0.3], other, imposed=IMPOSED, box=BOX)
