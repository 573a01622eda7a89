"""`cpr-jax paper`: one folder with figures, samples and a report whose numbers agree."""

import json

import numpy as np
import pytest
import xarray as xr

from cpr_jax.plotting.paper_folder import make_paper


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    make_paper(folder, samples=500, seed=1)
    return folder


def test_files(folder):
    names = {path.name for path in folder.iterdir()}
    figures = {f"figure-{k}.{ending}" for k in (1, 2, 3) for ending in ("pdf", "png")}
    assert names == figures | {"samples.nc", "map.nc", "report.json", "report.md"}
    assert all((folder / name).stat().st_size > 10_000 for name in figures)


def test_figures_are_journal_sized(folder):
    import matplotlib.image

    for name, width in (("figure-1", 3.5), ("figure-2", 7.16)):
        pixels = matplotlib.image.imread(folder / f"{name}.png")
        assert pixels.shape[1] == pytest.approx(300 * width, abs=2)
        # Neither blank nor cut: ink inside, a white rim outside.
        assert pixels[..., :3].std() > 0.05
        for rim in (pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]):
            assert np.all(rim[..., :3] == 1.0)


def test_report_agrees_with_the_samples(folder):
    report = json.loads((folder / "report.json").read_text())
    with xr.open_dataset(folder / "samples.nc", engine="h5netcdf") as data:
        for k, name in enumerate(data.point.values):
            nominal = data.nominal[k].values
            offset = data.q_p[k].values - nominal
            axes = data.directions[k].values / data.semi_axes[k].values[:, None]
            inside = np.sum((offset @ axes.T) ** 2, axis=1) <= 1.0
            assert np.mean(inside) == report["coverage"][name] == float(data.coverage[k])
            lost = data.status[k].values == 4
            assert np.sum(lost) == report["lost"][name]
        assert list(data.parameter_unit.values) == ["N m^2", "m"] * 2


def test_report_lists_the_claims(folder):
    report = json.loads((folder / "report.json").read_text())
    text = (folder / "report.md").read_text()
    assert len(report["claims"]) == 11
    for claim in report["claims"]:
        assert claim["claim"] in text
        assert claim["computed"] in text
    agreeing = [claim["agrees"] for claim in report["claims"]]
    assert agreeing == [True] * 4 + [False] * 3 + [True] * 4
