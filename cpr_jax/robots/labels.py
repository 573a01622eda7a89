"""Labels of a robot's parameters and of the components of its vectors."""

import difflib

from ..errors import InputError, shown
from .units import (
    BENDING_STIFFNESS,
    CURVATURE,
    FORCE,
    FORCE_PER_LENGTH,
    LENGTH,
    MOMENT,
    Dimension,
)

AXES = {"plane": ("y", "z"), "space": ("x", "y", "z")}
"""World axes of each geometry, in the order of the components of a vector."""

ROTATION_AXES = {"plane": ("x",), "space": ("x", "y", "z")}
"""World axes that a rotation or a moment can have."""


def parameter_dimensions(geometry: str, n_legs: int) -> dict[str, Dimension]:
    """The parameters of a robot with `n_legs` legs: their labels and what they measure.

    **Arguments:**

    - `geometry`: "plane" or "space".
    """
    axes = AXES[geometry]
    dimensions = {f"f_P_{axis}": FORCE for axis in axes}
    dimensions |= {f"m_P_{axis}": MOMENT for axis in ROTATION_AXES[geometry]}
    stiffnesses = ("k_b",) if geometry == "plane" else ("k_b", "k_t", "k_2", "k_3")
    for i in range(1, n_legs + 1):
        dimensions |= {f"{name}{i}": BENDING_STIFFNESS for name in stiffnesses}
        dimensions |= {f"{name}{i}": LENGTH for name in ("r_c", "l", "a", "b")}
        dimensions[f"kappa{i}"] = CURVATURE
        dimensions |= {f"base{i}_{axis}": LENGTH for axis in axes}
        dimensions |= {f"f{i}_{axis}": FORCE_PER_LENGTH for axis in axes}
    return dimensions


def parameter_dimension(label: str, geometry: str, n_legs: int, field: str = "label") -> Dimension:
    """What the parameter of this label measures.

    **Raises:**

    - `InputError`: naming `field`, if a robot with `n_legs` legs has no such parameter.
    """
    dimensions = parameter_dimensions(geometry, n_legs)
    if label not in dimensions:
        close = difflib.get_close_matches(str(label), dimensions, n=1)
        hint = f"; did you mean '{close[0]}'?" if close else "."
        raise InputError(
            f"Argument `{field}` must be named after a parameter of the robot's {n_legs} legs or "
            f"its platform, such as 'k_b1' or 'f_P_{AXES[geometry][-1]}', "
            f"but {shown(label)} is none{hint}"
        )
    return dimensions[label]
