"""Which numbers of a robot are the parameters ρ, with labels, units and ranges (6)."""

import dataclasses
import re
from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..checks import check_finite, check_positive, check_shape
from ..errors import InputError
from ..geometry import floats, namespace
from ..robots.labels import segment_missing
from ..robots.robot import Robot
from .entries import LENGTH, BendingStiffness, Common, Entry, SegmentLength


@dataclasses.dataclass(frozen=True)
class Selection:
    """An ordered choice of a robot's numbers. Hashable: serves as a static argument."""

    entries: tuple[Entry, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the parameters, the columns of Π."""
        return tuple(entry.label for entry in self.entries)

    @property
    def units(self) -> tuple[str, ...]:
        """SI units of the parameters."""
        return tuple(entry.unit for entry in self.entries)

    def get(self, robot: Robot) -> Float[Array, " n_rho"]:
        """The vector ρ of a robot."""
        if not self.entries:
            return jnp.zeros(0)
        return jnp.stack([entry.get(robot) for entry in self.entries])

    def set(self, robot: Robot, values: Float[Array, " n_rho"]) -> Robot:
        """The robot with another vector ρ."""
        for entry, value in zip(self.entries, values, strict=True):
            robot = entry.set(robot, value)
        return robot


_COMPLIANCE = "legs.rod.curvature_compliance"

# Name: (path, index behind the leg's, reciprocal, unit). `i` is a leg, `axis` a world axis.
_LEG = {
    "k_b": (_COMPLIANCE, (-1,), True, "N m^2"),
    "r_c": ("legs.rod.precurvature", (-1,), True, "m"),
    "kappa": ("legs.rod.precurvature", (-1,), False, "1/m"),
    "l": (LENGTH, (), False, "m"),
    "a": ("legs.a", (0,), False, "m"),
    "b": ("legs.b", (0,), False, "m"),
}
_AXIS = {
    "base": ("legs.base_position", "m"),
    "f": ("legs.rod.force", "N/m"),
}
_PATH = re.compile(r"([a-z][\w.]*)\[([\d, ]*)\]")
_LEG_LABEL = re.compile(r"(k_b|k_t|k_2|k_3|r_c|kappa|l|a|b)(\d*)(?:_(\d+))?")
_AXIS_LABEL = re.compile(r"(base|f)(\d+)(?:_(\d+))?_([xyz])")
_LOAD_LABEL = re.compile(r"(f_P|m_P)_([xyz])")


def select(
    robot: Robot, labels: Sequence[str] | None = None, field: str = "parameters"
) -> Selection:
    """The parameters with the given labels; by default those whose uncertainty is known.

    **Arguments:**

    - `labels`: `k_b1` (bending stiffness of leg 1; in space about both axes at once, their ratio
        kept), `r_c1` (radius of precurvature; in space about the rod's last axis), `kappa1`
        (precurvature, likewise), `l1`, `a1`, `b1` (lengths), `base1_y` (motor position), `f1_y`
        (distributed load), `f_P_y`, `m_P_x` (load), in space `k_t1`, `k_21`, `k_31` (stiffness
        about one axis); of a rod with further segments `k_b1_2` (of leg 1, segment 2), `r_c1_2`,
        `kappa1_2`, `l1_2`, `f1_2_y`; of all legs and segments at once, their ratios kept, `k_b`,
        `k_t`, `k_2`, `k_3`, `r_c`, `kappa`, `l`, `a`, `b`, such as of rods cut from one bar: the
        value is that of the first; or any array of the robot with an index, such as
        `legs.joint.lever[0]`. Legs and segments count from 1, indices from 0.
    - `field`: the argument that errors are to name.
    """
    if labels is None:
        labels = tuple(robot.uncertainty)
        if not labels:
            raise InputError(
                f"Argument `{field}` must name parameters, since {robot.name} declares no "
                "uncertainty of its own."
            )
    if isinstance(labels, str) or not isinstance(labels, Iterable):
        labels = (labels,)
    labels = tuple(labels)
    if not labels:
        raise InputError(f"Argument `{field}` must name at least one parameter, but it is empty.")
    entries = tuple(_entry(robot, label, field) for label in labels)
    known: dict[tuple[str, tuple[int, ...]], str] = {}
    for entry in entries:
        for place in entry.places(robot):
            if place in known:
                raise InputError(
                    f"Argument `{field}` must name each number once, but {known[place]!r} and "
                    f"{entry.label!r} are the same."
                )
            known[place] = entry.label
    return Selection(entries)


def selected(
    robot: Robot, labels: Sequence[str] | None, delta: Mapping[str, float] | None
) -> tuple[Selection, Float[Array, " n_rho"]]:
    """`select` and `ranges`, of nothing where a robot has no uncertainty and none is asked for.

    What is looked at still has its place, its singularities and its stability.
    """
    certain = labels is None and not robot.uncertainty
    selection = Selection(()) if certain else select(robot, labels)
    return selection, ranges(robot, selection, delta)


def ranges(
    robot: Robot, selection: Selection, delta: Mapping[str, float] | None = None
) -> Float[Array, " n_rho"]:
    """Half ranges `δρ` (6): those given, else those of the robot."""
    if delta is not None and not isinstance(delta, Mapping):
        raise InputError(
            "Argument `delta` must give half ranges by label, such as {'l1': 1e-3}, but it is a "
            f"{type(delta).__name__}."
        )
    for label, half_range in (delta or {}).items():
        check_shape(f"delta[{label!r}]", half_range, ())
        check_positive(f"delta[{label!r}]", half_range, or_zero=True)
        check_finite(f"delta[{label!r}]", half_range)
    known = {**robot.uncertainty, **(delta or {})}
    unknown = [label for label in (delta or {}) if label not in selection.labels]
    if unknown:
        raise InputError(
            f"Argument `delta` must name selected parameters ({', '.join(selection.labels)}), "
            f"but it names {unknown[0]!r}."
        )
    missing = [label for label in selection.labels if label not in known]
    if missing:
        raise InputError(
            f"Argument `delta` must give a half range for {missing[0]!r}, since {robot.name} "
            "declares none."
        )
    values = [known[label] for label in selection.labels]
    if not values:
        return floats(np.zeros(0))
    return floats(namespace(values).stack(values))


def _entry(robot: Robot, label: str, field: str) -> Entry:
    entry = None
    if isinstance(label, str):
        entry = _named(robot, label, field) or _by_path(label)
    if entry is None:
        raise InputError(
            f"Argument `{field}` must name numbers of the robot, such as 'k_b1', 'r_c1', 'l1', "
            f"'base1_y', 'f_P_y' or 'legs.rod.length[0]', but it names {label!r}."
        )
    if isinstance(entry, Common):
        return _checked_common(robot, entry, field)
    try:
        leaf = attrgetter(entry.path)(robot)
        inside = leaf is not None and len(entry.index) == leaf.ndim
        inside = inside and all(-n <= i < n for i, n in zip(entry.index, leaf.shape, strict=True))
    except AttributeError:
        inside = False
    if not inside:
        raise InputError(
            f"Argument `{field}` must name numbers that the robot has, but {label!r} is not "
            f"among those of {robot.name} ({robot.n} legs)."
        )
    known = not isinstance(leaf, jax.core.Tracer)
    # By numpy: within a transformation JAX would trace what is known, too.
    if entry.reciprocal and known and np.asarray(leaf)[entry.index] == 0.0:
        instead = f": name {label.replace('r_c', 'kappa')!r} of a straight rod"
        raise InputError(
            f"Argument `{field}` must name finite numbers, but {label!r} is infinite"
            f"{instead if label.startswith('r_c') else ''}."
        )
    return entry


def _checked_common(robot: Robot, entry: Common, field: str) -> Common:
    """Refuses a number of all legs that vanishes in the first, from which the others are told."""
    leaf = attrgetter(entry.path)(robot)
    if not isinstance(leaf, jax.core.Tracer) and np.asarray(leaf)[(0, *entry.index[-1:])] == 0.0:
        what = "infinite" if entry.reciprocal else "zero"
        raise InputError(
            f"Argument `{field}` must name numbers that have a ratio, but {entry.label!r} of the "
            f"first leg is {what}: name those of single legs."
        )
    return entry


def _named(robot: Robot, label: str, field: str) -> Entry | None:
    axes = robot.geometry.axes
    about = enumerate(robot.geometry.stiffnesses)
    of_legs = _LEG | {name: (_COMPLIANCE, (k,), True, "N m^2") for k, name in about}
    if label in of_legs:
        path, rest, reciprocal, unit = of_legs[label]
        ends = (1, 2) if label == "k_b" and len(robot.geometry.stiffnesses) == 3 else rest
        # Counted from the front, as where one number is named from two sides.
        size = attrgetter(path)(robot).shape[-1]
        return Common(label, path, tuple(k % size for k in ends), reciprocal, unit)
    if (match := _LEG_LABEL.fullmatch(label)) and match[2] and match[1] in of_legs:
        path, rest, reciprocal, unit = of_legs[match[1]]
        kind = SegmentLength if path == LENGTH and match[3] else Entry
        if match[1] == "k_b" and len(robot.geometry.stiffnesses) == 3:
            kind = BendingStiffness
        path, index = _place(robot, label, path, _index(match[2]), match[3], field)
        return kind(label, path, (*index, *rest), reciprocal, unit)
    if (match := _AXIS_LABEL.fullmatch(label)) and match[4] in axes:
        path, unit = _AXIS[match[1]]
        path, index = _place(robot, label, path, _index(match[2]), match[3], field)
        return Entry(label, path, (*index, axes.index(match[4])), False, unit)
    if match := _LOAD_LABEL.fullmatch(label):
        force = match[1] == "f_P"
        among = axes if force else robot.geometry.rotation_axes
        if match[2] in among:
            unit = "N" if force else "N m"
            return Entry(label, match[1], (among.index(match[2]),), False, unit)
    return None


def segment_count(robot: Robot, leg: int) -> int | None:
    """How many segments the rod of leg `leg`, counted from 0, has; `None` while it is traced."""
    further = robot.legs.rod.further
    if further is None:
        return 1
    if isinstance(further.length, jax.core.Tracer):
        return None
    return 1 + int(np.count_nonzero(np.asarray(further.length)[leg]))


def _place(robot: Robot, label: str, path: str, leg: int, segment: str | None, field: str):
    """Where a number of a leg, or of a segment of its rod, is: path and first indices."""
    if not path.startswith("legs.rod.") or leg >= robot.n:
        return path, (_NOWHERE if segment else leg,)
    count = segment_count(robot, leg)
    if segment is None and count is not None and count > 1:
        raise segment_missing(label, leg + 1, count, field)
    if segment is None:
        return path, (leg,)
    # A uniform rod has no segments that one could name.
    k = _index(segment)
    if count is not None and (count == 1 or k >= count):
        k = _NOWHERE
    if k == 0:
        return path, (leg,)
    return path.replace("rod.", "rod.further."), (leg, k - 1)


_NOWHERE = 10**6
"""Legs and segments with the number 0 do not exist; an index out of range says so."""


def _index(number: str) -> int:
    return int(number) - 1 if int(number) > 0 else _NOWHERE


def _by_path(label: str) -> Entry | None:
    match = _PATH.fullmatch(label)
    if match is None:
        return None
    index = tuple(int(part) for part in match[2].split(",") if part.strip())
    return Entry(label, match[1], index, False, "SI")
