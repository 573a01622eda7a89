"""What the README shows is executed."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest

import cpr_jax
from tests.readme import README, ROOT, block, code_of, printed_arrays


def test_python_block(capsys):
    exec(block("python") + block("python-map"), {})
    printed = capsys.readouterr().out.splitlines()
    assert any(line.endswith("cells are stable") for line in printed)
    axes = [float(number) for number in printed[1].strip("[]").split()]
    assert axes == pytest.approx([5.50e-3, 1.41e-3], rel=5e-3)
    coverage = float(printed[2].split()[0])
    assert coverage == pytest.approx(0.975, abs=0.005)


def test_python_block_of_paths_and_designs(capsys, tmp_path, monkeypatch):
    """On a coarser map than the README's; the figure of the documentation is made as it says."""
    monkeypatch.chdir(tmp_path)
    robot = cpr_jax.rfrfr()
    dataset = cpr_jax.workspace_map(robot, spacing=0.02)
    names = {"cpr": cpr_jax, "robot": robot, "dataset": dataset}
    exec(block("python-plan"), names)
    assert capsys.readouterr().out.startswith("[]\n{'l': 0.19")
    better = names["better"]
    assert better.converged and np.min(better.slack) > -1e-6
    assert better.objective == pytest.approx(0.7 * better.history[0][1], rel=0.02)
    page = (ROOT / "docs" / "planning.md").read_text()
    exec(code_of(page, "figure"), names)
    assert (tmp_path / "path.png").exists()
    straight = cpr_jax.trajectory(robot, names["way"].points[[0, -1]])
    assert [event["event"] for event in cpr_jax.events(straight)] == ["unstable", "stable"]
    plt.close("all")


def test_python_block_in_space(capsys):
    exec(block("python-space"), {"cpr": cpr_jax})
    lines = [np.array(line.strip("[]").split(), float) for line in printed_arrays(capsys)]
    lengths, position, orientation, pose = lines
    # The pose is its own mirror image, and so are the legs.
    np.testing.assert_allclose(lengths, lengths[[1, 0, 5, 4, 3, 2]], rtol=0, atol=1e-7)
    np.testing.assert_allclose(1e3 * position, (1.71, 1.62, 0.21), rtol=0, atol=0.01)
    np.testing.assert_allclose(1e3 * orientation, (13.6, 3.6, 3.5), rtol=0, atol=0.05)
    np.testing.assert_allclose(pose[:3], (0.005, 0.0, 0.28), rtol=0, atol=1e-8)


def test_links_exist():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        if not target.startswith("http"):
            assert (ROOT / target).exists(), target


def test_commands_use_what_is_installed():
    """The two commands name an extra and an entry point that pyproject.toml defines."""
    project = (ROOT / "pyproject.toml").read_text()
    assert "cpr-jax paper" in block("paper")
    assert 'cpr-jax = "cpr_jax.cli:command"' in project
    assert "'.[test]'" in block("test")
    assert re.search(r"^test = \[", project, re.MULTILINE)
