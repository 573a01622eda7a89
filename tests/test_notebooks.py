"""The notebooks run from top to bottom, and end with the right numbers."""

import json
import pathlib

import nbformat
import pytest

from tests.notebook_runner import NOTEBOOKS, executed

ROOT = pathlib.Path(__file__).parents[1]
REFERENCE = json.loads((ROOT / "tests" / "reference_cases.json").read_text())["rfrfr_paper"]

_ASKED = """
import json
print(json.dumps({
    "q_a": equilibrium.q_a.tolist(),
    "semi_axes": ellipse.semi_axes.tolist(),
    "share": share,
    "coverage": {name: study.coverage for name, study in studies.items()},
    "unsolved": {name: study.lost + study.failed for name, study in studies.items()},
    "linear": linear.coverage_interval,
    "held": abs(held.Pi_p).max().item(),
    "gradient": {label: slope.item() for label, slope in gradient.items()},
    "axes": [before.item(), after.item()],
    "three": region.semi_axes.tolist(),
}))
"""


@pytest.fixture(scope="module")
def notebook():
    return executed("paper.ipynb", _ASKED)


@pytest.fixture(scope="module")
def numbers(notebook):
    return json.loads(notebook.cells[-1].outputs[0].text)


def test_no_cell_fails(notebook):
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.execution_count for cell in code)
    assert not [o for cell in code for o in cell.outputs if o.output_type == "error"]


@pytest.mark.parametrize("path", sorted(NOTEBOOKS.glob("*.ipynb")), ids=lambda path: path.stem)
def test_stored_without_outputs(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in notebook.cells)


def test_equilibrium_and_ellipse(numbers):
    assert numbers["q_a"] == pytest.approx(REFERENCE["inverse"]["q_rad"], rel=1e-9)
    assert numbers["semi_axes"] == pytest.approx(REFERENCE["semi_axes_m"], rel=1e-8)
    assert numbers["share"] > 0.999
    assert numbers["held"] < 1e-12


def test_monte_carlo(numbers):
    coverage, unsolved = numbers["coverage"], numbers["unsolved"]
    assert all(0.97 < coverage[name] < 0.989 for name in "ABC")
    assert coverage["D"] < 0.9
    assert [unsolved[name] for name in "ABC"] == [0, 0, 0]
    assert unsolved["D"] > 0
    low, high = numbers["linear"]
    assert low < 0.9888910034617577 < high


def test_beyond_the_paper(numbers):
    # Central differences of the semi-axis over 0.02 mm.
    slopes = {"l": 0.07003744, "a": -0.02141627, "b": 0.06651890, "d": -0.02205837}
    assert numbers["gradient"] == pytest.approx(slopes, rel=1e-6)
    before, after = numbers["axes"]
    assert before == pytest.approx(REFERENCE["semi_axes_m"][0], rel=1e-8)
    assert after < 0.9 * before
    assert numbers["three"] == pytest.approx([0.81267e-3, 0.65524e-3], rel=1e-4)
