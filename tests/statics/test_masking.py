"""Derivatives that failed lanes are not to spoil."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.statics.equilibrium import polish
from cpr_jax.statics.masking import where_solved
from cpr_jax.statics.problem import forward_rows
from cpr_jax.statics.status import Status


@pytest.mark.parametrize("status", [Status.SOLVED, Status.LOST])
def test_what_is_masked_has_no_slope(paper, nominal, status):
    """The square root has none at zero, and a mask behind it makes NaN of that."""
    here = dataclasses.replace(nominal, status=jnp.asarray(int(status)))
    at = jnp.where(status == Status.SOLVED, 4.0, 0.0)

    def masked(load, gate):
        robot = gate(dataclasses.replace(paper, f_P=load), here)
        return jnp.sum(jnp.where(here.status == Status.SOLVED, jnp.sqrt(robot.f_P), 0.0))

    slope = jax.grad(lambda load: masked(load, where_solved))(jnp.full(2, at))
    np.testing.assert_array_equal(slope, 0.25 if status == Status.SOLVED else 0.0)
    plain = jax.grad(lambda load: masked(load, lambda robot, _: robot))(jnp.full(2, at))
    assert np.all(np.isnan(plain)) == (status == Status.LOST)


def test_a_robot_whose_numbers_are_known_stays_what_it_is(paper, nominal):
    assert where_solved(paper, nominal) is paper


@pytest.fixture(scope="module")
def slope():
    """Of what a failed solve leaves, by a number that all lanes share: of passive legs in space
    that carry weight, where what is masked is NaN on the way."""
    steel = cpr.Material(E=200e9, density=7800.0)
    rod = cpr.section_rod(cpr.SPACE, 0.2, cpr.circle(1e-3), steel, gravity=(0.0, 0.0, -9.81))
    joint = cpr.passive(cpr.SPACE, cpr.universal(cpr.SPACE), position=(0.02, 0.0, 0.0))
    leg = cpr.make_leg(
        cpr.SPACE,
        (0.1, 0.0, 0.0),
        rod,
        base_joint=joint,
        joint=cpr.spherical(cpr.SPACE),
        attachment_position=(0.06, 0.0, 0.0),
    )
    load = ((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    robot = cpr.make_robot(cpr.SPACE, [leg], oriented=True, loads=[load])
    rows, nowhere = forward_rows(robot), jnp.full(robot.n_y, jnp.nan)
    lost = np.asarray(int(Status.LOST))

    @jax.jit
    def slopes(length):
        def masked(length):
            longer = eqx.tree_at(lambda r: r.legs.a, robot, robot.legs.a.at[:, 0].add(length))
            target = jnp.zeros(robot.n_a + robot.n_p)
            found = polish(longer, rows, target, nowhere, lost, 1e-6, "home", np.asarray(2))
            solved = found.status == Status.SOLVED
            return jnp.where(solved, found.q_p[0], 0.0), jnp.where(
                solved, found.base_wrenches[0, 0], 0.0
            )

        values, pull = jax.vjp(masked, length)
        return [pull(seed)[0] for seed in ((1.0, 0.0), (0.0, 1.0))], values

    return slopes(0.0)


def test_a_failed_lane_of_passive_legs_with_weight_has_no_slope(slope):
    np.testing.assert_array_equal(np.asarray(slope[0]), 0.0)
    np.testing.assert_array_equal(np.asarray(slope[1]), 0.0)
