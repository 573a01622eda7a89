"""Quantities with units. Pure Python: nothing here imports jax."""

import math

import pytest

from cpr_jax.errors import InputError, shown
from cpr_jax.robots import units
from cpr_jax.robots.units import Dimension, Sign, parse_quantity

GOOD = [
    (units.LENGTH, 0.25, 0.25),
    (units.LENGTH, 3, 3.0),
    (units.LENGTH, "0.25", 0.25),
    (units.LENGTH, "200mm", 0.2),
    (units.LENGTH, "200 mm", 0.2),
    (units.LENGTH, "  -.5\tcm ", -0.005),
    (units.LENGTH, "1.1 mm", 0.0011),
    (units.LENGTH, "216.50635094610968 mm", 0.21650635094610968),
    (units.LENGTH, "1e3 um", 1e-3),
    (units.LENGTH, "1 µm", 1e-6),
    (units.LENGTH, "5. km", 5000.0),
    (units.LENGTH, "−2 m", -2.0),
    (units.LENGTH, "+2e+0 m", 2.0),
    (units.ANGLE, "180 deg", math.pi),
    (units.ANGLE, "45°", math.pi / 4.0),
    (units.ANGLE, "500 mrad", 0.5),
    (units.FORCE, "500 mN", 0.5),
    (units.FORCE, "1 kN", 1000.0),
    (units.FORCE, "2 kg m/s^2", 2.0),
    (units.MOMENT, "10 N*mm", 0.01),
    (units.MOMENT, "1 Nm", 1.0),
    (units.MOMENT, "1 mNm", 0.001),
    (units.MOMENT, "1 J", 1.0),
    (units.BENDING_STIFFNESS, "1.83e-2 N*m^2", 0.0183),
    (units.BENDING_STIFFNESS, "1.83e-2 N·m²", 0.0183),
    (units.BENDING_STIFFNESS, "1.83e-2 N m**2", 0.0183),
    (units.BENDING_STIFFNESS, "1.83e-2 N*mm^2", 1.83e-8),
    (units.BENDING_STIFFNESS, "1e-2 N.mm^2", 1e-8),
    (units.BENDING_STIFFNESS, "1 Nm2", 1.0),
    (units.BENDING_STIFFNESS, "1 Pa*m^4", 1.0),
    (units.CURVATURE_COMPLIANCE, "54 1/(N*m^2)", 54.0),
    (units.CURVATURE_COMPLIANCE, "54 N^-1 m⁻²", 54.0),
    (units.CURVATURE_COMPLIANCE, "54/N/m/m", 54.0),
    (units.CURVATURE, "-1 rad/m", -1.0),
    (units.CURVATURE, "-1 1/m", -1.0),
    (units.CURVATURE, "1/m", 1.0),
    (units.CURVATURE, "180 deg/m", math.pi),
    (units.FORCE_PER_LENGTH, "0.5 N/m", 0.5),
    (units.FORCE_PER_LENGTH, "0.5 N m^-1", 0.5),
    (units.MOMENT_PER_LENGTH, "0.5 N", 0.5),
    (units.MOMENT_PER_LENGTH, "0.5 N*mm/mm", 0.5),
    (units.MODULUS, "10 GPa", 1e10),
    (units.MODULUS, "10 N/mm²", 1e7),
    (units.DENSITY, "1.2 g/cm^3", 1200.0),
    (units.ACCELERATION, "-9.81 m/s^2", -9.81),
    (units.RATIO, "0.35", 0.35),
    (units.RATIO, "5 mm/m", 0.005),
]

BAD_LENGTHS = [
    True, None, [1.0], {"value": 1.0}, 1j, math.nan, math.inf, -math.inf, 10**400, 1e31,
    "", "mm", "nan", "inf m", "1,5 mm", "1 2 m", "- 1 m", "0x10 m", "٣ m", "1e9999 m", "1e308 Gm",
    "25 N", "5 deg", "1 m^2", "1 mm2", "1 1/m", "1 rad", "1 mm/m",
    "1 foo", "1 kdeg", "1 Nfoo", "1 M", "1 m^", "1 m^x", "1 m^10", "1 m^1.5", "1 m*", "1 *m",
    "1 m/", "1 m//m", "1 (m", "1 m)", "1 ()", "1 m m 2", "1 m;", "1 m\x1b[31m", "1 m\nN",
    "1" * 5000, "(" * 5000, 10**5000,
]  # fmt: skip


@pytest.mark.parametrize(("dimension", "value", "expected"), GOOD)
def test_value(dimension: Dimension, value: object, expected: float) -> None:
    assert parse_quantity(value, dimension, "x") == expected


@pytest.mark.parametrize("value", BAD_LENGTHS, ids=lambda value: ascii(shown(value)))
def test_refusal(value: object) -> None:
    with pytest.raises(InputError) as raised:
        parse_quantity(value, units.LENGTH, "legs[1].a")
    message = str(raised.value)
    assert message.startswith(
        "Argument `legs[1].a` must be a length such as 0.25 or '250mm', but it is "
    )
    assert message.isprintable()
    assert len(message) < 300


@pytest.mark.parametrize(
    ("sign", "refused"),
    [
        (Sign.POSITIVE, [0.0, -1.0, "-1 mm", "0 m", 1e-31]),
        (Sign.NOT_NEGATIVE, [-1.0, "-1 mm"]),
        (Sign.NOT_ZERO, [0, "0 m", "-0 m"]),
    ],
)
def test_sign(sign: Sign, refused: list[object]) -> None:
    assert parse_quantity("1 mm", units.LENGTH, "x", sign) == 0.001
    for value in refused:
        with pytest.raises(InputError, match=f"must be a {sign.value} length such as"):
            parse_quantity(value, units.LENGTH, "x", sign)


def test_message() -> None:
    with pytest.raises(InputError) as raised:
        parse_quantity("25 N", units.LENGTH, "legs[1].rod.length")
    assert str(raised.value) == (
        "Argument `legs[1].rod.length` must be a length such as 0.25 or '250mm', but it is '25 N'."
    )


@pytest.mark.parametrize(
    "dimension",
    [value for value in vars(units).values() if isinstance(value, Dimension)],
    ids=lambda dimension: dimension.unit,
)
def test_examples_in_messages_are_valid(dimension: Dimension) -> None:
    examples = [example.strip("'") for example in dimension.example.split(" or ")]
    # A bare number and its equal with a unit are the two spellings that messages show.
    values = [parse_quantity(example, dimension, "x") for example in examples]
    assert values[0] == pytest.approx(values[-1], rel=1e-3)
