"""`cpr-jax validate`: a line for each robot file, exit code 2 for mistakes, no JAX."""

import json
import pathlib
import subprocess
import sys

import pytest

from cpr_jax.cli import main
from cpr_jax.robots.schema import schema_text
from tests.cli.common import run

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"

SUSPICIOUS = """
format = 1
name = "soft"
geometry = "plane"
motors = [[1, 2]]
[platform]
kind = "point"
[defaults.leg.rod]
length = "250 mm"
bending_stiffness = "1.83e-2 N*mm^2"
section = { kind = "rectangle", width = "2 mm", height = "10 mm" }
[[legs]]
base = [-0.1, 0]
[[legs]]
base = [0.1, 0]
"""


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A good file, a suspicious one and one with a mistake, in the working directory."""
    monkeypatch.chdir(tmp_path)
    good = (EXAMPLES / "stewart-gough.toml").read_text(encoding="utf-8")
    for name, text in (
        ("good", good),
        ("soft", SUSPICIOUS),
        ("bad", SUSPICIOUS.replace("250 mm", "250 N")),
    ):
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    return ["good.toml", "soft.toml", "bad.toml"]


def test_one_line_for_a_good_file(capsys, files):
    code, out, err = run(capsys, "validate", "good.toml")
    assert (code, err) == (0, "")
    assert out == "good.toml: ok, spatial, 6 legs, 6 motors, body platform\n"


def test_warnings_follow_their_file(capsys, files):
    code, out, err = run(capsys, "validate", "soft.toml", "good.toml")
    assert (code, err) == (0, "")
    first, warning, last = out.splitlines()
    assert first == "soft.toml: ok, planar, 2 legs, 1 motor, point platform"
    assert warning.startswith("soft.toml: warning: Argument `legs[0].rod.bending_stiffness`")
    assert last.startswith("good.toml: ok")


def test_mistakes_do_not_hide_other_files(capsys, files):
    code, out, err = run(capsys, "validate", "bad.toml", "missing.toml", "good.toml")
    assert code == 2
    assert out.startswith("good.toml: ok") and out.count("\n") == 1
    bad, missing = err.splitlines()
    assert bad.startswith("cpr-jax: error: bad.toml: Argument `defaults.leg.rod.length` must be")
    assert missing.startswith("cpr-jax: error: Argument `path` must be a robot file in TOML, but")


def test_json(capsys, files):
    code, out, err = run(capsys, "validate", *files, "--json")
    assert code == 2
    assert err.count("\n") == 1
    good, soft, bad = json.loads(out)
    assert good == {
        "file": "good.toml",
        "ok": True,
        "name": "continuum Stewart–Gough",
        "geometry": "space",
        "legs": 6,
        "motors": 6,
        "platform": "body",
        "warnings": [],
    }
    assert (soft["motors"], len(soft["warnings"])) == (1, 1)
    assert (bad["file"], bad["ok"]) == ("bad.toml", False)
    assert bad["error"] in err


def test_schema(capsys):
    code, out, err = run(capsys, "validate", "--schema")
    assert (code, out, err) == (0, schema_text(), "")


@pytest.mark.parametrize("argv", [(), ("--json",), ("x.toml", "--schema")], ids=" ".join)
def test_files_or_the_schema(capsys, argv):
    with pytest.raises(SystemExit) as exit_:
        main(["validate", *argv])
    assert exit_.value.code == 2
    assert "FILE" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("argv", "code"),
    [((str(EXAMPLES / "rfrfr.toml"),), 0), (("missing.toml",), 2), (("--schema",), 0)],
)
def test_jax_is_not_imported(argv, code):
    watch = (
        "import sys\nfrom cpr_jax.cli import main\ncode = main(['validate', *sys.argv[1:]])\n"
        "assert 'jax' not in sys.modules and 'numpy' not in sys.modules\nsys.exit(code)"
    )
    done = subprocess.run([sys.executable, "-c", watch, *argv], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr


def test_motors_of_a_robot_file_are_counted_by_motor(capsys, files):
    """The suspicious robot has two legs and one motor, which turns them."""
    for motors in (("1", "2"), ("1mm",)):
        code, out, err = run(capsys, "solve", "soft.toml", "--motors", *motors)
        assert (code, out) == (2, "")
        assert "Argument `--motors` must be" in err
