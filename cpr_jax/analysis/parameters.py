"""Which numbers of a robot are the parameters ρ, with labels, units and ranges (6)."""

import dataclasses
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..checks import check_finite, check_positive, check_shape
from ..errors import InputError
from ..geometry import floats, namespace
from ..robots.robot import Robot
from .entries import Common, Entry, SegmentLength
from .naming import by_path, named


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
        # A plain dictionary, put into a robot by hand, has no order that lasts.
        ordered = isinstance(robot.uncertainty, OrderedDict)
        labels = tuple(robot.uncertainty if ordered else sorted(robot.uncertainty))
        if not labels:
            raise InputError(
                f"Argument `{field}` must name parameters, since {robot.name} declares no "
                "uncertainty of its own."
            )
        field = "uncertainty"
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
    _check_lengths(robot, entries, field)
    return Selection(entries)


def _check_lengths(robot: Robot, entries: Sequence[Entry], field: str) -> None:
    """Refuses lengths of segments beside arrays that they are told from: each changes the other."""
    of_segments = {e.place(robot)[0]: e for e in entries if isinstance(e, SegmentLength)}
    for entry in entries:
        if type(entry) is not Entry or not entry.path.endswith(".length"):
            continue
        other = of_segments.get(entry.place(robot)[0])
        if other is not None:
            raise InputError(
                f"Argument `{field}` must name the length of a segment or an array it is told "
                f"from, but {other.label!r} and {entry.label!r} change each other."
            )


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
        entry = named(robot, label, field) or by_path(label)
    if entry is None:
        raise InputError(
            f"Argument `{field}` must name numbers of the robot, such as 'k_b1', 'r_c1', 'l1', "
            f"'base1_y', 'f_P_y' or 'legs.rod.length[0]', but it names {label!r}."
        )
    if isinstance(entry, Common):
        return _checked_common(robot, entry, field)
    left_out = ""
    try:
        leaf = attrgetter(entry.path)(robot)
        if leaf is None:
            left_out = f": its `{entry.path}` is left out, give zeros for it"
        inside = leaf is not None and len(entry.index) == leaf.ndim
        inside = inside and all(-n <= i < n for i, n in zip(entry.index, leaf.shape, strict=True))
    except AttributeError:
        inside = False
    if not inside:
        raise InputError(
            f"Argument `{field}` must name numbers that the robot has, but {label!r} is not "
            f"among those of {robot.name} ({robot.n} legs){left_out}."
        )
    turn = entry.path == "legs.screw" and entry.index[-1] % leaf.shape[-1] >= robot.geometry.d
    if turn and not robot.legs.turns:
        raise InputError(
            f"Argument `{field}` must leave out {label!r}: no motor of {robot.name} turns its leg, "
            "and rotations of its screws do not count, see `Leg.turns`."
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
