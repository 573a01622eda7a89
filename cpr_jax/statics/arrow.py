"""The equations of many cases at once, with the unknowns of each leg eliminated by itself.

A leg knows its motor, the platform and its own μ only, so that `∂R/∂y` is an arrow: blocks of the
legs, bordered by motors and platform. A block is regular wherever its leg, held at both of its
ends, is stable, as it is on every stable branch; but for one direction, that in which a straight
inextensible rod resists by itself. Hence the weakest direction of each leg is left to the border,
and what is solved at last has as many rows as motors, platform coordinates and legs.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..rods.solver import Steps
from .linear import Eliminated, eliminated, eliminated_but_one
from .problem import Problem
from .residual import Units, leg_rows, platform_load


class Parts(NamedTuple):
    """R, or a change of y, by where it belongs.

    **Attributes** (lanes last):

    - `border`: equilibrium of the platform and imposed coordinates; or motors and platform.
    - `legs`: rows of the joints; or the unknowns μ of the legs.
    """

    border: Float[Array, "n_q lanes"]
    legs: Float[Array, "freedoms n lanes"]

    def flat(self) -> Float[Array, "n_y lanes"]:
        """As y is laid out: μ comes last."""
        legs = jnp.moveaxis(self.legs, 0, 1)
        return jnp.concatenate([self.border, legs.reshape(-1, legs.shape[-1])])

    def largest(self) -> Float[Array, " lanes"]:
        """The largest entry."""
        return jnp.maximum(
            jnp.max(jnp.abs(self.border), axis=0), jnp.max(jnp.abs(self.legs), axis=(0, 1))
        )


class Blocks(NamedTuple):
    """The Jacobian by legs (lanes last), dimensionless but for what is outside of a leg.

    **Attributes:**

    - `outside`: `(2 (d + r), 1 + n_p, n)`, rows of the joints, then wrenches on the platform, by
        the motor position of the leg and the platform's coordinates in SI units.
    - `own`: the same by the leg's μ, `(2 (d + r), d + r, n)`.
    - `load`: of the platform by its coordinates.
    """

    outside: Float[Array, "rows k n lanes"]
    own: Float[Array, "rows freedoms n lanes"]
    load: Float[Array, "freedoms n_p lanes"]


class System:
    """The equations of a problem on arrays with their lanes last."""

    def __init__(self, problem: Problem, scale, units: Units, steps: Steps):
        self.problem, self.steps, self.units = problem, steps, units
        self.robot = robot = problem.robot
        self.n, self.n_a = robot.transmission.shape[:2]
        self.n_p, self.freedoms = robot.n_p, robot.geometry.freedoms
        self.legs = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -2), robot.legs)
        self.by_motor = jnp.moveaxis(robot.transmission, 0, 1)
        self.scale = self.unknowns(scale)

    def _by_leg(self, flat):
        return jnp.moveaxis(flat.reshape(self.n, self.freedoms, -1), 0, 1)

    def unknowns(self, y) -> Parts:
        """The flat y, its lanes last, in parts."""
        border, own = jnp.split(y, [self.n_a + self.n_p])
        return Parts(border, self._by_leg(own))

    def rows(self, R) -> Parts:
        """The flat R in parts: the rows of the joints lie between those of the border."""
        n_p = self.n_p
        border = jnp.concatenate([R[:n_p], R[len(R) - self.n_a :]])
        return Parts(border, self._by_leg(R[n_p : len(R) - self.n_a]))

    def in_rows(self, values: Parts) -> Float[Array, "n_y lanes"]:
        """Inverse of `rows`."""
        joints = jnp.moveaxis(values.legs, 0, 1)
        joints = joints.reshape(-1, joints.shape[-1])
        return jnp.concatenate([values.border[: self.n_p], joints, values.border[self.n_p :]])

    def values(self, y: Parts) -> Parts:
        """`R(y, ρ)`."""
        return self._joined(y, self._legs(self.local(y)))

    def local(self, y: Parts):
        """The unknowns that each leg knows, SI: its motor, the platform, its μ."""
        border, own = y.border * self.scale.border, y.legs * self.scale.legs
        q = jnp.sum(self.by_motor * border[: self.n_a, None], axis=0)
        parts = q[None], border[self.n_a :, None], own
        lanes = jnp.broadcast_shapes(q.shape, own.shape[1:])
        return jnp.concatenate([jnp.broadcast_to(p, (p.shape[0], *lanes)) for p in parts])

    def _legs(self, local):
        """Rows of the joints and wrenches on the platform, dimensionless."""
        units = Units(*(unit[:, None] for unit in self.units))
        q, q_p, own = local[0], local[1 : 1 + self.n_p], local[1 + self.n_p :]
        rows, wrench = leg_rows(self.robot, units, self.steps, self.legs, q, q_p, own)
        return jnp.concatenate([rows, wrench / units.wrench])

    def _load(self, q_p):
        return platform_load(self.robot, q_p) / self.units.wrench

    def _joined(self, y: Parts, by_leg) -> Parts:
        problem, f = self.problem, self.freedoms
        rows, wrenches = by_leg[:f], by_leg[f:]
        q = y.border * self.scale.border
        balance = (self._load(q[self.n_a :]) - jnp.sum(wrenches, axis=1))[: self.n_p]
        if problem.offset is not None:
            balance = balance - problem.offset[: self.n_p]
            rows = rows - self._by_leg(problem.offset[self.n_p :])
        away = (q - problem.target) / self.scale.border
        imposed = jnp.sum(problem.imposed * away, axis=1)
        return Parts(jnp.concatenate([balance, imposed]), rows)

    def linearised(self, y: Parts) -> tuple[Parts, Blocks]:
        """R and its Jacobian."""
        local = self.local(y)
        by_leg, slopes = _with_slopes(self._legs, local)
        outside, own = slopes[:, : 1 + self.n_p], slopes[:, 1 + self.n_p :]
        q_p = (y.border * self.scale.border)[self.n_a :]
        load = jnp.zeros((self.freedoms, self.n_p, 1))
        if self.robot.loads is not None:
            load = _with_slopes(self._load, q_p)[1]
        return self._joined(y, by_leg), Blocks(outside, own * self.scale.legs, load)

    def _by_border(self, outside, load):
        """What the legs feel, summed over the platform's balance: by motors and platform."""
        motors = -jnp.sum(outside[:, :1] * self.by_motor, axis=2)
        platform = load - jnp.sum(outside[:, 1:], axis=2)
        return jnp.concatenate([motors, platform], axis=1)[: self.n_p] * self.scale.border

    def _imposed(self, like):
        return jnp.broadcast_to(self.problem.imposed, (self.n_a, *like.shape[1:]))

    def matrix(self, blocks: Blocks) -> Float[Array, "n_y n_y lanes"]:
        """`∂R/∂y`, all of it."""
        f, n = self.freedoms, self.n
        balance = self._by_border(blocks.outside[f:], blocks.load)
        lanes = balance.shape[-1]
        felt = -jnp.moveaxis(blocks.own[f : f + self.n_p], 1, 2).reshape(self.n_p, n * f, lanes)
        outside = blocks.outside[:f]
        by_border = (
            jnp.concatenate([outside[:, :1] * self.by_motor, outside[:, 1:]], axis=1)
            * self.scale.border[:, None]
        )
        by_border = jnp.moveaxis(by_border, 2, 0).reshape(n * f, -1, lanes)
        own = jnp.moveaxis(blocks.own[:f], 2, 0)
        own = jnp.eye(n)[:, None, :, None, None] * own[:, :, None]
        imposed = self._imposed(balance)
        rows = (
            (balance, felt),
            (by_border, own.reshape(n * f, n * f, lanes)),
            (imposed, jnp.zeros((self.n_a, n * f, lanes))),
        )
        return jnp.concatenate([jnp.concatenate(row, axis=1) for row in rows])

    def inverted(self, y: Parts) -> "tuple[Parts, Inverse]":
        """R and the inverse of its Jacobian."""
        values, blocks = self.linearised(y)
        f, k = self.freedoms, 1 + self.n_p
        own, outside = blocks.own[:f], blocks.outside[:f]
        unit = jnp.broadcast_to(jnp.eye(f)[:, :, None, None], own.shape)
        rights = jnp.concatenate([outside, unit], axis=1)
        legs = eliminated_but_one(own.reshape(f, f, -1), rights.reshape(f, k + f, -1))
        legs = jax.tree.map(lambda a: a.reshape(*a.shape[:-1], *own.shape[2:]), legs)
        # What motors and platform do to the wrenches while the joints stay closed.
        seen = blocks.outside[f:] - _product(blocks.own[f:], legs.solved[:, :k])
        balance = self._by_border(seen, blocks.load)
        felt = blocks.own[f : f + self.n_p]
        lanes = balance.shape[-1]
        weak = -_product(felt, legs.weak[:, None])[:, 0]
        by_border = jnp.concatenate([legs.left[0] * self.by_motor, legs.left[1:k]])
        by_border = jnp.moveaxis(by_border, 1, 0)
        own = jnp.eye(self.n)[:, :, None] * legs.own
        rows = (
            (balance, weak),
            (self._imposed(balance), jnp.zeros((self.n_a, self.n, lanes))),
            (by_border * self.scale.border, own),
        )
        border = jnp.concatenate([jnp.concatenate(row, axis=1) for row in rows])
        unit = jnp.broadcast_to(jnp.eye(len(border))[:, :, None], border.shape)
        border, last = eliminated(border, unit)
        # Rows and columns change places with those of the legs.
        turned = -1.0 if self.n * f * self.n_a % 2 else 1.0
        sign = turned * last * jnp.prod(legs.sign, axis=0)
        return values, Inverse(self, legs, felt, border, sign)


