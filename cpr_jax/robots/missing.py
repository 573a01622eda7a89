"""Parameters that robots of a kind have, and one robot has not."""

import re

from .specification import LegSpecification, RodSpecification


def missing(
    label: str,
    platform: str,
    legs: tuple[LegSpecification, ...],
    gravity: tuple[float, ...] | None,
) -> str | None:
    """Why a robot has no number of this label to vary; `None` if it has.

    **Arguments:**

    - `platform`: "point" or "body".
    """
    if label.startswith("m_P_") and platform == "point":
        return "no moment turns a point platform"
    match = re.fullmatch(r"(r_c|f)(\d*)(?:_(\d+))?(?:_[xyz])?", label)
    if match is None:
        return None
    rod = _segments(legs[int(match[2] or 1) - 1])[int(match[3] or 1) - 1]
    if match[1] == "r_c":
        if rod.precurvature[-1] != 0.0:
            return None
        return f"that rod is straight (name its precurvature, {label.replace('r_c', 'kappa')})"
    loaded = (_is_loaded(each, gravity) for leg in legs for each in _segments(leg))
    if any(loaded):
        return None
    return "no rod has a distributed load (a `force` of zeros is one)"


def _segments(leg: LegSpecification) -> tuple[RodSpecification, ...]:
    return (leg.rod, *leg.further)


def _is_loaded(rod: RodSpecification, gravity: tuple[float, ...] | None) -> bool:
    return rod.force is not None or (gravity is not None and rod.mass_per_length is not None)
