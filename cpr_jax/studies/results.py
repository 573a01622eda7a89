"""Labelled results and their files."""

import json
import operator
import os
import pathlib
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr

from ..atomic import write_atomically
from ..statics.status import Status
from .outcome import MonteCarlo
from .versions import versions


def samples_dataset(
    studies: Sequence[MonteCarlo],
    points: Sequence[str],
    units: Sequence[str],
    about: Mapping[str, object] | None = None,
) -> xr.Dataset:
    """The samples of several Monte Carlo studies of one robot as one labelled dataset.

    **Arguments:**

    - `points`: a name for each study, the coordinate `point`.
    - `units`: SI units of the platform coordinates.
    - `about`: further attributes, such as the robot's name and the seed.

    **Returns:**

    A dataset with dimensions point, sample, parameter, coordinate and axis.
    """
    first = studies[0]
    shortest = min(len(study.status) for study in studies)
    rows = first.sensitivity.rows
    n_p = first.q_p.shape[1]
    n_a = first.sensitivity.Pi_tau.shape[0]
    coordinates = list(rows[n_a : n_a + n_p])
    axes = list(first.ellipsoid.labels)

    def stack(get: Callable[[MonteCarlo], object]) -> np.ndarray:
        return np.stack([np.asarray(get(study)) for study in studies])

    def nominal(study: MonteCarlo) -> np.ndarray:
        return np.asarray(study.sensitivity.y)

    by_parameter = {"units": "see parameter_unit"}
    by_coordinate = {"units": "see coordinate_unit"}
    dataset = xr.Dataset(
        {
            "rho": (
                ("point", "sample", "parameter"),
                stack(lambda s: s.rho[:shortest]),
                by_parameter,
            ),
            "q_p": (
                ("point", "sample", "coordinate"),
                stack(lambda s: s.q_p[:shortest]),
                by_coordinate,
            ),
            "status": (
                ("point", "sample"),
                stack(lambda s: s.status[:shortest]).astype(np.int8),
                {
                    "flag_values": [int(status) for status in Status],
                    "flag_meanings": " ".join(status.name.lower() for status in Status),
                },
            ),
            "inside": (("point", "sample"), stack(lambda s: s.inside[:shortest])),
            "q_a": (("point", "motor"), stack(lambda s: nominal(s)[:n_a])),
            "nominal": (
                ("point", "coordinate"),
                stack(lambda s: nominal(s)[n_a : n_a + n_p]),
                by_coordinate,
            ),
            "delta": (("point", "parameter"), stack(lambda s: s.sensitivity.delta), by_parameter),
            "Pi": (
                ("point", "axis", "parameter"),
                stack(lambda s: s.sensitivity.Pi(s.ellipsoid.labels)),
            ),
            "semi_axes": (
                ("point", "rank"),
                stack(lambda s: s.ellipsoid.semi_axes),
                {"units": "m"},
            ),
            "directions": (("point", "rank", "axis"), stack(lambda s: s.ellipsoid.directions)),
            "coverage": (("point",), stack(lambda s: s.coverage)),
            "coverage_interval": (("point", "bound"), stack(lambda s: s.coverage_interval)),
            **{
                name: (("point",), stack(operator.attrgetter(name)))
                for name in ("samples", "solved", "lost", "failed")
            },
            "mean": (("point", "axis"), stack(lambda s: s.mean), {"units": "m"}),
            "covariance": (
                ("point", "axis", "other_axis"),
                stack(lambda s: s.covariance),
                {"units": "m^2"},
            ),
        },
        coords={
            "point": list(points),
            "parameter": list(first.sensitivity.columns),
            "parameter_unit": ("parameter", list(first.sensitivity.column_units)),
            "coordinate": coordinates,
            "coordinate_unit": ("coordinate", list(units)),
            "axis": axes,
            "other_axis": axes,
            "motor": list(rows[:n_a]),
            "bound": ["low", "high"],
        },
        attrs={
            "versions": json.dumps(versions()),
            "convention": "SI units, world axes",
            **(about or {}),
        },
    )
    return dataset


def save_dataset(
    dataset: xr.Dataset, path: str | os.PathLike, scratch: pathlib.Path | None = None
) -> None:
    """Writes a dataset as NetCDF, compressed, in one piece; `scratch` as in `write_atomically`."""
    packed = {
        name: {"zlib": True, "complevel": 4}
        for name, variable in dataset.data_vars.items()
        if variable.ndim and variable.dtype.kind in "fi"
    }

    def write(file: pathlib.Path) -> None:
        dataset.to_netcdf(file, engine="h5netcdf", encoding=packed)

    write_atomically(path, write, scratch)
