"""Mistakes on the command line: one line that names the field, exit code 2, before JAX."""

import os
import subprocess
import sys
import time

import pytest

from cpr_jax.cli import main

GOOD_POINT = ("--point", "0", "0.2")

MISTAKES = [
    (("solve", "nothing", *GOOD_POINT), "ROBOT"),
    (("solve", "nothing.toml", *GOOD_POINT), "nothing.toml"),
    (("solve", "/", *GOOD_POINT), "/"),
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
    ("argv", "code"), [(("--help",), 0), (("solve", "rfrfr", "--point", "0", "nan"), 2)]
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
