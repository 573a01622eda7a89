"""Sizes that look like mistakes, and sizes that do not."""

import copy
import tomllib

import pytest

from cpr_jax.robots.reading import parse_specification
from tests.robots.documents import DOCUMENTS


def changed(*path, value, name="point"):
    """A document with one entry replaced."""
    document = copy.deepcopy(tomllib.loads(DOCUMENTS[name]))
    place = document
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return document


@pytest.mark.parametrize("name", DOCUMENTS)
def test_good_files_raise_no_suspicion_of_their_sizes(name):
    warnings = parse_specification(tomllib.loads(DOCUMENTS[name])).warnings
    assert not [text for text in warnings if " m long" in text or "unit" in text]


@pytest.mark.parametrize(
    ("document", "text"),
    [
        (changed("legs", 0, "rod", "length", value=250), "`legs[0].rod.length` is 250 m: a number"),
        (changed("legs", 1, "rod", "length", value=2e-4), "`legs[1].rod.length` is 0.0002 m"),
        (changed("legs", 1, "base", value=[100, 0]), "`legs[1].base` is 100.1 m long or far away"),
        (changed("legs", 1, "a", value=45), "`legs[1].a` is 45 m long or far away"),
        (
            changed("legs", 0, "rod", "section", value={"kind": "circle", "radius": 2}),
            "`legs[0].rod.section` is up to 2 m across, but the rod is 0.25 m",
        ),
        (changed("home", "position", value=[0, 200]), "`home.position` is 200 m from the first"),
        (
            changed("home", "position", value=[0, 0.5]),
            "`home.position` is 0.509902 m from the motor of `legs[0]`, which reaches 0.25 m",
        ),
        (changed("home", "motors", value=[154, 25]), "`home.motors[0]` is 154 rad, more than a"),
        (changed("home", "motors", value=[2.6, -8.6]), "`home.motors[1]` is -8.6 rad, more than"),
        (
            changed("legs", 1, "base_rotation", value=90, name="body"),
            "`legs[1].base_rotation` is 90 rad, more than a turn",
        ),
        (
            changed("legs", 1, "attachment_rotation", value=-45, name="body"),
            "`legs[1].attachment_rotation` is 45 rad",
        ),
        (changed("home", "rotation", value=10, name="body"), "`home.rotation` is 10 rad"),
        (
            changed("uncertainty", "k_b1", value=4.73),
            "`uncertainty.k_b1` is 4.73 in SI units, more",
        ),
        (changed("uncertainty", value={"k_b": 4.73}), "`uncertainty.k_b` is 4.73 in SI units"),
        (changed("uncertainty", "l2", value=1), "`uncertainty.l2` is 1 in SI units, more than"),
    ],
    ids=lambda value: value.split("`")[1] if isinstance(value, str) else "",
)
def test_what_looks_like_a_missing_unit_is_said_once(document, text):
    found = [warning for warning in parse_specification(document).warnings if text in warning]
    assert len(found) == 1
    assert found[0].isprintable()


def test_a_half_range_is_compared_with_the_stiffness_of_a_section():
    """A circle of 1 mm and 200 GPa: E I = 0.157 N m²."""
    rod = {
        "length": 0.25,
        "section": {"kind": "circle", "radius": 1e-3},
        "material": {"E": 200e9},
    }
    document = changed("legs", 0, "rod", value=rod)
    for half_range, count in ((0.15, 0), (0.16, 1)):
        document["uncertainty"] = {"k_b1": half_range}
        warnings = parse_specification(document).warnings
        assert len([w for w in warnings if "more than the parameter itself, 0.157" in w]) == count


def test_a_rod_that_is_too_long_is_all_that_is_said():
    document = changed("legs", 0, "rod", "length", value=250)
    document["legs"][1]["rod"]["length"] = 250
    (warning,) = parse_specification(document).warnings
    assert warning.endswith("is 250 m: a number without a unit is in metres.")
