"""Commands as users call them: one JSON object, exit codes, no traceback."""

import json
import pathlib

import jax
import matplotlib.image
import numpy as np
import pytest
import xarray as xr

from cpr_jax.robots.names import CATALOGUE
from tests.cli.common import run

CASES = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())
EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


def test_solve_inverse_is_the_reference_case(capsys):
    code, out, err = run(capsys, "solve", "rfrfr", "--point", "0", "0.2", "--json")
    assert (code, err) == (0, "")
    answer = json.loads(out)
    expected = CASES["rfrfr_paper"]["inverse"]
    assert answer["status"] == "solved"
    assert answer["residual"] < 1e-10
    np.testing.assert_allclose(answer["q_a"], expected["q_rad"], rtol=1e-9)
    np.testing.assert_allclose(answer["q_p"], expected["point"], atol=1e-10)
    wrench = [*expected["n_1_base"], expected["m_1_base"]]
    np.testing.assert_allclose(answer["base_wrenches"][0], wrench, rtol=1e-9)
    assert len(answer["motor_torques"]) == 2


def test_solve_forward_and_a_robot_file(capsys):
    q_1, q_2 = CASES["rfrfr_paper"]["inverse"]["q_rad"]
    file = str(EXAMPLES / "rfrfr.toml")
    code, out, _ = run(capsys, "solve", file, "--motors", str(q_1), str(q_2), "--json")
    assert code == 0
    np.testing.assert_allclose(json.loads(out)["q_p"], (0.0, 0.2), atol=1e-9)


def test_steps_reach_every_solve(capsys, tmp_path):
    """Few of them are seen in a solve, and in what a map and a path tell of them."""
    case = "rfrfr", "--point", "0", "0.2", "--json"
    rough, fine = (json.loads(run(capsys, "solve", *case, "--steps", n)[1]) for n in "29")
    apart = np.abs(np.subtract(rough["q_a"], fine["q_a"]))
    assert 1e-9 < np.max(apart) < 1e-2
    exact = CASES["rfrfr_paper"]["inverse"]["q_rad"]
    np.testing.assert_allclose(fine["q_a"], exact, rtol=0, atol=1e-3 * np.max(apart))
    box = "--box", "0mm", "180mm", "60mm", "240mm", "--spacing", "20mm"
    path = "--via", "0", "200mm", "--via", "10mm", "200mm", "--spacing", "10mm"
    for command, options, name in (("workspace", box, "map"), ("trajectory", path, "trajectory")):
        out = tmp_path / command
        code, *_ = run(capsys, command, "rfrfr", *options, "--steps", "5", "--out", str(out))
        assert code == 0
        with xr.open_dataset(out / f"{name}.nc", engine="h5netcdf") as dataset:
            assert 1e-10 < float(dataset["tip_error"].max()) < 1e-5


@pytest.mark.parametrize(("command", "brief"), [("solve", True), ("monte-carlo", False)])
def test_commands_that_solve_once_wait_for_no_optimisations(capsys, command, brief):
    name = "jax_disable_most_optimizations"
    before = jax.config.read(name)
    try:
        jax.config.update(name, False)
        # What is refused is refused after that.
        code, *_ = run(capsys, command, "rfrfr", "--point", "0", "9")
        assert code == 3
        assert jax.config.read(name) == brief
    finally:
        jax.config.update(name, before)


def test_units_and_negative_quantities(capsys):
    code, out, _ = run(capsys, "solve", "rfrfr", "--point", "-50mm", "150 mm", "--json")
    assert code == 0
    np.testing.assert_allclose(json.loads(out)["q_p"], (-0.05, 0.15), atol=1e-12)


def test_sensitivity(capsys):
    code, out, _ = run(capsys, "sensitivity", "rfrfr", "--point", "0", "0.2", "--json")
    assert code == 0
    answer = json.loads(out)
    assert answer["parameters"] == ["k_b1", "r_c1", "k_b2", "r_c2"]
    np.testing.assert_allclose(answer["semi_axes"], CASES["rfrfr_paper"]["semi_axes_m"], rtol=2e-9)
    Pi, delta = np.array(answer["Pi_p"]), np.array(answer["delta"])
    kernel = np.array(answer["kernel"])
    # Across the axis of symmetry it is what rounding leaves of zero.
    rounding = 1e-15 * np.max(kernel)
    np.testing.assert_allclose((Pi * delta) @ (Pi * delta).T, kernel, rtol=1e-12, atol=rounding)
    assert np.shape(answer["platform_stiffness"]) == np.shape(answer["directions"]) == (2, 2)


