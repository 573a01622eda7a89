"""The workspace notebook runs from top to bottom, and ends with the right numbers."""

import json
import pathlib

import jax
import nbclient
import nbformat
import pytest

ROOT = pathlib.Path(__file__).parents[1]
NOTEBOOK = ROOT / "notebooks" / "workspace.ipynb"

_ASKED = """
import json
gaps = np.max(np.abs(others.y - np.asarray(home.y)), axis=1)
print(json.dumps({
    "indices": indices,
    "softest": softest,
    "heights": heights.tolist(),
    "crossing": crossing.tolist(),
    "share": share_stable,
    "home": float(gaps.min()),
    "limit": [limit.value, limit.before, limit.after],
}))
"""


@pytest.fixture(scope="module")
def numbers():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in notebook.cells)
    notebook.cells.append(nbformat.v4.new_code_cell(_ASKED))
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("MPLBACKEND", "agg")
        cache = jax.config.jax_compilation_cache_dir
        if cache:
            environment.setenv("JAX_COMPILATION_CACHE_DIR", str(cache))
        nbclient.NotebookClient(
            notebook,
            timeout=300,
            kernel_name="python3",
            resources={"metadata": {"path": str(ROOT / "notebooks")}},
        ).execute()
    return json.loads(notebook.cells[-1].outputs[0].text)


def test_stability_is_lost_where_the_stiffness_is(numbers):
    stable = [index == 0 for index in numbers["indices"]]
    assert stable == [stiffness > 0.0 for stiffness in numbers["softest"]]
    assert stable == [height > 0.0254775 for height in numbers["heights"]]


def test_the_line_is_where_it_was_measured(numbers):
    assert numbers["crossing"][0] == pytest.approx(0.05, abs=1e-9)
    assert numbers["crossing"][1] == pytest.approx(0.0254775, abs=1e-6)


def test_the_rest(numbers):
    assert 0.8 < numbers["share"] < 1.0
    assert numbers["home"] < 1e-8
    value, before, after = numbers["limit"]
    assert -5.0 < value < 1.0
    # The branch folds there: beyond it the robot snaps to another one.
    assert (before, after) == (0, -1)
