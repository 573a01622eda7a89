"""The trajectory command: what it writes, what it says, and how it ends."""

import csv
import json

import numpy as np
import pytest
import xarray as xr

import cpr_jax as cpr
from tests.cli.common import run

VIA = ("--via", "0", "200mm", "--via", "20mm", "0.2", "--via", "20mm", "150mm")


def test_a_path_and_its_files(capsys, tmp_path):
    out = tmp_path / "path"
    code, text, err = run(
        capsys, "trajectory", "rfrfr", *VIA, "--spacing", "10mm", "--out", str(out), "--json"
    )
    assert (code, err) == (0, "")
    answer = json.loads(text)
    assert (answer["stops"], answer["solved"], answer["events"]) == (8, 8, [])
    assert answer["length"] == answer["reached"] == pytest.approx(0.07)
    ends = ("csv", "nc", "pdf", "png")
    assert sorted(path.name for path in out.iterdir()) == [f"trajectory.{end}" for end in ends]
    with xr.open_dataset(out / "trajectory.nc", engine="h5netcdf") as dataset:
        dataset.load()
    with (out / "trajectory.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["s", "p_P_y", "p_P_z", "q1", "q2", "tau1", "tau2", "stable"]
    for k, row in enumerate(rows):
        motors = [float(row["q1"]), float(row["q2"])]
        np.testing.assert_allclose(motors, dataset["q_a"].values[k], rtol=1e-11)
    places = [[float(row["p_P_y"]), float(row["p_P_z"])] for row in rows]
    np.testing.assert_allclose(places[0::2][:2], [(0.0, 0.2), (0.02, 0.2)], atol=1e-12)
    assert answer["torque_max"] == pytest.approx(float(abs(dataset["motor_torque"]).max()))


def test_waypoints_of_a_file_are_those_of_the_options(capsys, tmp_path):
    file = tmp_path / "way.csv"
    file.write_text(
        '# a path\nz; "p_P_y"; q9\n200 mm; 0;1\n\n0.2 , 0.02 ,2 # right\n150mm;20 mm;\n'
    )
    answers = []
    for way in (("--file", str(file)), VIA):
        out = str(tmp_path / "path")
        _, text, _ = run(
            capsys, "trajectory", "rfrfr", *way, "--spacing", "10mm", "--out", out, "--json"
        )
        answers.append(json.loads(text))
    assert answers[0] == answers[1]


def test_a_table_that_was_written_is_a_file_of_waypoints(capsys, tmp_path):
    out, again = tmp_path / "path", tmp_path / "again"
    run(capsys, "trajectory", "rfrfr", *VIA, "--spacing", "10mm", "--out", str(out))
    table = out / "trajectory.csv"
    code, _, _ = run(capsys, "trajectory", "rfrfr", "--file", str(table), "--out", str(again))
    assert code == 0
    ones, others = (np.genfromtxt(path, delimiter=",", skip_header=1) for path in (
        table, again / "trajectory.csv"
    ))  # fmt: skip
    np.testing.assert_allclose(others[:: len(others) // 7], ones, atol=1e-9)


def test_a_path_that_ends_has_its_files_and_exit_code_3(capsys, tmp_path):
    out = tmp_path / "path"
    code, text, err = run(
        capsys, "trajectory", "rfrfr", "--via", "0", "0.2", "--via", "0.4", "0.2",
        "--spacing", "10mm", "--out", str(out),
    )  # fmt: skip
    assert code == 3
    assert "end (out_of_reach)" in text and (out / "trajectory.nc").exists()
    assert err.startswith("cpr-jax: error: RFRFR: the path ends at 0.162")


def test_waypoints_alone(capsys, tmp_path):
    out = tmp_path / "way"
    code, _, _ = run(
        capsys, "trajectory", "rfrfr", *VIA, "--spacing", "inf", "--out", str(out), "--json"
    )
    assert code == 0
    table = np.genfromtxt(out / "trajectory.csv", delimiter=",", skip_header=1)
    assert len(table) == VIA.count("--via")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--via", "0", "0.2"), "`--via` must give two waypoints or more"),
        (("--via", "0", "0.2", "--via", "0.1"), "`--via` must be 2 numbers"),
        ((*VIA, "--spacing", "0"), "`--spacing`"),
        ((*VIA, "--spacing", "1deg"), "`--spacing`"),
        ((*VIA, "--imposed", "q1"), "`--imposed` must name 2 coordinates"),
        (("--file", "none.csv"), "`--file` must be a file of waypoints, but 'none.csv' is not"),
        ((*VIA, "--max-torque", "-1"), "`--max-torque`"),
    ],
)
def test_mistakes_are_named_before_anything_is_computed(capsys, arguments, message):
    code, out, err = run(capsys, "trajectory", "rfrfr", *arguments)
    assert (code, out) == (2, "")
    assert message in err and len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("q1,z\n0,0.2\n0,0.1\n", "must have columns y, z, but line 1"),
        ("0,0.2\n", "`--file` must give two waypoints or more"),
        ("0,0.2\n0,here\n", "`--file, line 2`"),
        ("0,0.2,1\n0,0.1\n", "`--file, line 1` must be 2 numbers"),
        ("0,,0.2\n0,0.1\n", "`--file, line 1` must be 2 numbers"),
        ("z,y\n0.2,0\n0.1\n", "`--file, line 3` must be 2 numbers"),
        ("", "`--file` must give two waypoints or more"),
    ],
)
def test_mistakes_in_a_file_are_named_with_their_line(capsys, tmp_path, text, message):
    file = tmp_path / "way.csv"
    file.write_text(text)
    code, out, err = run(capsys, "trajectory", "rfrfr", "--file", str(file))
    assert (code, out) == (2, "")
    assert message in err


