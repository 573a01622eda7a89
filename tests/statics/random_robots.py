"""Robots at random: every kind of motor and of joint, in the plane and in space."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.robots.joint import Joint, passive
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import Rod
from cpr_jax.statics.solve import solve_forward
from cpr_jax.statics.status import Status
from tests.statics.segmented import stepped

KINDS = [pytest.param((PLANE, 2), id="plane"), pytest.param((SPACE, 3), id="space")]

TIPS = ("clamped", "pivot", "swivel", "universal", "spherical", "slider")
BASES = ("clamped", "clamped", "pivot", "universal", "swivel", "slider")
MOTORS = ("revolute", "prismatic", "feed", "telescopic")


def _unit(vector):
    return vector / np.linalg.norm(vector)


def _free(rng, geometry, kinds):
    """Flags of a joint of one of some kinds, about and along any of its axes."""
    d, r = geometry.d, geometry.r
    free = np.zeros(d + r)
    match rng.choice(kinds):
        case "slider":
            free[rng.integers(d)] = 1.0
        case "pivot":
            free[d + rng.integers(r)] = 1.0
        case "swivel":
            free[d] = 1.0
        case "universal":
            free[d + rng.permutation(r)[:2]] = 1.0
        case "spherical":
            free[d:] = 1.0
    return jnp.asarray(free)


def _upright(rng, geometry):
    """A rotation vector that takes the tangent upward, roughly."""
    if geometry.r == 1:
        return np.array([np.pi / 2.0 + rng.uniform(-0.6, 0.6)])
    up = _unit(np.array([0.0, 0.0, 1.0]) + 0.4 * rng.normal(size=3))
    axis = np.cross([1.0, 0.0, 0.0], up)
    return _unit(axis) * np.arctan2(np.linalg.norm(axis), up[0])


def _rod(rng, geometry):
    d, r = geometry.d, geometry.r
    stiffness = 0.02 * np.exp(0.3 * rng.normal())
    bend = np.append(1.0 / rng.uniform(0.7, 1.3, r - 1), 1.0) / stiffness
    return Rod(
        length=jnp.asarray(rng.uniform(0.2, 0.4)),
        curvature_compliance=jnp.asarray(bend),
        precurvature=jnp.asarray(rng.normal(size=r)),
        strain_compliance=jnp.asarray(np.append(1e-5, np.full(d - 1, 3e-5))),
        force=jnp.asarray(0.05 * rng.normal(size=d)),
    )


def _home(geometry):
    home = np.zeros(geometry.freedoms)
    home[geometry.d - 1] = 0.3
    return home


def _leg(rng, geometry, angle):
    d, r = geometry.d, geometry.r
    base = rng.uniform(0.08, 0.15) * np.array([np.cos(angle), np.sin(angle), 0.0])
    if d == 2:
        base = rng.uniform([-0.2, -0.1], [0.2, 0.1])
    screw, feed, stroke = np.zeros(d + r), 0.0, np.zeros(d)
    match rng.choice(MOTORS):
        case "revolute":
            screw[d:] = _unit(rng.normal(size=r)) if r == 3 else 1.0
        case "prismatic":
            screw[:d] = _unit(rng.normal(size=d))
        case "feed":
            feed = 1.0
        case "telescopic":
            stroke[0] = 1.0
    turn = _upright(rng, geometry)
    rod = _rod(rng, geometry)
    # Roughly where the rod ends at rest, so that most of these robots can be assembled.
    tangent = np.stack(geometry.tangent(geometry.rows(geometry.exp(tuple(turn)))))
    end = base[:d] + float(rod.length) * tangent - _home(geometry)[:d]
    lever = jnp.asarray(1.0)
    joint = Joint(_free(rng, geometry, BASES), lever)
    return make_leg(
        geometry,
        base,
        rod,
        a=np.append(rng.uniform(0.0, 0.03), np.zeros(d - 1)),
        b=np.append(rng.uniform(0.0, 0.03), np.zeros(d - 1)),
        base_rotation=turn,
        screw=screw,
        feed=feed,
        stroke=stroke,
        base_joint=passive(geometry, joint, 0.01 * rng.normal(size=d), 0.2 * rng.normal(size=r)),
        joint=Joint(_free(rng, geometry, TIPS), lever),
        attachment_position=end + 0.03 * rng.normal(size=d),
        attachment_rotation=turn + 0.2 * rng.normal(size=r),
    )


def random_robot(rng, geometry, legs: int):
    """A robot with a body as platform, all of one structure: one compiled solve serves them."""
    d = geometry.d
    angles = 2.0 * np.pi * (np.arange(legs) + 0.3 * rng.uniform(size=legs)) / legs
    robot = make_robot(
        geometry,
        [_leg(rng, geometry, angle) for angle in angles],
        oriented=True,
        f_P=0.1 * rng.normal(size=d),
        loads=[(0.01 * rng.normal(size=d), 0.1 * rng.normal(size=d))],
        home=(np.zeros(legs), _home(geometry)),
        name="random",
    )
    # Also where no motor happens to turn its leg.
    return dataclasses.replace(robot, legs=dataclasses.replace(robot.legs, turns=True))


SHARES = ((1.0,), (0.7, 0.3), (0.3, 0.3, 0.4))


def solved_robots(geometry, legs: int, count: int = 9, seed: int = 1):
    """Those of some random robots that assemble at a rough home, with their equilibria.

    In space with rods of one, two and three segments: one program for all that there is.
    """
    rng = np.random.default_rng(seed)
    robots = [random_robot(rng, geometry, legs) for _ in range(count)]
    if geometry is SPACE:
        robots = [stepped(robot, SHARES, k, 0.4, 0.1) for k, robot in enumerate(robots)]
    found = [(robot, solve_forward(robot, np.zeros(legs), throw=False)) for robot in robots]
    statuses = [Status(int(equilibrium.status)) for _, equilibrium in found]
    classified = {Status.SOLVED, Status.LOST, Status.NOT_CONVERGED, Status.NOT_ASSEMBLED}
    assert set(statuses) <= classified
    return [pair for pair, status in zip(found, statuses, strict=True) if status == Status.SOLVED]
