"""The choice of integration steps, against a much finer integration."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.rods.integration import rod_tip
from cpr_jax.statics.accuracy import MENU, error_with, relative_tip_error, steps_for
from cpr_jax.statics.residual import leg_base
from cpr_jax.statics.unknowns import unravel


def tips(robot, y, steps):
    state = unravel(robot, y)

    def one(leg, q, mu):
        base = leg_base(robot.geometry, leg, q, mu)
        tip = rod_tip(robot.geometry, base.rod, base.force, base.moment, steps)
        return tip.position / base.rod.length

    return jax.vmap(one)(robot.legs, robot.transmission @ state.q_a, state.mu)


@pytest.mark.parametrize("point", [(0.0, 0.25), (0.06, 0.18), (0.11, 0.1), (0.05, 0.045)])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_chosen_steps_are_accurate_and_not_many_more(point, tolerance):
    robot = cpr.rfrfr()
    y = cpr.solve_inverse(robot, point).y
    steps = steps_for(float(relative_tip_error(robot, y)), tolerance)
    reference = tips(robot, y, 60)
    # The estimate extrapolates: within a factor of ten of its word.
    assert np.max(np.abs(tips(robot, y, steps) - reference)) < 10.0 * tolerance
    fewer = MENU.index(steps) - 2
    if fewer >= 0:
        assert np.max(np.abs(tips(robot, y, MENU[fewer]) - reference)) > 0.05 * tolerance


def test_nothing_is_enough_for_the_impossible():
    assert steps_for(1e-3, 1e-30) == MENU[-1]
    assert error_with(1e-9, 10) == pytest.approx(1e-9 / 1024)
    assert jnp.isfinite(error_with(0.0, 4))