@pytest.fixture(scope="module")
def mapped(tmp_path_factory):
    """A folder with a map, as `cpr-jax workspace` writes it."""
    folder = tmp_path_factory.mktemp("mapped")
    cpr.workspace_map(cpr.rfrfr(), spacing=0.02, out=folder)
    return folder


AROUND = ("--via", "0", "60mm", "--via", "130mm", "-50mm", "--spacing", "10mm")


def test_a_way_is_planned_on_a_map(capsys, tmp_path, mapped):
    """Straight on the robot would cross the T2 line; around it nothing happens."""
    answers = {}
    for name, plan in (("straight", ()), ("around", ("--plan", str(mapped)))):
        out = str(tmp_path / name)
        code, text, _ = run(capsys, "trajectory", "rfrfr", *AROUND, *plan, "--out", out, "--json")
        assert code == 0
        answers[name] = json.loads(text)
    assert "unstable" in [event["event"] for event in answers["straight"]["events"]]
    assert answers["around"]["events"] == []
    assert answers["around"]["length"] > 1.2 * answers["straight"]["length"]
    with xr.open_dataset(mapped / "map.nc", engine="h5netcdf") as dataset:
        way = cpr.plan_path(dataset.load(), (0.0, 0.06), (0.13, -0.05))
    assert answers["around"]["length"] == pytest.approx(way.length)


def test_a_plan_begins_on_the_branch_of_its_map(capsys, tmp_path):
    """That map is of an elbow the other way than at home."""
    robot, folder = cpr.rfrfr(), str(tmp_path / "map")
    q_a = (-0.52601294, 1.04145282)
    seed = cpr.solve_forward(robot, q_a)
    box = ((-0.02, 0.16), (0.08, 0.22))
    cells = cpr.workspace_map(robot, seed, spacing=0.02, box=box, out=folder)
    path = str(tmp_path / "path")
    ways = "--via", "0", "200mm", "--via", "60mm", "180mm", "--spacing", "20mm"
    code, _, err = run(capsys, "trajectory", "rfrfr", *ways, "--plan", folder, "--out", path)
    assert code == 0, err
    with xr.open_dataset(tmp_path / "path" / "trajectory.nc", engine="h5netcdf") as dataset:
        first = dataset["q_a"].values[0]
    cell = cells["q_a"].sel(y=0.0, z=0.2, method="nearest")
    assert np.max(np.abs(first - cell)) < 0.05


TURNING = ("--imposed", "q1,q2", "--via", "0", "1", "--via", "1", "2")


@pytest.mark.parametrize(
    ("robot", "arguments", "place", "message"),
    [
        ("rfrfr", AROUND, "parts", "must be a folder that `cpr-jax workspace` has written"),
        ("rfrfr-straight", AROUND, ".", "must be a map of straight RFRFR as it is now"),
        ("rfrfr", TURNING, ".", "must be a map over q1, q2"),
        ("rfrfr", (*AROUND, "--via", "0", "5"), ".", "must be on the map, whose z goes from"),
    ],
)
def test_mistakes_of_a_plan_are_named(capsys, mapped, robot, arguments, place, message):
    folder = str(mapped / place)
    code, out, err = run(capsys, "trajectory", robot, *arguments, "--plan", folder)
    field = "`--via`" if "on the map" in message else "`--plan`"
    assert (code, out) == (2, "")
    assert f"{field} {message}" in err and len(err.splitlines()) == 1
