"""Orientations from directions, against SciPy's rotations. Nothing here imports jax."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cpr_jax.robots.frame import Frame
from cpr_jax.robots.labels import AXES, ROTATION_AXES
from cpr_jax.robots.tables import Entry

FIRST, SECOND, THIRD = np.eye(3)
DIRECTIONS = [
    (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1, 1, 1), (-3, 2, -1),
    (1, 1e-9, 0), (-1, 1e-9, -1e-9), (1e-5, 0, 1),
]  # fmt: skip


def read(value: Any) -> np.ndarray:
    """The rotation vector of an orientation in space."""
    frame = Frame("space", AXES["space"], ROTATION_AXES["space"])
    return np.array(frame.rotation(Entry(value, "rotation")))


def turned(value: Any) -> Rotation:
    """The rotation that an orientation stands for."""
    return Rotation.from_rotvec(read(value))


def unit(vector: Any) -> np.ndarray:
    """A vector of length 1."""
    return np.asarray(vector) / np.linalg.norm(vector)


@pytest.mark.parametrize("tangent", DIRECTIONS)
def test_tangent(tangent: Any) -> None:
    rotation = turned({"tangent": list(tangent)})
    np.testing.assert_allclose(rotation.apply(FIRST), unit(tangent), atol=1e-15)
    # No rotation that does so is shorter than the angle between the two.
    across = np.linalg.norm(np.cross(FIRST, unit(tangent)))
    angle = math.atan2(across, unit(tangent)[0])
    assert rotation.magnitude() == pytest.approx(angle, rel=1e-15, abs=0.0)


def test_tangent_backwards_turns_about_the_third_axis() -> None:
    assert read({"tangent": [-2, 0, 0]}).tolist() == [0.0, 0.0, math.pi]
    assert read({"tangent": [2, 0, 0]}).tolist() == [0.0, 0.0, 0.0]
    assert read({"tangent": [0, 0, 1]}).tolist() == [0.0, -math.pi / 2.0, 0.0]


ACROSS = [
    (tangent, third)
    for tangent in DIRECTIONS
    for third in [*DIRECTIONS[:8], (-2, 5, 1)]
    if np.linalg.norm(np.cross(unit(tangent), unit(third))) > 1e-4
]


@pytest.mark.parametrize(("tangent", "third"), ACROSS)
def test_tangent_and_third(tangent: Any, third: Any) -> None:
    rotation = turned({"tangent": list(tangent), "third": list(third)})
    np.testing.assert_allclose(rotation.apply(FIRST), unit(tangent), atol=1e-14)
    axis = rotation.apply(THIRD)
    # Nearest to `third` means: in its plane with the tangent, and on its side.
    across = np.cross(unit(tangent), unit(third))
    np.testing.assert_allclose(axis @ across, 0.0, atol=1e-14)
    assert axis @ unit(third) > 0.0
    assert np.linalg.norm(read({"tangent": list(tangent), "third": list(third)})) < math.pi + 1e-12


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, -3, 0), (1, 2, -2)])
@pytest.mark.parametrize("angle", [0, "30 deg", -2.0, "180 deg"])
def test_axis_and_angle(axis: Any, angle: Any) -> None:
    radians = math.radians(float(angle.split()[0])) if isinstance(angle, str) else angle
    value = {"axis": list(axis), "angle": angle}
    np.testing.assert_allclose(read(value), radians * unit(axis), rtol=1e-15, atol=1e-16)


def test_rotation_vector() -> None:
    assert read(["90 deg", 0, -1]).tolist() == [math.pi / 2.0, 0.0, -1.0]