def test_an_unstable_equilibrium_is_told_of(capsys):
    """Where rods of the paper's robot have buckled; at home they have not."""
    code, out, err = run(capsys, "sensitivity", "rfrfr", "--point", "50mm", "10mm", "--json")
    assert code == 0 and json.loads(out)["stability_index"] == 1
    assert "unstable in one direction" in err
    _, out, err = run(capsys, "sensitivity", "rfrfr", "--point", "0", "0.2", "--json")
    assert json.loads(out)["stability_index"] == 0 and err == ""


def test_sensitivity_with_the_platform_held_is_that_of_the_motors(capsys):
    held = "sensitivity", "rfrfr", "--point", "50mm", "0.15", "--hold", "platform"
    code, out, _ = run(capsys, *held, "--json")
    assert code == 0
    answer = json.loads(out)
    motors = np.array(answer["Pi_y"])[:2]
    code, out, _ = run(capsys, *held)
    assert code == 0 and "Pi_q (rows: q1, q2)" in out
    lines = [line.split() for line in out.splitlines()]
    shown = [[float(x) for x in line[1:3]] for line in lines if line[0] in answer["parameters"]]
    np.testing.assert_allclose(np.transpose(shown), motors, rtol=1e-6)
    radii = [float(line[1]) for line in lines if line[0] in ("q1", "q2")]
    np.testing.assert_allclose(radii, answer["tube_radius"][:2], rtol=1e-6)


def test_monte_carlo_with_a_file(capsys, tmp_path):
    target = tmp_path / "samples.nc"
    code, out, _ = run(
        capsys, "monte-carlo", "rfrfr", "--point", "0", "0.2", "--samples", "2000", "--seed", "0",
        "--out", str(target), "--json",
    )  # fmt: skip
    assert code == 0
    answer = json.loads(out)
    assert answer["samples"] == answer["solved"] == 2000
    assert answer["lost"] == 0
    low, high = answer["coverage_interval"]
    assert low < answer["coverage"] < high
    import xarray as xr

    with xr.open_dataset(target, engine="h5netcdf") as dataset:
        assert dataset.sizes["sample"] == 2000
        assert list(dataset.parameter.values) == answer["parameters"]
        assert float(dataset.inside.mean()) == answer["coverage"]
        assert (dataset.attrs["robot"], dataset.attrs["seed"]) == ("RFRFR", 0)
        assert int(dataset["solved"][0]) == 2000
        np.testing.assert_array_equal(dataset["mean"][0], answer["mean"])
        np.testing.assert_array_equal(dataset["covariance"][0], answer["covariance"])
    assert [path.name for path in tmp_path.iterdir()] == ["samples.nc"]


def test_monte_carlo_says_how_many_samples_it_writes(capsys, tmp_path):
    argv = ["monte-carlo", "rfrfr", "--point", "0", "0.2", "--samples", "300", "--keep", "100"]
    code, _, err = run(capsys, *argv, "--out", str(tmp_path / "some.nc"))
    assert code == 0
    assert "first 100 of 300 samples" in err
    import xarray as xr

    with xr.open_dataset(tmp_path / "some.nc", engine="h5netcdf") as dataset:
        assert dataset.sizes["sample"] == 100
        assert int(dataset["samples"][0]) == 300
    code, _, err = run(capsys, *argv, "--out", str(tmp_path))
    assert code == 2
    assert "`--out` must be a file" in err
    assert [path.name for path in tmp_path.iterdir()] == ["some.nc"]


def test_text_output_names_what_it_prints(capsys):
    for command in ("solve", "sensitivity"):
        code, out, _ = run(capsys, command, "rfrfr", "--point", "0", "0.2")
        assert code == 0
        assert "RFRFR" in out


def test_unreachable_point_is_exit_code_3(capsys):
    code, out, err = run(capsys, "solve", "rfrfr", "--point", "0", "2", "--json")
    assert code == 3
    assert json.loads(out)["status"] == "out_of_reach"
    assert err.count("\n") == 1
    assert "Traceback" not in err
    code, _, err = run(capsys, "solve", "rfrfr", "--point", "0", "200")
    assert code == 3
    assert "Positions are in metres" in err


def test_a_map_of_a_robot_without_a_home_needs_a_beginning(capsys, tmp_path):
    """The message names what the command has."""
    text = (EXAMPLES / "rfrfr.toml").read_text()
    begin, home, rest = text.partition("[home]")
    bare = begin + rest[rest.index("[defaults.leg]") :]
    assert home
    file = tmp_path / "robot.toml"
    file.write_text(bare)
    code, _, err = run(capsys, "workspace", str(file), "--out", str(tmp_path / "map"))
    assert code == 2
    assert "`--point` or `--motors` must" in err and err.count("\n") == 1


