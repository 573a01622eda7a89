"""How figures are saved."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from cpr_jax.plotting.style import journal_style, save_figure


def counted(monkeypatch, owner, name):
    """The calls of a method from here on."""
    calls, method = [], getattr(owner, name)

    def call(self, *args):
        calls.append(args)
        return method(self, *args)

    monkeypatch.setattr(owner, name, call)
    return calls


@pytest.mark.parametrize("dpi", [300, "figure"])
def test_all_files_show_one_layout(tmp_path, monkeypatch, dpi):
    """Each file is drawn once, and the layout, which takes as long, is found once."""
    layouts = counted(monkeypatch, ConstrainedLayoutEngine, "execute")
    draws = counted(monkeypatch, Figure, "draw")
    with journal_style(), plt.rc_context({"savefig.dpi": dpi}):
        figure, ax = plt.subplots(figsize=(2.0, 1.0))
        ax.set_ylabel("a label that\nneeds room")
        usual = ax.get_position().bounds
        paths = save_figure(figure, tmp_path / "file", ("pdf", "png", "svg"))
        assert figure.dpi == plt.rcParams["figure.dpi"]
    assert [path.stat().st_size > 1000 for path in paths] == [True] * 3
    assert (len(layouts), len(draws)) == (1, 3)
    assert not np.allclose(ax.get_position().bounds, usual)
    height = plt.imread(paths[1]).shape[0]
    assert height == (300 if dpi == 300 else 100)


def test_a_figure_without_a_layout_stays_as_it_is(tmp_path):
    figure, ax = plt.subplots(layout="none")
    places = ax.get_position().bounds
    save_figure(figure, tmp_path / "file")
    assert ax.get_position().bounds == places
