"""The legs of a robot file, read and checked."""

from ..errors import InputError
from .frame import Frame
from .reading_joints import read_base_joint, read_joint, read_motor
from .specification import (
    LegSpecification,
    MaterialSpecification,
    RodSpecification,
    SectionSpecification,
)
from .tables import CHOICES, Entry, Table
from .units import (
    BENDING_STIFFNESS,
    CURVATURE,
    CURVATURE_COMPLIANCE,
    DENSITY,
    FORCE_PER_LENGTH,
    LENGTH,
    MODULUS,
    MOMENT_PER_LENGTH,
    RATIO,
    STRAIN_COMPLIANCE,
    Dimension,
    Sign,
)


def read_leg(frame: Frame, platform: str, leg: Table) -> LegSpecification:
    """A leg of a robot whose platform is a "point" or a "body"."""
    if platform == "point":
        for key in ("attachment", "attachment_rotation"):
            leg.refuse(key, "a point platform carries its joints where it is")
    base = leg.entry("base").vector(LENGTH, frame.axes)
    # In the plane a pivot is meant; in space nothing is usual enough to be assumed.
    joint = read_joint(frame, leg.entry("joint", *(["pivot"] if frame.geometry == "plane" else [])))
    # A joint that turns about some axes only would refer to an orientation that a point lacks.
    flat = frame.geometry == "plane"
    round_joints = ("pivot", "universal", "spherical") if flat else ("spherical",)
    if platform == "point" and joint not in round_joints:
        words = " or ".join(f"'{name}'" for name in round_joints)
        raise leg.entry("joint").error(f"{words} at a point platform, which has no orientation")
    base_joint = None
    if leg.has("base_joint"):
        base_joint = read_base_joint(frame, leg.entry("base_joint"))
    first, *further = _segments(frame, leg.table("rod", "legs.rod"))
    return LegSpecification(
        base=base,
        base_rotation=frame.rotation(leg.entry("base_rotation", frame.no_turn)),
        motor=read_motor(frame, leg.entry("motor", "revolute")),
        base_joint=base_joint,
        a=frame.segment(leg.entry("a", 0.0)),
        rod=first,
        b=frame.segment(leg.entry("b", 0.0)),
        joint=joint,
        moment_row=leg.entry("moment_row", "pivot").choice(*CHOICES["moment_row"]),
        attachment=leg.entry("attachment", frame.zeros).vector(LENGTH, frame.axes),
        attachment_rotation=frame.rotation(leg.entry("attachment_rotation", frame.no_turn)),
        further=tuple(further),
    )


def _segments(frame: Frame, rod: Table) -> list[RodSpecification]:
    """All segments of a rod, which take from it what they do not say themselves."""
    if rod.first("length", "segments") != "segments":
        return [_rod(frame, rod)]
    tables = [
        Table(entry.value, entry.field, "legs.rod.segments", rod)
        for entry in rod.entry("segments").items()
    ]
    for table in tables:
        # The length of a uniform rod among the defaults is that of no segment.
        if "length" not in table.keys():  # noqa: SIM118, a method of Table
            raise InputError(
                f"Argument `{table.field('length')}` must be given, but it is missing."
            )
    return [_rod(frame, table) for table in tables]


def _rod(frame: Frame, rod: Table) -> RodSpecification:
    stiffness = compliance = section = material = strain = None
    if rod.has("section"):
        section = _section(rod.entry("section"))
    if rod.has("material"):
        material = _material(rod.entry("material").table("material"))
    elastic = section is not None and material is not None and material.E is not None
    match rod.first("bending_stiffness", "curvature_compliance"):
        case "bending_stiffness":
            stiffness = _bending(frame, rod.entry("bending_stiffness"), BENDING_STIFFNESS)
        case "curvature_compliance":
            compliance = _bending(frame, rod.entry("curvature_compliance"), CURVATURE_COMPLIANCE)
        case None if not elastic:
            raise InputError(
                f"Argument `{rod.field('bending_stiffness')}` must be given, or both `section` "
                f"and `material.E`, but the rod's stiffness is missing."
            )
    extensible = False
    match rod.first("extensible", "strain_compliance"):
        case "extensible":
            extensible = rod.entry("extensible").truth()
            if extensible and not elastic:
                raise rod.entry("extensible").error("false without both `section` and `material.E`")
        case "strain_compliance":
            parts = ("stretch", *("shear 2", "shear 3")[: len(frame.axes) - 1])
            entry = rod.entry("strain_compliance")
            strain = entry.vector(STRAIN_COMPLIANCE, parts, Sign.NOT_NEGATIVE)
    return RodSpecification(
        length=rod.entry("length").quantity(LENGTH, Sign.POSITIVE),
        bending_stiffness=stiffness,
        curvature_compliance=compliance,
        section=section,
        material=material,
        precurvature=_precurvature(frame, rod),
        extensible=extensible,
        strain_compliance=strain,
        force=rod.entry("force").vector(FORCE_PER_LENGTH, frame.axes) if rod.has("force") else None,
        moment=frame.rotational(rod.entry("moment"), MOMENT_PER_LENGTH)
        if rod.has("moment")
        else None,
    )


def _bending(frame: Frame, entry: Entry, dimension: Dimension) -> tuple[float, ...]:
    """One number for the plane; torsion, bending about 2 and 3 in space, or one for all."""
    if frame.geometry == "space" and entry.is_list:
        return entry.vector(dimension, ("torsion", "about 2", "about 3"), Sign.POSITIVE)
    return (entry.quantity(dimension, Sign.POSITIVE),) * len(frame.rotation_axes)


def _precurvature(frame: Frame, rod: Table) -> tuple[float, ...]:
    straight = (0.0,) * len(frame.rotation_axes)
    match rod.first("precurvature", "precurvature_radius"):
        case "precurvature_radius":
            radius = rod.entry("precurvature_radius").quantity(LENGTH, Sign.NOT_ZERO)
            return (*straight[1:], 1.0 / radius)
        case "precurvature":
            entry = rod.entry("precurvature")
            if frame.geometry == "space" and entry.is_list:
                return entry.vector(CURVATURE, ("about 1", "about 2", "about 3"))
            return (*straight[1:], entry.quantity(CURVATURE))
    return straight


def _section(entry: Entry) -> SectionSpecification:
    kind = entry.table(None).entry("kind").choice(*CHOICES["section"])
    table = entry.table(kind)
    sizes = ("width", "height") if kind == "rectangle" else ("radius",)
    shear_factor = None
    if table.has("shear_factor"):
        shear_factor = table.entry("shear_factor").quantity(RATIO, Sign.POSITIVE)
    return SectionSpecification(
        kind,
        tuple(table.entry(size).quantity(LENGTH, Sign.POSITIVE) for size in sizes),
        shear_factor,
    )


def _material(table: Table) -> MaterialSpecification:
    nu = table.entry("nu", 0.35)
    ratio = nu.quantity(RATIO)
    if not -1.0 < ratio <= 0.5:
        raise nu.error("a Poisson's ratio above -1 and at most 0.5")
    density = None
    if table.has("density"):
        density = table.entry("density").quantity(DENSITY, Sign.POSITIVE)
    E = table.entry("E").quantity(MODULUS, Sign.POSITIVE) if table.has("E") else None
    return MaterialSpecification(E, ratio, density)
