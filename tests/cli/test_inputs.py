"""Mistakes on the command line: one line that names the field, exit code 2, before JAX."""

import math
import os
import subprocess
import sys
import time

import pytest

from cpr_jax.cli import main
from cpr_jax.cli.inputs import check
from cpr_jax.cli.map_inputs import check_map
from cpr_jax.cli.parser import build_parser

GOOD_POINT = ("--point", "0", "0.2")

MISTAKES = [
    (("solve", "nothing", *GOOD_POINT), "ROBOT"),
    (("solve", "nothing.toml", *GOOD_POINT), "nothing.toml"),
    (("solve", "/", *GOOD_POINT), "/"),
    (("solve", "rfrfr", *GOOD_POINT, "--steps", "0"), "--steps"),
    (
        ("trajectory", "rfrfr", "--via", "0", "0.2", "--via", "0", "0.1", "--steps", "2.5"),
        "--steps",
    ),
    (("solve", "rfrfr", "--point", "0"), "--point"),
    (("solve", "rfrfr", "--point", "0", "0.2", "0"), "--point"),
    (("solve", "rfrfr", "--point", "0", "nan"), "--point"),
    (("solve", "rfrfr", "--point", "0", "inf"), "--point"),
    (("solve", "rfrfr", "--point", "0", "-inf"), "--point"),
    (("solve", "rfrfr", "--point", "0", "20N"), "--point"),
    (("solve", "rfrfr", "--point", "0", "20 deg"), "--point"),
    (("solve", "rfrfr", "--point", "0", "far"), "--point"),
    (("solve", "rfrfr", "--point", "0", ""), "--point"),
    (("solve", "rfrfr", "--motors", "1"), "--motors"),
    (("solve", "rfrfr", "--motors", "1", "2mm"), "--motors"),
    (("solve", "three-rfr", "--point", "0", "0"), "--point"),
    (("solve", "three-rfr", "--point", "0", "0", "1mm"), "--point"),
    (("solve", "three-pfr", "--motors", "0", "0", "1deg"), "--motors"),
    (("solve", "stewart-gough", "--motors", *["1deg"] * 6), "--motors"),
    (("solve", "stewart-gough", "--point", "0", "0", "400mm", "0", "10deg"), "--point"),
    (("solve", "stewart-gough", "--point", "0", "0", "400mm", "0", "10mm", "0"), "--point"),
    (("solve", "three-rfs", "--point", "0", "0", "0.28"), "--imposed"),
    (("solve", "three-rfs", "--point", "0", "0", "--imposed", "x,y"), "--imposed"),
    (("solve", "three-rfs", "--point", "0", "0", "0", "--imposed", "x,y,w"), "--imposed"),
    (("solve", "three-rfs", "--point", "0", "0", "0", "--imposed", "x,y,y"), "--imposed"),
    (("solve", "three-rfs", "--point", "0", "0", "2mm", "--imposed", "x,y,phi_P_z"), "--point"),
    (("solve", "three-rfs", "--point", "0", "0", "--imposed", "x,y,z"), "--point"),
    (("solve", "three-rfs", "--motors", "1", "1", "1", "--imposed", "x,y,z"), "--imposed"),
    (("sensitivity", "three-rfs", "--motors", *"111", "--hold", "platform"), "--hold"),
    (("sensitivity", "rfrfr", *GOOD_POINT, "--delta", "k_b1=1e-3", "k_b1=2e-3"), "--delta"),
    (("workspace", "three-rfs"), "--imposed"),
    (("workspace", "three-rfs", "--imposed", "x,y,phi_P_z"), "--imposed"),
    (("workspace", "three-rfs", "--imposed", "x,y,z", "--axes", "x,phi_P_z"), "--imposed"),
    (("workspace", "stewart-gough", "--axes", "x"), "--axes"),
    (("workspace", "stewart-gough", "--axes", "x,x"), "--axes"),
    (("workspace", "stewart-gough", "--axes", "x,q1"), "--axes"),
    (("workspace", "stewart-gough", "--axes", "x,y", "--spacing", "1deg"), "--spacing"),
    (("workspace", "stewart-gough", "--axes", "z,phi_P_x", "--spacing", "1mm"), "--spacing"),
    (("workspace", "stewart-gough", "--spacing", "1mm", "1mm", "1mm"), "--spacing"),
    (("workspace", "three-rfr", "--axes", "z,phi_P_x", "--box", *["1mm"] * 4), "--box"),
    (("workspace", "three-pfr", "--max-torque", "1 N*m"), "--max-torque"),
    (("robots", "--figure", "catalogue.svg"), "--figure"),
    (("sensitivity", "rfrfr", *GOOD_POINT, "--parameters", "k_b3"), "--parameters"),
    (("sensitivity", "rfrfr", *GOOD_POINT, "--parameters", "stiffness"), "--parameters"),
    (("sensitivity", "rfrfr", *GOOD_POINT, "--delta", "k_b1"), "--delta"),
    (("sensitivity", "rfrfr", *GOOD_POINT, "--delta", "k_b1=-1"), "--delta k_b1"),
    (("sensitivity", "rfrfr", *GOOD_POINT, "--delta", "k_b1=1mm"), "--delta k_b1"),
    (("sensitivity", "rfrfr", *GOOD_POINT, "--delta", "k_b9=1"), "--delta"),
    (("monte-carlo", "rfrfr", *GOOD_POINT, "--samples", "0"), "--samples"),
    (("monte-carlo", "rfrfr", *GOOD_POINT, "--samples", "1.5"), "--samples"),
    (("monte-carlo", "rfrfr", *GOOD_POINT, "--samples", "many"), "--samples"),
    (("monte-carlo", "rfrfr", *GOOD_POINT, "--seed", "-1"), "--seed"),
    (("monte-carlo", "rfrfr", *GOOD_POINT, "--keep", "0"), "--keep"),
    (("monte-carlo", "rfrfr", *GOOD_POINT, "--resume"), "--resume"),
    (("paper", "--samples", "nan"), "--samples"),
    (("paper", "--seed", "x"), "--seed"),
]


