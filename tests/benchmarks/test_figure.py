"""The figure of a run."""

import matplotlib.image
import pytest

from benchmarks.figure import draw

SIX_LEGS = {"six legs": {"cpr_jax": [(0.0, 2e-4)], "C++": [(0.0, 1e-4)]}}


def run_of(*series):
    return {"tasks": {f"task {k}": {"series": each} for k, each in enumerate(series)}}


@pytest.mark.parametrize("series", [[SIX_LEGS], [{}, SIX_LEGS]])
def test_what_was_measured_is_drawn(tmp_path, series):
    draw(run_of(*series), tmp_path / "picture")
    picture = matplotlib.image.imread(tmp_path / "picture.png")
    assert picture[..., :3].min() < 0.5


@pytest.mark.parametrize("series", [[], [{}]])
def test_tasks_without_curves_make_no_picture(tmp_path, series):
    draw(run_of(*series), tmp_path / "picture")
    assert list(tmp_path.iterdir()) == []
