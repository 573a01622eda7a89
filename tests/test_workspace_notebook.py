"""The workspace notebook runs from top to bottom, and ends with the right numbers."""

import json

import pytest

from tests.notebook_runner import executed

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
    "around": cpr.events(around),
    "straight": cpr.events(straight),
    "worst": float(around["semi_axis_max"].max()),
    "limit": [limit.value, limit.before, limit.after],
}))
"""


@pytest.fixture(scope="module")
def numbers():
    return json.loads(executed("workspace.ipynb", _ASKED).cells[-1].outputs[0].text)


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


def test_the_way_around_is_stable_and_the_straight_one_is_not(numbers):
    assert numbers["around"] == []
    assert [event["event"] for event in numbers["straight"]] == ["unstable", "stable"]
    assert numbers["worst"] < 0.06
