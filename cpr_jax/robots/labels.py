"""Labels of a robot's parameters and of the components of its vectors."""

import difflib
import itertools
import re
from collections.abc import Sequence

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


def parameter_dimensions(geometry: str, segments: Sequence[int]) -> dict[str, Dimension]:
    """The parameters of a robot: their labels and what they measure.

    **Arguments:**

    - `geometry`: "plane" or "space".
    - `segments`: of how many segments the rod of each leg consists. Where there are several, what
        belongs to one of them is labelled `k_b1_2`: leg 1, segment 2. What belongs to all legs at
        once has no number: `k_b`.
    """
    axes = AXES[geometry]
    dimensions = {f"f_P_{axis}": FORCE for axis in axes}
    dimensions |= {f"m_P_{axis}": MOMENT for axis in ROTATION_AXES[geometry]}
    stiffnesses = ("k_b",) if geometry == "plane" else ("k_b", "k_t", "k_2", "k_3")
    dimensions |= dict.fromkeys(stiffnesses, BENDING_STIFFNESS)
    dimensions |= dict.fromkeys(("r_c", "l", "a", "b"), LENGTH) | {"kappa": CURVATURE}
    for i, count in enumerate(segments, 1):
        for j in [str(i)] if count == 1 else [f"{i}_{k}" for k in range(1, count + 1)]:
            dimensions |= {f"{name}{j}": BENDING_STIFFNESS for name in stiffnesses}
            dimensions |= {f"{name}{j}": LENGTH for name in ("r_c", "l")}
            dimensions[f"kappa{j}"] = CURVATURE
            dimensions |= {f"f{j}_{axis}": FORCE_PER_LENGTH for axis in axes}
        dimensions |= {f"{name}{i}": LENGTH for name in ("a", "b")}
        dimensions |= {f"base{i}_{axis}": LENGTH for axis in axes}
    return dimensions


def path_of(label: str) -> tuple[str, tuple[int, ...]] | None:
    """Path and index of a label such as `legs.joint.lever[0]`; `None` for any other."""
    match = re.fullmatch(r"([a-z][\w.]*)\[([\d, ]*)\]", label)
    if match is None:
        return None
    return match[1], tuple(int(part) for part in match[2].split(",") if part.strip())


def is_part_of(label: str, whole: str) -> bool:
    """Whether a label names a number that another one, of all legs at once, stands for too."""
    groups = {"k_b": "k_b|k_2|k_3", "r_c": "r_c|kappa", "kappa": "r_c|kappa"}
    group = groups.get(whole, whole)
    if whole in ("k_2", "k_3"):
        group = f"k_b|{whole}"
    of_a_leg = re.fullmatch(rf"(?:{group})\d*(?:_\d+)?", label) is not None
    return of_a_leg and re.fullmatch(r"[a-z]+(?:_[a-z\d])?", whole) is not None


def check_labels(labels: Sequence[str], geometry: str, segments: Sequence[int], field: str) -> None:
    """Refuses labels that name nothing, or a number beside one that stands for it too.

    Paths to arrays of a robot are not looked at.

    **Arguments:** as of `parameter_dimension`.
    """
    named = [label for label in labels if path_of(label) is None]
    for label in named:
        parameter_dimension(label, geometry, segments, field)
    for one, other in itertools.permutations(named, 2):
        if is_part_of(other, one):
            raise InputError(
                f"Argument `{field}` must leave {other!r} out beside {one!r}, which stands for all "
                "legs."
            )


def segment_missing(label: str, leg: int, count: int, field: str) -> InputError:
    """The error that a label of leg `leg` does not say which of `count` segments it means."""
    example = re.sub(r"(_[xyz])?$", r"_1\1", label, count=1)
    return InputError(
        f"Argument `{field}` must name one of the {count} segments of leg {leg}, such as "
        f"{example!r}, but {label!r} names none."
    )


def parameter_dimension(
    label: str, geometry: str, segments: Sequence[int], field: str = "label"
) -> Dimension:
    """What the parameter of this label measures.

    **Raises:**

    - `InputError`: naming `field`, if a robot whose legs have so many segments has no such
        parameter.
    """
    dimensions = parameter_dimensions(geometry, segments)
    n_legs = len(segments)
    if label not in dimensions:
        uniform = parameter_dimensions(geometry, [1] * n_legs)
        if label in uniform:
            leg = int(re.sub(r"^k_[23]|\D", "", label))
            raise segment_missing(label, leg, segments[leg - 1], field)
        close = difflib.get_close_matches(str(label), dimensions, n=1)
        hint = f"; did you mean '{close[0]}'?" if close else "."
        raise InputError(
            f"Argument `{field}` must be named after a parameter of the robot's {n_legs} legs or "
            f"its platform, such as 'k_b1' or 'f_P_{AXES[geometry][-1]}', "
            f"but {shown(label)} is none{hint}"
        )
    return dimensions[label]
