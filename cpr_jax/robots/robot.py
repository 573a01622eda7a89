"""A continuum parallel robot: its legs, its platform, its loads."""

import dataclasses
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float

from ..checks import check_finite, check_kind, check_positive, check_shape, check_vector
from ..errors import InputError, shown
from ..geometry import AbstractGeometry, Components, Numbers, floats, namespace, unchanged
from .joint import Joint
from .labels import check_labels
from .leg import Leg
from .stacking import stack, turns_any


class Home(eqx.Module):
    """A configuration that names the branch a robot works on.

    Only a rough one is needed: the robot is assembled there and the equilibrium is polished.

    **Attributes:**

    - `q_a`: motor positions, shape `(n_a,)`.
    - `q_p`: platform coordinates, shape `(n_p,)`.
    """

    q_a: Float[Array, " n_a"]
    q_p: Float[Array, " n_p"]


class PointLoads(eqx.Module):
    """Dead forces at points of a platform that is a body.

    **Attributes:**

    - `position`: in the platform's axes, from `p_P`, m, shape `(k, d)`.
    - `force`: in world axes, N, shape `(k, d)`.
    """

    position: Float[Array, "k d"]
    force: Float[Array, "k d"]


class Robot(eqx.Module):
    """A continuum parallel robot as a pytree: each of its numbers is an array leaf.

    **Attributes:**

    - `geometry`: `PLANE` or `SPACE`.
    - `legs`: a `Leg` whose leaves are stacked along a first axis of length n.
    - `oriented`: whether the platform is a rigid body; otherwise it is a mere point, without an
        orientation among the unknowns and without a moment balance.
    - `f_P`: dead force on the platform at `p_P`, world axes, N, shape `(d,)`.
    - `m_P`: dead moment on the platform, world axes, N·m, shape `(r,)`; unused by a point.
    - `loads`: forces at other points of the platform, such as its weight, or `None`.
    - `transmission`: motion of each leg's actuator per motor, shape `(n, n_a)`; the identity
        where each leg has its motor.
    - `home`: where the robot's branch is known, or `None`.
    - `uncertainty`: half ranges `δρ` (6) of uncertain parameters by their label.
    - `name`: for figures and files.
    """

    geometry: AbstractGeometry = eqx.field(static=True)
    legs: Leg
    oriented: bool = eqx.field(static=True)
    f_P: Float[Array, " d"]
    m_P: Float[Array, " r"]
    transmission: Float[Array, "n n_a"]
    home: Home | None
    # Of a plain dictionary JAX sorts the keys, wherever it builds a robot anew.
    uncertainty: dict[str, Float[Array, ""]] = eqx.field(converter=OrderedDict)
    name: str = eqx.field(static=True)
    loads: PointLoads | None = None

    @property
    def n(self) -> int:
        """Number of legs."""
        return self.transmission.shape[-2]

    @property
    def n_a(self) -> int:
        """Number of motors."""
        return self.transmission.shape[-1]

    @property
    def n_p(self) -> int:
        """Number of platform coordinates: position, then the rotation vector of a body."""
        return self.geometry.d + (self.geometry.r if self.oriented else 0)

    @property
    def n_y(self) -> int:
        """Number of unknowns in `y = (q_a, q_p, μ)`."""
        return self.n_a + self.n_p + self.n * self.geometry.freedoms

    def turn(self, q_p: Any) -> Any:
        """Rotation vector of the platform at `(n_p, *lanes)` coordinates, rad, `(r, *lanes)`.

        Zero for a point, which has none.
        """
        if self.oriented:
            return q_p[self.geometry.d :]
        return np.zeros((self.geometry.r, *q_p.shape[1:]))

    def orientation(self, q_p: Any) -> Components:
        """Rotation of the platform; a point keeps the world axes."""
        return self.geometry.exp(self.turn(q_p))

    @property
    def unnamed(self) -> "Robot":
        """Without its name and its half ranges, on which no equilibrium depends.

        Robots that are alike in the rest share what is compiled for their solves.
        """
        return dataclasses.replace(self, name="", uncertainty={})

    def leg(self, i: int) -> Leg:
        """Leg `i`, counted from 0."""
        return jax.tree.map(lambda leaf: unchanged(namespace(leaf).asarray(leaf)[i]), self.legs)


