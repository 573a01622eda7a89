"""The shape of a robot's legs."""

from typing import NamedTuple

import jax
from jaxtyping import Array, Float

from ..background import not_a_number
from ..errors import check_integer
from ..programs import brief_program
from ..robots.robot import Robot
from ..rods.equations import RodState
from ..rods.integration import DEFAULT_STEPS, rod_shape
from ..rods.segments import arc_lengths
from .equilibrium import Equilibrium, check_fits
from .masking import where_solved
from .residual import leg_base, to_world
from .unknowns import unravel


class Shape(NamedTuple):
    """Legs in world axes, from motor to joint.

    **Attributes** (`points` equidistant cross-sections a rod, or of rods with `k` further segments
    `k (points - 1)` more, equidistant in each segment, both ends of which are among them):

    - `s`: arc length along each rod, m, shape `(n, points)`.
    - `rods`: states along the rods; `rods.position` has shape `(n, points, d)`, m.
    - `motors`, `pivots`: positions of the motors and of the passive joints at the base, which are
        the same where there are none, m, `(n, d)`.
    - `joints`: far ends of the rigid segments b, m, `(n, d)`.
    """

    s: Float[Array, "n points"]
    rods: RodState
    motors: Float[Array, "n d"]
    pivots: Float[Array, "n d"]
    joints: Float[Array, "n d"]


def shape(robot: Robot, equilibrium: Equilibrium, points: int = 51) -> Shape:
    """The shape of each leg at an equilibrium, at points from both ends of each segment on.

    The integration takes at least `DEFAULT_STEPS` steps a segment, of which points may skip some.
    """
    check_fits("equilibrium", equilibrium, robot)
    check_integer("points", points, least=2)
    return _at(where_solved(robot, equilibrium), equilibrium.y, points)


def compile_shape(robot: Robot, points: int = 51) -> None:
    """Has the program of `shape` there before there is an equilibrium."""
    _at(robot, not_a_number(robot.n_y), points)


def _at(robot: Robot, y: Float[Array, " n_y"], points: int) -> Shape:
    return _shape(robot.unnamed, y, points, -(-DEFAULT_STEPS // (points - 1)))


@brief_program
def _shape(robot: Robot, y: Float[Array, " n_y"], points: int, finer: int) -> Shape:
    geometry = robot.geometry
    state = unravel(robot, y)

    def one(leg, q, mu):
        base = leg_base(geometry, leg, q, mu)
        steps = (points - 1) * finer
        local = rod_shape(geometry, base.rod, base.force, base.moment, steps)
        local = jax.tree.map(lambda leaf: leaf[::finer], local)
        rods = jax.vmap(lambda x: to_world(geometry, base, x))(local)
        tip = geometry.frame(rods.rotation[-1])
        joint = rods.position[-1] + geometry.outward(tip, leg.b)
        s = arc_lengths(base.rod, steps)[::finer]
        return Shape(s, rods, base.motor, base.joint, joint)

    return jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu)
