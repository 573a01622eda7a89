"""Labels of parameters mean the same in robot files and in the analysis."""

import tomllib

import numpy as np
import pytest

from cpr_jax.analysis.parameters import select
from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE, SPACE, AbstractGeometry
from cpr_jax.robots.labels import is_part_of, parameter_dimensions
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.reading import parse_specification
from cpr_jax.robots.robot import Robot, make_robot
from cpr_jax.robots.units import parse_quantity
from cpr_jax.rods.rod import kirchhoff_rod
from tests.robots.documents import DOCUMENTS

WHOLE = ("k_b", "k_t", "k_2", "k_3", "r_c")

LABELS = {
    *(
        f"{name}{i}"
        for name in ("k_b", "k_t", "k_2", "k_3", "r_c", "kappa", "l", "a", "b")
        for i in ("", *range(4))
    ),
    *(f"{name}{i}_{axis}" for name in ("base", "f") for i in range(4) for axis in "xyz"),
    *(f"{name}_{axis}" for name in ("f_P", "m_P") for axis in "xyz"),
}


def two_legs(geometry: AbstractGeometry) -> Robot:
    """A robot that has a number for each of its labels."""
    zero = np.zeros(geometry.d)
    leg = make_leg(geometry, zero, kirchhoff_rod(geometry, 1.0, 1.0, 1.0, force=zero), a=1.0, b=1.0)
    return make_robot(geometry, [leg, leg], oriented=True)


@pytest.mark.parametrize("geometry", [PLANE, SPACE], ids=lambda geometry: geometry.name)
def test_labels_are_those_of_the_analysis(geometry: AbstractGeometry) -> None:
    robot = two_legs(geometry)
    units = {}
    for label in LABELS:
        try:
            units[label] = select(robot, [label]).units[0]
        except InputError:
            continue
    dimensions = parameter_dimensions(geometry.name, [1, 1])
    assert set(units) == set(dimensions)
    for label, unit in units.items():
        assert parse_quantity(f"1 {unit}", dimensions[label], label) == 1.0


@pytest.mark.parametrize("geometry", [PLANE, SPACE], ids=lambda geometry: geometry.name)
def test_what_stands_for_all_legs_is_told_from_its_label(geometry: AbstractGeometry) -> None:
    """As the analysis tells it from the numbers themselves."""
    robot = two_legs(geometry)
    labels = list(parameter_dimensions(geometry.name, [1, 1]))
    of_all = [label for label in labels if not any(c in label for c in "_12") or label in WHOLE]
    for whole in of_all:
        for label in labels:
            if label == whole:
                continue
            try:
                select(robot, [whole, label])
                same = False
            except InputError:
                same = True
            assert (is_part_of(label, whole) or is_part_of(whole, label)) == same, (whole, label)


@pytest.mark.parametrize(
    ("labels", "text"),
    [
        (("kb1",), r"`uncertainty` .* 'kb1' is none; did you mean 'k_b1'"),
        (("l7",), r"`uncertainty` .* 2 legs .* 'l7' is none"),
        (("l1", "l"), r"`uncertainty` must leave 'l1' out beside 'l'"),
    ],
)
def test_a_robot_made_in_python_has_half_ranges_of_what_it_has(labels, text) -> None:
    rod = kirchhoff_rod(PLANE, 0.25, 0.02)
    legs = [make_leg(PLANE, (y, 0.0), rod) for y in (-0.1, 0.1)]
    with pytest.raises(InputError, match=text):
        make_robot(PLANE, legs, oriented=False, uncertainty=dict.fromkeys(labels, 1e-3))
    make_robot(PLANE, legs, oriented=False, uncertainty={"l1": 1e-3, "legs.a[0, 0]": 1e-3})


def test_a_file_names_no_number_twice() -> None:
    document = tomllib.loads(DOCUMENTS["point"])
    document["uncertainty"] |= {"k_b": 1e-3}
    with pytest.raises(InputError, match=r"`uncertainty.k_b1` must be left out beside `k_b`"):
        parse_specification(document)
