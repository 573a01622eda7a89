"""The unknowns y = (q_a, q_p, μ): packing, scales, labels."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..geometry import floats, namespace
from ..robots.robot import Robot


class State(NamedTuple):
    """The unknowns of a robot in SI units.

    **Attributes:**

    - `q_a`: motor positions, rad or m, shape `(n_a,)`.
    - `q_p`: platform position in world axes, m, then for a body its rotation vector, rad.
    - `mu`: `n(0)`, N, and `m(0)`, N·m, at the base of each rod in world axes, `(n, d + r)`; of a
        robot with passive joints at the base, see `BaseJoint`, their wrenches and motions.
    """

    q_a: Float[Array, " n_a"]
    q_p: Float[Array, " n_p"]
    mu: Float[Array, "n freedoms"]


class Scales(NamedTuple):
    """Units in which a robot's unknowns and residual are of the order of one."""

    length: Float[Array, ""]
    force: Float[Array, ""]

    def wrench(self, robot: Robot) -> Float[Array, " freedoms"]:
        """Units of a wrench: forces, then moments."""
        xp = namespace(self)
        force = xp.asarray(self.force)
        return _repeated(robot, force, force * xp.asarray(self.length))

    def pose(self, robot: Robot) -> Float[Array, " freedoms"]:
        """Units of a motion: translations, then rotations."""
        return _repeated(robot, self.length, 1.0)

    def motors(self, robot: Robot) -> Float[Array, " n_a"]:
        """Units of the motor positions: 1 rad for what turns, the length for what slides."""
        xp = namespace(robot.legs.screw, robot.transmission, self.length)
        screw, transmission = xp.asarray(robot.legs.screw), xp.asarray(robot.transmission)
        turns = xp.any(screw[:, robot.geometry.d :] != 0.0, axis=-1)
        turned = xp.abs(transmission).T @ turns.astype(float) > 0.0
        return floats(xp.where(turned, 1.0, xp.asarray(self.length)))


def _repeated(robot: Robot, straight, turning) -> Float[Array, " freedoms"]:
    """A unit for each translation, then one for each rotation."""
    xp = namespace(straight, turning)
    units = xp.stack([xp.asarray(straight), xp.asarray(turning)])
    return floats(units[np.repeat([0, 1], [robot.geometry.d, robot.geometry.r])])


def scales(robot: Robot, held: bool = True) -> Scales:
    """Mean rod length, and the force `k_b / l²` that bends a rod by about 1 rad.

    Of rods with further segments the mean compliance along them counts.

    **Arguments:**

    - `held`: without derivatives, as units are a choice and not physics. What is told in them
        changes with them all the same.
    """
    rod = robot.legs.rod
    numbers: tuple[Array, ...] = rod.length, rod.curvature_compliance
    if rod.further is not None:
        numbers = *numbers, rod.further.length, rod.further.curvature_compliance
    xp = namespace(numbers)
    if xp is jnp and held:
        numbers = jax.lax.stop_gradient(numbers)
    lengths, compliances, *further = (xp.asarray(part) for part in numbers)
    length, compliances = xp.mean(lengths), compliances[:, -1]
    if further:
        shares = further[0] / lengths[:, None]
        beyond = xp.sum(shares * (further[1][:, :, -1] - compliances[:, None]), axis=1)
        compliances = compliances + beyond
    return Scales(floats(length), floats(1.0 / (xp.mean(compliances) * length**2)))


def unknown_scales(robot: Robot, units: Scales | None = None) -> Float[Array, " n_y"]:
    """The unit of each entry of the flat y, by default in `scales(robot)`."""
    units = scales(robot) if units is None else units
    parts = units.motors(robot), units.pose(robot), units.wrench(robot), base_freedoms(robot)
    xp = namespace(*parts)
    motors, pose, wrench, free = (xp.asarray(part) for part in parts)
    legs = xp.where(free > 0.5, pose, wrench)
    return floats(xp.concatenate([motors, pose[: robot.n_p], legs.reshape(-1)]))


