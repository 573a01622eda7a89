"""Result files: whole or absent, labelled, readable by others."""

import math

import numpy as np
import xarray as xr

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
