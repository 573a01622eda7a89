"""Motors come back after the turns of their legs, whatever gears are between."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.rods.rod import Rod
from cpr_jax.statics.periods import motor_periods, motor_spans
from cpr_jax.statics.residual import leg_base


def geared(robot, ratios):
    legs = dataclasses.replace(robot.legs, screw=robot.legs.screw * jnp.asarray(ratios)[:, None])
    return dataclasses.replace(robot, legs=legs)


def bases(robot, q_a):
    """Where all rods begin, how they are turned, and how long they are."""
    out = []
    for i, q in enumerate(robot.transmission @ jnp.asarray(q_a)):
        base = leg_base(robot.geometry, robot.leg(i), q, jnp.ones(robot.geometry.freedoms))
        turned = jnp.stack(robot.geometry.frame(base.rotation)).ravel()
        assert isinstance(base.rod, Rod)
        out.append(jnp.concatenate([base.position, turned, base.rod.length[None]]))
    return np.concatenate(out)


@pytest.mark.parametrize(
    ("robot", "expected"),
    [
        (cpr.rfrfr(), (1.0, 1.0)),
        (geared(cpr.rfrfr(), (0.5, 3.0)), (2.0, 1 / 3)),
        (cpr.three_rfr(), (1.0, 1.0, 1.0)),
        (cpr.six_rus(), (1.0,) * 6),
    ],
    ids=("direct", "geared", "three", "six"),
)
def test_legs_are_back_after_a_period_and_not_before(robot, expected):
    periods = motor_periods(robot)
    np.testing.assert_allclose(periods, 2.0 * np.pi * np.array(expected), rtol=1e-12)
    np.testing.assert_allclose(motor_spans(robot), periods / 2.0)
    start = np.linspace(0.3, 0.7, robot.n_a)
    before = bases(robot, start)
    for j, period in enumerate(periods):
        unit = np.eye(robot.n_a)[j] * period
        np.testing.assert_allclose(bases(robot, start + unit), before, atol=1e-12)
        for share in (1 / 2, 1 / 3):
            assert np.max(np.abs(bases(robot, start + share * unit) - before)) > 1e-3


def test_legs_of_one_motor_come_back_together():
    robot = dataclasses.replace(cpr.rfrfr(), transmission=jnp.array([[0.5], [0.75]]))
    period = motor_periods(robot)
    np.testing.assert_allclose(period, [8.0 * np.pi])
    before = bases(robot, [0.2])
    np.testing.assert_allclose(bases(robot, 0.2 + period), before, atol=1e-12)


@pytest.mark.parametrize(
    "robot",
    [
        cpr.three_pfr(),
        cpr.stewart_gough_sliding(),
        dataclasses.replace(cpr.rfrfr(), transmission=jnp.array([[1.0], [np.sqrt(2.0)]])),
    ],
    ids=("sliding", "space", "incommensurate"),
)
def test_what_never_comes_back_has_no_period(robot):
    assert np.all(np.isinf(motor_periods(robot)))
    assert np.all(np.isfinite(motor_spans(robot)))


def test_sliders_are_searched_over_half_a_rod_whatever_its_length():
    """Also over that of rods of exactly a metre, which is the unit of angles, too."""
    robot = cpr.three_pfr()
    for length in (1.0, 1.5):
        rods = dataclasses.replace(robot.legs.rod, length=jnp.full(3, length))
        longer = dataclasses.replace(robot, legs=dataclasses.replace(robot.legs, rod=rods))
        np.testing.assert_allclose(motor_spans(longer), length / 2.0)