def test_robots(capsys):
    code, out, _ = run(capsys, "robots", "--json")
    assert code == 0
    listed = json.loads(out)
    assert listed.keys() == CATALOGUE.keys()
    assert listed["stewart-gough"]["motors"] == ["feed"] * 6
    plane, space = run(capsys, "robots")[1].split("space:\n")
    assert plane.startswith("plane:\n")
    for name, entry in listed.items():
        assert f"  {name} " in (plane if entry["geometry"] == "plane" else space)
    assert "6 feed motors, body platform; Till" in space


def test_figure_of_robots(capsys, tmp_path, monkeypatch):
    """One file; a figure whose robots are those of the catalogue, here of two of them."""
    two = {name: CATALOGUE[name] for name in ("rfrfr", "three-rfs")}
    monkeypatch.setattr("cpr_jax.cli.gallery.CATALOGUE", two)
    target = tmp_path / "new" / "robots.png"
    code, out, _ = run(capsys, "robots", "--figure", str(target), "--json")
    assert (code, json.loads(out)) == (0, {"robots": list(two), "files": [str(target)]})
    assert [path.name for path in target.parent.iterdir()] == ["robots.png"]
    pixels = matplotlib.image.imread(target)
    assert pixels.shape[1] == pytest.approx(300 * 7.16, abs=2)
    upper, lower = np.array_split(pixels[..., :3], 2)
    assert upper.std() > 0.05 and lower.std() > 0.05


def test_workspace(capsys, tmp_path):
    """A small map: its summary agrees with its file, and a second run resumes to the same."""
    out = str(tmp_path / "map")
    argv = ["workspace", "rfrfr", "--out", out, "--spacing", "24mm", "--json"]
    argv += ["--box", "0", "150mm", "60mm", "0.25", "--refine", "1"]
    code, printed, _ = run(capsys, *argv)
    assert code == 0
    answer = json.loads(printed)
    assert answer["solved"] == answer["cells"] == sum(answer["status"].values())
    files = sorted(path.name for path in (tmp_path / "map").iterdir())
    assert files == ["map.nc", "map.pdf", "map.png"]
    assert sorted(answer["files"]) == sorted(str(tmp_path / "map" / name) for name in files)
    with xr.open_dataset(tmp_path / "map" / "map.nc", engine="h5netcdf") as dataset:
        assert dataset.sizes["y"] * dataset.sizes["z"] == answer["cells"]
        low, high = answer["semi_axis_max"]
        assert float(dataset["semi_axis_max"].min()) == low
        assert float(dataset["semi_axis_max"].max()) == high
    code, again, _ = run(capsys, *argv, "--resume")
    assert (code, again) == (0, printed)


def test_workspace_over_a_length_and_an_angle(capsys, tmp_path):
    out = str(tmp_path / "map")
    argv = ["workspace", "three-rfr", "--axes", "z,phi_P_x", "--spacing", "20mm", "5deg"]
    argv += ["--box", "-20mm", "-5deg", "20mm", "5deg", "--out", out, "--json"]
    code, printed, _ = run(capsys, *argv)
    assert code == 0
    answer = json.loads(printed)
    assert (answer["axes"], answer["axis_units"]) == (["z", "phi_P_x"], ["m", "rad"])
    assert answer["spacing"] == pytest.approx([0.02, np.deg2rad(5.0)])
    assert answer["solved"] == answer["cells"] == 9


@pytest.mark.parametrize(
    ("options", "field"),
    [
        (["--spacing", "0"], "--spacing"),
        (["--refine", "two"], "--refine"),
        (["--refine", "9"], "refine"),
        (["--spacing", "2s"], "--spacing"),
        (["--box", "0", "0", "1mm", "1mm"], "box"),
        (["--max-torque", "-1"], "--max-torque"),
    ],
)
def test_workspace_names_mistakes(capsys, tmp_path, options, field):
    code, out, err = run(capsys, "workspace", "rfrfr", "--out", str(tmp_path / "m"), *options)
    assert (code, out) == (2, "")
    assert field in err


@pytest.mark.parametrize(
    "argv",
    [
        ("paper",),
        ("workspace", "rfrfr", "--spacing", "20mm"),
        ("monte-carlo", "rfrfr", "--point", "0", "0.2"),
    ],
    ids=lambda argv: argv[0],
)
def test_a_place_that_cannot_be_written_is_refused(capsys, tmp_path, argv):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    code, out, err = run(capsys, *argv, "--out", str(blocked / "x"))
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert "--out" in err and "file" in err
