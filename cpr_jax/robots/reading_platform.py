"""The platform of a robot file and its loads, read and checked."""

from ..errors import InputError
from .frame import Frame
from .specification import LoadSpecification, PlatformSpecification
from .tables import CHOICES, Table
from .units import FORCE, LENGTH, MASS, MOMENT, Sign


def read_platform(frame: Frame, platform: Table, weighs: bool) -> PlatformSpecification:
    """The platform of a robot, which `weighs` something if the file says how gravity acts."""
    kind = platform.entry("kind").choice(*CHOICES["platform"])
    if kind == "point":
        platform.refuse("moment", "a point has no moment balance")
        platform.refuse("center_of_mass", "a point is its own centre of mass")
        platform.refuse("loads", "a point carries one force, its `force`")
    mass = None
    if platform.has("mass"):
        mass = platform.entry("mass").quantity(MASS, Sign.POSITIVE)
        if not weighs:
            raise InputError(
                f"Argument `{platform.field('mass')}` must come with `environment.gravity`, but "
                f"there is none."
            )
    else:
        platform.refuse("center_of_mass", "there is no `mass`")
    loads = platform.entry("loads").items() if platform.has("loads") else []
    return PlatformSpecification(
        kind=kind,
        force=platform.entry("force", frame.zeros).vector(FORCE, frame.axes),
        moment=frame.rotational(platform.entry("moment", frame.no_turn), MOMENT),
        mass=mass,
        center_of_mass=platform.entry("center_of_mass", frame.zeros).vector(LENGTH, frame.axes),
        loads=tuple(_load(frame, entry.table("platform.loads")) for entry in loads),
    )


def _load(frame: Frame, load: Table) -> LoadSpecification:
    return LoadSpecification(
        position=load.entry("position").vector(LENGTH, frame.axes),
        force=load.entry("force").vector(FORCE, frame.axes),
    )
