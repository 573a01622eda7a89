"""The command lines that the README shows are executed."""

import shlex

import pytest

from cpr_jax.cli import main
from tests.readme import ROOT, block


@pytest.mark.parametrize("line", block("cli").strip().splitlines())
def test_command_lines(line, capsys, monkeypatch, tmp_path):
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CPR_JAX_CACHE", "")
    program, *argv = shlex.split(line)
    assert program == "cpr-jax"
    assert main(argv) == 0
    assert capsys.readouterr().out
