"""The spatial notebook runs from top to bottom, and ends with the right numbers."""

import json

import numpy as np
import pytest
from scipy.stats import chi2

from tests.notebook_runner import executed

_ASKED = """
import json
middle = dataset.sel(x=0.0, z=0.4, method="nearest")
print(json.dumps({
    "index": int(judged.index),
    "stiffness": stiffness.tolist(),
    "compliance": compliance.tolist(),
    "directions": np.asarray(orientation.directions).tolist(),
    "kernel": np.asarray(position.kernel).tolist(),
    "covariance": np.asarray(study.covariance).tolist(),
    "study": [study.coverage, study.lost, study.failed],
    "shown": [trace.name for trace in view.data],
    "shape": list(dataset["index"].shape),
    "stable": int((dataset["index"] == 0).sum()),
    "motors": [middle["q_a"].values.tolist(), equilibrium.q_a.tolist()],
    "largest": [middle["semi_axis_max"].item(), position.semi_axes[0].item()],
}))
"""


@pytest.fixture(scope="module")
def numbers():
    return json.loads(executed("spatial.ipynb", _ASKED).cells[-1].outputs[0].text)


def test_the_stiffness_is_that_of_a_stable_conservative_robot(numbers):
    stiffness, compliance = np.array(numbers["stiffness"]), np.array(numbers["compliance"])
    size = np.sqrt(np.diag(stiffness))
    scaled = stiffness / np.outer(size, size)
    np.testing.assert_allclose(scaled, scaled.T, rtol=0, atol=1e-8)
    assert np.all(np.linalg.eigvalsh(scaled) > 0.0)
    assert numbers["index"] == 0
    product = compliance @ stiffness * np.outer(size, 1.0 / size)
    np.testing.assert_allclose(product, np.eye(6), rtol=0, atol=1e-8)


def test_the_softest_turn_is_the_most_uncertain(numbers):
    """Both are the twist about z, nearly; the platform moves least along z."""
    moves, turns = (np.array(numbers["compliance"])[k : k + 3, k : k + 3] for k in (0, 3))
    assert np.argmin(np.diag(moves)) == 2
    softest = np.linalg.eigh(0.5 * (turns + turns.T))[1][:, -1]
    assert abs(softest[2]) > 0.95
    assert abs(numbers["directions"][0][2]) > 0.95


def test_the_cloud_is_that_of_the_ellipsoid(numbers):
    coverage, lost, failed = numbers["study"]
    assert coverage == pytest.approx(chi2.cdf(9.0, 3), abs=0.012)
    assert (lost, failed) == (0, 0)
    # A parameter has the standard deviation δ/3. 2,000 samples tell a variance to some 3 %.
    values, vectors = np.linalg.eigh(np.array(numbers["kernel"]))
    spread = np.diag(vectors.T @ np.array(numbers["covariance"]) @ vectors)
    np.testing.assert_allclose(9.0 * spread, values, rtol=0.15)
    assert {"rods", "platform", "ellipsoid × 20", "samples inside"} <= set(numbers["shown"])


def test_the_slice_goes_through_the_pose(numbers):
    assert numbers["shape"] == [7, 5]
    assert numbers["stable"] == 35
    here, solved = numbers["motors"]
    np.testing.assert_allclose(here, solved, rtol=0, atol=1e-9)
    assert numbers["largest"][0] == pytest.approx(numbers["largest"][1], rel=1e-6)