@pytest.mark.parametrize(("argv", "field"), MISTAKES, ids=lambda value: str(value)[:60])
def test_one_line_and_exit_code_2(capsys, argv, field):
    assert main(argv) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("cpr-jax: error: Argument")
    assert "must" in err
    assert field in err


def request_of(*argv):
    return check(build_parser().parse_args(argv))


def test_values_are_those_of_the_imposed_coordinates():
    given = request_of("solve", "stewart-gough", "--point", *"00", "400mm", "0", "10deg", "0")
    assert given.imposed is None
    assert given.point == pytest.approx((0.0, 0.0, 0.4, 0.0, math.pi / 18.0, 0.0))
    named = ("--imposed", "p_P_z, phi_P_y,q2", "--point", "280mm", "5deg", "80deg")
    given = request_of("sensitivity", "three-rfs", *named)
    assert given.imposed == ("z", "phi_P_y", "q2")
    assert given.point == pytest.approx((0.28, math.pi / 36.0, math.pi / 2.25))
    assert request_of("solve", "three-rfs", "--motors", *"111").imposed is None


def test_maps_have_lengths_and_angles_as_their_axes_do():
    def options(*argv):
        arguments = build_parser().parse_args(["workspace", *argv])
        return check_map(arguments, check(arguments))

    mixed = options(
        "three-rfr", "--axes", "z,phi_P_x", "--spacing", "5mm", "2deg",
        "--box", " -10mm", " -10deg", "10mm", "10deg", "--max-torque", "1 N*mm",
    )  # fmt: skip
    assert mixed.axes == ("z", "phi_P_x")
    assert mixed.spacing == pytest.approx((5e-3, math.pi / 90.0))
    assert mixed.box[0] == pytest.approx((-0.01, -math.pi / 18.0))
    assert mixed.box[1] == pytest.approx((0.01, math.pi / 18.0))
    assert mixed.max_torque == pytest.approx(1e-3)
    angles = options("stewart-gough", "--axes", "phi_P_x,phi_P_y", "--spacing", "2deg")
    assert angles.spacing == pytest.approx((math.pi / 90.0,))
    sliding = options("three-pfr", "--spacing", "5mm", "4mm", "--max-torque", "2N")
    assert (sliding.axes, sliding.spacing, sliding.max_torque) == (None, (0.005, 0.004), 2.0)


def test_what_to_name_is_said(capsys):
    main(("solve", "three-rfs", "--point", "0", "0", "0.28"))
    _, err = capsys.readouterr()
    assert "must name 3 of the 6 platform coordinates (x, y, z, phi_P_x, phi_P_y, phi_P_z)" in err


@pytest.mark.parametrize(
    "argv",
    [
        (),
        ("solve",),
        ("solve", "rfrfr"),
        ("solve", "rfrfr", *GOOD_POINT, "--motors", "1", "2"),
        ("solve", "rfrfr", *GOOD_POINT, "--jsn"),
        ("sensitivity", "rfrfr", *GOOD_POINT, "--hold", "everything"),
        ("monte-carlo", "rfrfr", *GOOD_POINT, "--distribution", "normal"),
        ("fly",),
    ],
    ids=lambda value: " ".join(value)[:60],
)
def test_unknown_options_and_commands(capsys, argv):
    with pytest.raises(SystemExit) as exit_:
        main(argv)
    assert exit_.value.code == 2
    assert "error" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("argv", "code"),
    [
        (("--help",), 0),
        (("robots",), 0),
        (("solve", "rfrfr", "--point", "0", "nan"), 2),
        (("solve", "three-rfs", "--point", "0", "0", "0"), 2),
        (("workspace", "stewart-gough", "--axes", "x,q1"), 2),
        (("robots", "--figure", "catalogue.svg"), 2),
    ],
)
def test_help_and_errors_come_without_jax(argv, code):
    watch = (
        "import sys\nfrom cpr_jax.cli import main\n"
        "try:\n    code = main(sys.argv[1:])\nexcept SystemExit as end:\n    code = end.code\n"
        "assert 'jax' not in sys.modules and 'numpy' not in sys.modules\nsys.exit(code)"
    )
    done = subprocess.run([sys.executable, "-c", watch, *argv], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr


def test_python_dash_m():
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "cpr_jax", "--version"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONWARNINGS": "error"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("cpr-jax ")
    # Generous for a busy machine; importing JAX alone takes longer than half of this.
    assert time.perf_counter() - start < 2.0
