"""What commands say when they end, before they are done or in a process of their own."""

import importlib
import json
import subprocess
import sys

import pytest

from tests.cli.common import run


@pytest.mark.parametrize(
    ("argv", "part"),
    [
        (("workspace", "rfrfr", "--out", "map"), "map/parts/chunk-0.npz"),
        (
            ("monte-carlo", "rfrfr", "--point", "0", "0.2", "--out", "cloud.nc"),
            "cloud.nc.parts/parts-0/window-0.npz",
        ),
    ],
)
def test_what_can_be_resumed_is_said(tmp_path, monkeypatch, capsys, argv, part):
    def interrupted(arguments):
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(importlib.import_module("cpr_jax.cli.main"), "_run", interrupted)
    assert run(capsys, *argv) == (130, "", "cpr-jax: error: interrupted\n")
    (tmp_path / part).parent.mkdir(parents=True)
    (tmp_path / part).touch()
    code, _, err = run(capsys, *argv)
    assert code == 130 and "--resume goes on" in err


def started(*argv):
    """A command in a process of its own, whose output goes into pipes."""
    command = [sys.executable, "-m", "cpr_jax", *argv]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_a_process_ends_with_all_that_it_has_said():
    """It leaves at once, without the interpreter's own end, which would write what is left."""
    schema = started("validate", "--schema")
    wrong = started("solve", "rfrfr", "--point", "0", "up")
    out, err = schema.communicate()
    assert (schema.returncode, err) == (0, "") and "properties" in json.loads(out)
    out, err = wrong.communicate()
    assert (wrong.returncode, out) == (2, "") and err.count("\n") == 1


def test_a_reader_may_have_enough():
    schema = started("validate", "--schema")
    schema.stdout.close()
    assert schema.stderr.read() == ""
    assert schema.wait() == 0
    schema.stderr.close()
