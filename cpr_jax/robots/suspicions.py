"""What a robot file may say and yet looks like a mistake."""

from collections.abc import Iterator

from .specification import LegSpecification, RodSpecification

_SOFTEST, _STIFFEST = 1e4, 1e12


def suspicions(
    legs: tuple[LegSpecification, ...], gravity: tuple[float, ...] | None
) -> Iterator[str]:
    """One sentence for each suspicion; one for all legs that have the same rod."""
    rods: dict[RodSpecification, str] = {}
    for i, leg in enumerate(legs):
        rods.setdefault(leg.rod, f"legs[{i}].rod" + (".segments[0]" if leg.further else ""))
        for j, segment in enumerate(leg.further, 1):
            rods.setdefault(segment, f"legs[{i}].rod.segments[{j}]")
    for rod, field in rods.items():
        key, moduli = _implied_moduli(rod)
        for E in moduli:
            if not _SOFTEST <= E <= _STIFFEST:
                yield (
                    f"Argument `{field}.{key}` implies E = {_pascals(E)}, but materials of rods "
                    f"have between {_pascals(_SOFTEST)} and {_pascals(_STIFFEST)}: check its unit."
                )
            elif rod.material and rod.material.E and not 0.5 <= E / rod.material.E <= 2.0:
                yield (
                    f"Argument `{field}.{key}` implies E = {_pascals(E)} for this section, "
                    f"but `{field}.material.E` is {_pascals(rod.material.E)}."
                )
        if gravity is not None and rod.mass_per_length is None:
            yield (
                f"Argument `environment.gravity` does not act on `{field}`, "
                f"which lacks a section or a material with a density."
            )
    for i, leg in enumerate(legs):
        if leg.base_joint and _twists(leg.base_joint.joint) and _twists(leg.joint):
            yield (
                f"Argument `legs[{i}].base_joint` leaves the leg free to turn about itself, as "
                f"`legs[{i}].joint` does: lock this in one of them, for instance by 'universal'."
            )


def _twists(joint: str | tuple[float, ...]) -> bool:
    """Whether a joint in space leaves the rotation about a leg's tangent free."""
    if isinstance(joint, str):
        return joint in ("spherical", "swivel")
    return len(joint) == 6 and joint[3] == 1.0


def _implied_moduli(rod: RodSpecification) -> tuple[str, list[float]]:
    """The key that says how stiff a rod is, and Young's moduli that follow for its section."""
    if rod.section is None:
        return "", []
    if rod.bending_stiffness is not None:
        key, stiffness = "bending_stiffness", rod.bending_stiffness
    elif rod.curvature_compliance is not None:
        key, stiffness = "curvature_compliance", tuple(1.0 / c for c in rod.curvature_compliance)
    else:
        return "material.E", [rod.material.E] if rod.material and rod.material.E else []
    # From the last axis, about which a planar rod bends, as far as both go; torsion implies none.
    moments = rod.section.second_moments
    pairs = zip(reversed(stiffness), reversed(moments), strict=False)
    return key, list(dict.fromkeys(k / moment for k, moment in pairs))


def _pascals(modulus: float) -> str:
    for prefix, scale in (("T", 1e12), ("G", 1e9), ("M", 1e6), ("k", 1e3)):
        if modulus >= scale:
            return f"{modulus / scale:.3g} {prefix}Pa"
    return f"{modulus:.3g} Pa"
