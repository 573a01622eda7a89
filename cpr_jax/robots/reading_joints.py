"""The motors and joints of a robot file, read and checked."""

from ..errors import InputError
from .frame import Frame
from .specification import BaseJointSpecification, MotorSpecification
from .tables import CHOICES, Entry, Table, unit_vector
from .units import LENGTH, RATIO, Sign


def read_motor(frame: Frame, entry: Entry) -> MotorSpecification:
    """The motor of a leg: the name of a kind, or a table."""
    if not entry.is_table:
        return MotorSpecification(entry.choice(*CHOICES["motor"]))
    table = entry.table("motor")
    kind = table.entry("kind").choice(*CHOICES["motor"])
    if kind == "none":
        table.refuse("ratio", "there is no motor")
    if kind not in ("revolute", "prismatic"):
        table.refuse("axis", "only motors that turn or slide a leg have one")
    if kind == "revolute" and frame.geometry == "plane":
        table.refuse("axis", "a revolute motor in the plane turns about its normal")
    axis = None
    if table.has("axis"):
        given = table.entry("axis")
        axis = unit_vector(given.vector(RATIO, frame.axes), given)
    return MotorSpecification(kind, axis, table.entry("ratio", 1.0).quantity(RATIO, Sign.NOT_ZERO))


def read_joint(frame: Frame, entry: Entry) -> str | tuple[float, ...]:
    """The joint at the platform: a name, or the flags of its free motions."""
    if not entry.is_table:
        return entry.choice(*CHOICES["joint"])
    return _flags(frame, entry.table("joint").entry("free"))


def read_base_joint(frame: Frame, entry: Entry) -> BaseJointSpecification:
    """The passive joint that a motor carries: a name, or a table with its place."""
    if not entry.is_table:
        name = entry.choice(*CHOICES["joint"])
        return BaseJointSpecification(name, frame.zeros, (0.0,) * len(frame.rotation_axes))
    table = entry.table("base_joint")
    return BaseJointSpecification(
        joint=_base_freedoms(frame, table),
        position=table.entry("position", frame.zeros).vector(LENGTH, frame.axes),
        rotation=frame.rotation(table.entry("rotation", frame.no_turn)),
    )


def _base_freedoms(frame: Frame, table: Table) -> str | tuple[float, ...]:
    match table.first("joint", "free"):
        case "joint":
            return table.entry("joint").choice(*CHOICES["joint"])
        case "free":
            return _flags(frame, table.entry("free"))
    raise InputError(
        f"Argument `{table.field('joint')}` must be given, or `free`, but the joint's freedoms "
        f"are missing."
    )


def _flags(frame: Frame, free: Entry) -> tuple[float, ...]:
    motions = [f"along {k + 1}" for k in range(len(frame.axes))]
    motions += ["angle"] if len(frame.rotation_axes) == 1 else [f"about {k}" for k in (1, 2, 3)]
    flags = [entry.value for entry in free.items()]
    if len(flags) != len(motions) or any(flag not in (0, 1) for flag in flags) or all(flags):
        raise free.error(
            f"a list of {len(motions)} flags, 0 locked and 1 free ({', '.join(motions)}), "
            f"which are not all 1"
        )
    return tuple(1.0 if flag else 0.0 for flag in flags)
