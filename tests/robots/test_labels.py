"""Labels of parameters mean the same in robot files and in the analysis."""

import numpy as np
import pytest

from cpr_jax.analysis.parameters import select
from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE, SPACE, AbstractGeometry
from cpr_jax.robots.labels import parameter_dimensions
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.robot import Robot, make_robot
from cpr_jax.robots.units import parse_quantity
from cpr_jax.rods.rod import kirchhoff_rod

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
