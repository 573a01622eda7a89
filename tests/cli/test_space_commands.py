"""Commands for bodies in space, for fewer motors than coordinates, and for passive joints."""

import json
import re

import numpy as np
import pytest

from tests.cli.common import run

IMPOSED = ("three-rfs", "--point", "5mm", "0", "0.28", "--imposed", "x,y,z")


def test_imposed_coordinates(capsys):
    """Three motors put a body at a position; its orientation follows."""
    code, out, err = run(capsys, "solve", *IMPOSED, "--json")
    assert (code, err) == (0, "")
    answer = json.loads(out)
    np.testing.assert_allclose(answer["q_p"][:3], (0.005, 0.0, 0.28), atol=1e-12)
    assert answer["motor_units"] == ["rad"] * 3
    assert np.shape(answer["base_wrenches"]) == (3, 6)
    motors = [str(q) for q in answer["q_a"]]
    code, out, _ = run(capsys, "solve", "three-rfs", "--motors", *motors, "--json")
    assert code == 0
    np.testing.assert_allclose(json.loads(out)["q_p"], answer["q_p"], atol=1e-9)
    code, out, _ = run(capsys, "solve", *IMPOSED)
    assert code == 0
    assert re.search(r"phi_P_y +-?\d\S* rad\n", out)
    # Three motors and six coordinates: there is no distance to a Type 1 singularity.
    assert "sigma_t1" not in out and "sigma_t2" in out and "\n\n" not in out


def test_ellipsoids_of_position_and_orientation(capsys):
    code, out, _ = run(capsys, "sensitivity", *IMPOSED, "--json")
    assert code == 0
    answer = json.loads(out)
    turn = answer["orientation"]
    assert (answer["semi_axes_unit"], turn["semi_axes_unit"]) == ("m", "rad")
    assert turn["rows"] == ["turn_P_x", "turn_P_y", "turn_P_z"]
    delta = np.array(answer["delta"])
    for matrix, ellipsoid in ((answer["Pi_p"], answer), (answer["Pi_turn"], turn)):
        kernel = (np.array(matrix) * delta) @ (np.array(matrix) * delta).T
        np.testing.assert_allclose(kernel, ellipsoid["kernel"], rtol=1e-9, atol=1e-18)
        lengths = np.sqrt(np.linalg.eigvalsh(kernel))[::-1]
        np.testing.assert_allclose(lengths, ellipsoid["semi_axes"], rtol=1e-6)
    code, out, _ = run(capsys, "sensitivity", *IMPOSED)
    assert code == 0
    for name, unit, axes in (
        ("semi-axis", "mm along", answer["semi_axes"]),
        ("turn", "mrad about", turn["semi_axes"]),
    ):
        printed = re.findall(rf"^{name} +(\S+) {unit} \[", out, re.MULTILINE)
        np.testing.assert_allclose(
            [float(text) for text in printed], 1e3 * np.array(axes), atol=1e-4
        )


def test_monte_carlo_in_space_has_the_linear_coverage_of_three_dimensions(capsys):
    code, out, _ = run(capsys, "monte-carlo", *IMPOSED, "--samples", "200", "--json")
    assert code == 0
    answer = json.loads(out)
    assert answer["linear_coverage"] == pytest.approx(0.970709, abs=1e-6)
    assert len(answer["semi_axes"]) == len(answer["orientation"]["semi_axes"]) == 3
    # One uncertain number has an ellipsoid of one dimension.
    code, out, _ = run(
        capsys, "monte-carlo", "rfrfr", "--point", "0", "0.2", "--samples", "100",
        "--parameters", "k_b1",
    )  # fmt: skip
    assert code == 0
    assert "linear theory 99.73%" in out


CRANKS = """
format = 1
name = "cranks"
geometry = "plane"
[platform]
kind = "point"
force = [0, 0.5]
[home]
motors = ["100 deg", "80 deg"]
position = [0, 0.25]
[defaults.leg]
base_joint = { joint = "pivot", position = ["50 mm", 0] }
[defaults.leg.rod]
length = "250 mm"
bending_stiffness = "1.83e-2 N*m^2"
[[legs]]
base = [-0.1, 0]
rod.precurvature = -1
[[legs]]
base = [0.1, 0]
rod.precurvature = 1
"""


def test_a_robot_with_passive_joints_shows_its_base_wrenches(capsys, tmp_path):
    """Its unknowns are motions of the joints and components along their axes."""
    file = tmp_path / "cranks.toml"
    file.write_text(CRANKS, encoding="utf-8")
    argv = ("solve", str(file), "--motors", "100deg", "80deg")
    expected = json.loads(run(capsys, *argv, "--json")[1])["base_wrenches"]
    code, out, _ = run(capsys, *argv)
    assert code == 0
    assert re.search(r"eta1_3 +\S+ rad\n", out)
    printed = re.findall(r"[nm]\d_[yzx] +(\S+) N(?: m)? at the base of rod \d\n", out)
    np.testing.assert_allclose(np.array(printed, float), np.ravel(expected), rtol=1e-8, atol=1e-12)