class Inverse(NamedTuple):
    """`(∂R/∂y)⁻¹` by elimination of the legs (lanes last).

    **Attributes:**

    - `legs`: how μ answers to the motor, the platform and the rows of the joints.
    - `felt`: wrenches on the platform by μ.
    - `border`: inverse of what remains, for motors, platform and the legs' weakest directions.
    - `sign`: of the determinant of `∂R/∂y`.
    """

    system: System
    legs: Eliminated
    felt: Float[Array, "n_p freedoms n lanes"]
    border: Float[Array, "m m lanes"]
    sign: Float[Array, " lanes"]

    def of(self, values: Parts) -> Parts:
        """Times a residual: the unknowns that go with it."""
        system = self.system
        k = 1 + system.n_p
        legs = _product(self.legs.solved[:, k:], values.legs[:, None])[:, 0]
        felt = jnp.sum(_product(self.felt, legs[:, None])[:, 0], axis=1)
        border = values.border + jnp.pad(felt, ((0, system.n_a), (0, 0)))
        left = jnp.sum(self.legs.left[k:] * values.legs, axis=0)
        border = _product(self.border, jnp.concatenate([border, left])[:, None])[:, 0]
        border, weak = border[: -system.n], border[-system.n :]
        local = system.local(Parts(border, jnp.zeros_like(legs)))[:k]
        legs = legs - _product(self.legs.solved[:, :k], local[:, None])[:, 0]
        return Parts(border, legs + self.legs.weak * weak)


def _with_slopes(function, x):
    """A function's values, and its derivatives along their second axis."""
    unit = jnp.eye(len(x)).reshape(len(x), len(x), *(1,) * (x.ndim - 1))
    seeds = jnp.broadcast_to(unit, (len(x), *x.shape))
    push = jax.vmap(lambda seed: jax.jvp(function, (x,), (seed,)), out_axes=(None, 1))
    return push(seeds)


def _product(matrix, other):
    """Matrix times matrix in the first two axes, written out: the others are long."""
    return sum(matrix[:, k, None] * other[k] for k in range(matrix.shape[1]))
