"""Result files: whole or absent, labelled, readable by others."""

import math

import numpy as np
import pytest
import xarray as xr

import cpr_jax as cpr
from cpr_jax.plain import plain
from cpr_jax.studies.results import save_dataset


def test_dataset_round_trip(tmp_path):
    dataset = xr.Dataset(
        {"x": (("a", "b"), np.random.default_rng(0).normal(size=(3, 4)), {"units": "m"})},
        coords={"a": ["p", "q", "r"]},
        attrs={"note": "ü"},
    )
    save_dataset(dataset, tmp_path / "deep" / "file.nc")
    with xr.open_dataset(tmp_path / "deep" / "file.nc", engine="h5netcdf") as loaded:
        xr.testing.assert_identical(loaded.load(), dataset)


def test_plain_is_json(tmp_path):
    value = {"a": np.array([1.0, math.nan]), "b": (np.float64(2), np.int8(3)), "c": math.inf}
    assert plain(value) == {"a": [1.0, None], "b": [2.0, 3], "c": None}


def test_samples_of_studies_by_the_names_of_their_points():
    robot = cpr.rfrfr()
    points = {"A": (0.0, 0.2), "B": (0.05, 0.15)}
    studies = {
        name: cpr.monte_carlo(robot, cpr.solve_inverse(robot, point), samples)
        for (name, point), samples in zip(points.items(), (60, 40), strict=True)
    }
    dataset = cpr.samples_dataset(studies, {"robot": robot.name})
    assert dict(dataset.sizes) | {"point": 2, "sample": 40} == dict(dataset.sizes)
    np.testing.assert_array_equal(dataset["q_p"].sel(point="B"), studies["B"].q_p)
    np.testing.assert_allclose(dataset["nominal"], [*points.values()], atol=1e-9)
    assert list(dataset["coordinate_unit"].values) == ["m", "m"]
    alone = cpr.samples_dataset(studies["A"])
    assert alone.sizes["sample"] == 60 and alone["point"].values.tolist() == ["point"]

    other = cpr.monte_carlo(robot, cpr.solve_inverse(robot, (0.0, 0.2)), 40, parameters=("k_b1",))
    mistakes = {
        "must be of one robot": {**studies, "C": other},
        "must hold at least one": {},
        "several by their names": [studies["A"]],
        r"studies\['A'\]` must be a Monte Carlo study": {"A": 1.0},
    }
    for message, given in mistakes.items():
        with pytest.raises(cpr.InputError, match=message):
            cpr.samples_dataset(given)