def row_scales(robot: Robot, units: Scales) -> Float[Array, " n_r"]:
    """The unit of each row of `R₀`: a wrench where a joint is free, a motion where it is locked."""
    pose, wrench = units.pose(robot), units.wrench(robot)
    joints = jnp.where(robot.legs.joint.free > 0.5, wrench, pose)
    return jnp.concatenate([wrench[: robot.n_p], joints.reshape(-1)])


def base_freedoms(robot: Robot) -> Float[Array, "n freedoms"]:
    """1 for each of `mu` that is a motion of a passive joint, 0 for components of wrenches."""
    if robot.legs.base_joint is None:
        return floats(np.zeros((robot.n, robot.geometry.freedoms)))
    return robot.legs.base_joint.free


def ravel(state: State) -> Float[Array, " n_y"]:
    """The flat y = (q_a, q_p, μ_1, …, μ_n)."""
    xp = namespace(state)
    q_a, q_p, mu = (xp.asarray(part) for part in state)
    return floats(xp.concatenate([q_a, q_p, mu.reshape(-1)]))


def unravel(robot: Robot, y: Float[Array, " n_y"]) -> State:
    """Inverse of `ravel`."""
    q_a, q_p, mu = jnp.split(y, [robot.n_a, robot.n_a + robot.n_p])
    return State(q_a, q_p, mu.reshape(robot.n, robot.geometry.freedoms))


_UNITS = {"n": "N", "m": "N m", "s": "m", "eta": "rad"}


def unknown_labels(robot: Robot) -> tuple[str, ...]:
    """Label of each entry of the flat y; motors and legs count from 1."""
    geometry = robot.geometry
    pose = [f"p_P_{axis}" for axis in geometry.axes]
    pose += [f"phi_P_{axis}" for axis in geometry.rotation_axes]
    axes = _leg_axes(robot)
    wrenches = [
        f"{name}{i + 1}_{axis}"
        for i, names in enumerate(_leg_names(robot))
        for name, axis in zip(names, axes, strict=True)
    ]
    return (*(f"q{i + 1}" for i in range(robot.n_a)), *pose[: robot.n_p], *wrenches)


def _leg_axes(robot: Robot) -> tuple[str, ...]:
    """World axes, or numbers of the local axes of passive joints."""
    geometry = robot.geometry
    if robot.legs.base_joint is None:
        return (*geometry.axes, *geometry.rotation_axes)
    return (*"123"[: geometry.d], *"123"[3 - geometry.r :])


def _leg_names(robot: Robot) -> list[list[str]]:
    """Of each leg: forces `n` and moments `m`; of passive joints also slides `s`, turns `eta`."""
    d, r = robot.geometry.d, robot.geometry.r
    wrenches, motions = ["n"] * d + ["m"] * r, ["s"] * d + ["eta"] * r
    joint = robot.legs.base_joint
    free = None if joint is None else joint.free
    if free is None or isinstance(free, jax.core.Tracer):
        return [wrenches] * robot.n
    pairs = list(zip(motions, wrenches, strict=True))
    moves = (np.asarray(free) > 0.5).tolist()
    return [[pair[not m] for pair, m in zip(pairs, leg, strict=True)] for leg in moves]


def unknown_units(robot: Robot) -> tuple[str, ...]:
    """SI unit of each entry of the flat y."""
    geometry = robot.geometry
    sliding = [bool(u) for u in slides(robot)]
    pose = ["m"] * geometry.d + ["rad"] * geometry.r
    wrenches = [_UNITS[name] for names in _leg_names(robot) for name in names]
    motors = ["m" if each else "rad" for each in sliding]
    return (*motors, *pose[: robot.n_p], *wrenches)


def slides(robot: Robot) -> Bool[np.ndarray, " n_a"]:
    """Which motors are measured in metres."""
    marker = Scales(floats(2.0), floats(1.0))
    return np.asarray(marker.motors(robot)) == 2.0
