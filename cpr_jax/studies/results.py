"""Labelled results and their files."""

import json
import operator
import os
import pathlib
from collections.abc import Callable, Mapping

import numpy as np
import xarray as xr

from ..atomic import write_atomically
from ..checks import check_kind
from ..errors import InputError
from ..statics.status import Status
from .outcome import MonteCarlo
from .parts import refuse_other
from .versions import versions


def samples_dataset(
    studies: MonteCarlo | Mapping[str, MonteCarlo], about: Mapping[str, object] | None = None
) -> xr.Dataset:
    """The samples of Monte Carlo studies of one robot as one labelled dataset.

    **Arguments:**

    - `studies`: one study, or several by the name of their point. Of each, the samples are taken
        that all of them have.
    - `about`: further attributes, such as the robot's name and the seed.

    **Returns:**

    A dataset with dimensions point, sample, parameter, coordinate and axis (SI units, world axes);
    `save_dataset` writes it.

    **Raises:** `InputError` for studies of different robots or parameters.
    """
    given = {"point": studies} if isinstance(studies, MonteCarlo) else studies
    check_kind("studies", given, Mapping, "a Monte Carlo study, or several by their names")
    _check_alike(given)
    several = list(given.values())
    first = several[0]
    shortest = min(len(study.status) for study in several)
    rows = first.sensitivity.rows
    n_p = first.q_p.shape[1]
    n_a = first.sensitivity.Pi_tau.shape[0]
    coordinates = list(rows[n_a : n_a + n_p])
    axes = list(first.ellipsoid.labels)
    units = ["m"] * len(axes) + ["rad"] * (n_p - len(axes))

    def stack(get: Callable[[MonteCarlo], object]) -> np.ndarray:
        return np.stack([np.asarray(get(study)) for study in several])

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
            "point": list(given),
            "parameter": list(first.sensitivity.columns),
            "parameter_unit": ("parameter", list(first.sensitivity.column_units)),
            "coordinate": coordinates,
            "coordinate_unit": ("coordinate", units),
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


def _check_alike(studies: Mapping[str, MonteCarlo]) -> None:
    if not studies:
        raise InputError("Argument `studies` must hold at least one study, but it is empty.")
    for name, study in studies.items():
        check_kind(f"studies[{name!r}]", study, MonteCarlo, "a Monte Carlo study")
    theories = [study.sensitivity for study in studies.values()]
    if len({(theory.rows, theory.columns) for theory in theories}) > 1:
        raise InputError(
            "Argument `studies` must be of one robot and of the same parameters, but they differ."
        )


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


def load_finished(path: pathlib.Path, configuration: dict) -> xr.Dataset | None:
    """A result that is there already.

    **Raises:** `InputError` where it is another one.
    """
    if not path.exists():
        return None
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        stored = json.loads(dataset.attrs.get("configuration", "{}"))
        refuse_other(stored, json.loads(json.dumps(configuration)), path.parent)
        return dataset.load()