def make_robot(
    geometry: AbstractGeometry,
    legs: Sequence[Leg],
    *,
    oriented: bool,
    f_P: Numbers | None = None,
    m_P: Numbers | None = None,
    loads: Sequence[tuple[Numbers, Numbers]] = (),
    transmission: Numbers | None = None,
    home: Home | tuple[Numbers, Numbers] | None = None,
    uncertainty: dict[str, float] | None = None,
    name: str = "robot",
) -> Robot:
    """Stacks legs, which may differ in every number, into a robot.

    An effect that only some legs have (a distributed load, extensibility, fed length) becomes a
    zero for the others, and so do the lengths of segments that only some rods have.

    **Arguments:** as the attributes of `Robot`, and

    - `loads`: pairs of a point of the platform and the force there, see `PointLoads`.
    - `home`: a `Home`, or a pair of its motor positions and its platform coordinates.

    **Raises:** `InputError` for shapes that do not fit, numbers that are not finite, and legs of
    the other geometry.
    """
    check_kind("legs", legs, Sequence, "a list of legs")
    if len(legs) == 0:
        raise InputError("Argument `legs` must hold at least one leg, but it is empty.")
    if len(loads) and not oriented:
        raise InputError(
            "Argument `loads` must be left out at a point platform, whose only force is `f_P`, but "
            f"it has {len(loads)} entries."
        )
    if m_P is not None and not oriented:
        raise InputError(
            "Argument `m_P` must be left out at a point platform, which no moment turns, but it is "
            f"{shown(m_P)}."
        )

    d, r = geometry.d, geometry.r
    for i, leg in enumerate(legs):
        if np.shape(leg.base_position) != (d,):
            raise InputError(
                f"Argument `legs` must hold legs of the robot's geometry, {geometry!r}, but leg "
                f"{i + 1} is of another."
            )

    def vector(name, value, size):
        if value is not None:
            check_vector(name, value, size)
            check_finite(name, value)
        return floats(np.zeros(size) if value is None else value)

    if not oriented:
        for i, leg in enumerate(legs):
            _check_round(leg.joint, d, i)
            _check_central(leg, i)
    for k, load in enumerate(loads):
        for part in load:
            check_shape(f"loads[{k}]", part, (d,))
            check_finite(f"loads[{k}]", part)
    ways = floats(np.eye(len(legs)) if transmission is None else transmission)
    if ways.ndim != 2 or len(ways) != len(legs):
        check_shape("transmission", ways, (len(legs), ways.shape[-1] if ways.ndim else 1))
    if uncertainty is not None:
        check_kind("uncertainty", uncertainty, Mapping, "half ranges by label")
    for label, half_range in (uncertainty or {}).items():
        check_positive(f"uncertainty[{label!r}]", half_range, or_zero=True)
        check_finite(f"uncertainty[{label!r}]", half_range)
    check_finite("transmission", ways)
    stacked = stack(legs)
    _check_labels(uncertainty or {}, geometry, legs)
    for place, leaf in jax.tree_util.tree_leaves_with_path(stacked):
        check_finite(f"legs{jax.tree_util.keystr(place)}", leaf)
    further = stacked.rod.further
    bending = [rods.curvature_compliance for rods in (stacked.rod, further) if rods is not None]
    if not any(isinstance(rods, jax.core.Tracer) or np.any(np.asarray(rods)) for rods in bending):
        raise InputError(
            "Argument `legs` must have one rod at least that bends, but the stiffness of all is "
            "infinite."
        )
    known = None
    if isinstance(home, Home):
        home = home.q_a, home.q_p
    if home is not None:
        if len(home) != 2:
            raise InputError(
                "Argument `home` must be a pair, `q_a` and `q_p` (of a body its position and its "
                f"rotation vector in one), but it has {len(home)} parts."
            )
        q_a, q_p = (floats(part) for part in home)
        for k, (part, size) in enumerate(((q_a, ways.shape[1]), (q_p, d + r * oriented))):
            check_shape(f"home[{k}]", part, (size,))
            check_finite(f"home[{k}]", part)
        known = Home(q_a, q_p)
    return Robot(
        geometry=geometry,
        legs=stacked,
        oriented=oriented,
        f_P=vector("f_P", f_P, d),
        m_P=vector("m_P", m_P, r).reshape(-1),
        transmission=ways,
        home=known,
        uncertainty={k: floats(v) for k, v in (uncertainty or {}).items()},
        name=name,
        loads=_point_loads(loads) if len(loads) else None,
    )


def _check_labels(labels: Iterable[str], geometry: AbstractGeometry, legs: Sequence[Leg]) -> None:
    """Refuses half ranges of what the robot does not have."""
    further = [leg.rod.further for leg in legs]
    lengths = [() if each is None else each.length for each in further]
    if not any(isinstance(each, jax.core.Tracer) for each in lengths):
        segments = [1 + int(np.count_nonzero(np.asarray(each))) for each in lengths]
        check_labels(list(labels), geometry.name, segments, "uncertainty")


def _check_round(joint: Joint, d: int, leg: int) -> None:
    """Refuses a joint that would refer to the orientation of a point platform, which has none."""
    if isinstance(joint.free, jax.core.Tracer):
        return
    free = np.asarray(joint.free)
    if np.any(free[:d]) or not np.all(free[d:]):
        raise InputError(
            f"Argument `legs` must have joints that are free to turn, and only that, at a point "
            f"platform (`spherical`), but leg {leg + 1} has another."
        )


def _check_central(leg: Leg, number: int) -> None:
    """Refuses a joint away from a point platform, which could not balance its moment."""
    place = leg.attachment_position
    if not isinstance(place, jax.core.Tracer) and np.any(np.asarray(place)):
        raise InputError(
            "Argument `legs` must have no `attachment_position` at a point platform, which carries "
            f"its joints where it is, but leg {number + 1} has {shown(place)}."
        )


def _point_loads(loads: Sequence[tuple[Numbers, Numbers]]) -> PointLoads:
    places, forces = zip(*loads, strict=True)
    xp = namespace(places, forces)
    position, force = (
        floats(xp.stack([xp.asarray(v, float) for v in vectors])) for vectors in (places, forces)
    )
    return PointLoads(position, force)


def check_turns(robot: Robot) -> None:
    """Refuses a robot one of whose legs was told to turn after it was made without that."""
    screw = robot.legs.screw
    known = not isinstance(screw, jax.core.Tracer)
    if robot.legs.turns or not (known and turns_any(screw, robot.geometry.d)):
        return
    raise InputError(
        "Argument `robot` must have `legs.turns` where `legs.screw` turns a leg, but it was made "
        "without: make it again with `make_robot`."
    )
