"""What is said of commands that end before they are done."""

import importlib

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
