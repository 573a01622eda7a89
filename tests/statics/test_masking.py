"""Derivatives that failed lanes are not to spoil."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.statics.masking import where_solved
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
