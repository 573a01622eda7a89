"""Packing, labels and units of the unknowns."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.naming import segment_count
from cpr_jax.geometry import PLANE
from cpr_jax.robots.catalogue import rfrfr, rfrfr_straight, three_rfr
from cpr_jax.robots.embedding import in_space
from cpr_jax.robots.leg import make_leg, prismatic_screw
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.statics.status import SolveError, Status
from cpr_jax.statics.unknowns import (
    ravel,
    scales,
    unknown_labels,
    unknown_scales,
    unknown_units,
    unravel,
)


def sliding():
    """A point carried by a motor that slides and one that turns."""
    rod = kirchhoff_rod(PLANE, 0.5, 0.02)
    legs = [
        make_leg(PLANE, (-0.2, 0.0), rod, screw=prismatic_screw(PLANE)),
        make_leg(PLANE, (0.2, 0.0), rod),
    ]
    return make_robot(PLANE, legs, oriented=False)


ROBOTS = [rfrfr, three_rfr, sliding, lambda: in_space(rfrfr()), lambda: in_space(three_rfr())]


@pytest.mark.parametrize("make", ROBOTS)
def test_packing_is_reversible(make):
    robot = make()
    y = jnp.arange(1.0, robot.n_y + 1.0)
    state = unravel(robot, y)
    assert state.q_a.shape == (robot.n_a,)
    assert state.q_p.shape == (robot.n_p,)
    assert state.mu.shape == (robot.n, robot.geometry.freedoms)
    np.testing.assert_array_equal(ravel(state), y)


@pytest.mark.parametrize("make", ROBOTS)
def test_every_unknown_has_a_label_a_unit_and_a_scale(make):
    robot = make()
    labels, units = unknown_labels(robot), unknown_units(robot)
    assert len(set(labels)) == len(labels) == len(units) == robot.n_y
    assert unknown_scales(robot).shape == (robot.n_y,)
    assert np.all(unknown_scales(robot) > 0.0)


def test_the_unknowns_of_the_paper_s_robot():
    """The y of (15): two motors, the end-effector, and a wrench a leg."""
    assert unknown_labels(rfrfr()) == (
        *("q1", "q2", "p_P_y", "p_P_z"),
        *("n1_y", "n1_z", "m1_x", "n2_y", "n2_z", "m2_x"),
    )
    assert unknown_units(rfrfr()) == (
        *("rad", "rad", "m", "m"),
        *("N", "N", "N m", "N", "N", "N m"),
    )


def test_a_sliding_motor_counts_in_metres():
    assert unknown_units(sliding())[:2] == ("m", "rad")
    np.testing.assert_allclose(unknown_scales(sliding())[:2], [0.5, 1.0])


def test_a_body_in_space_has_a_rotation_vector():
    labels = unknown_labels(in_space(three_rfr()))
    assert labels[3:9] == ("p_P_x", "p_P_y", "p_P_z", "phi_P_x", "phi_P_y", "phi_P_z")


def test_forces_are_scaled_by_what_bends_a_rod():
    units = scales(rfrfr_straight())
    assert float(units.length) == pytest.approx(1.0)
    assert float(units.force) == pytest.approx(0.1570796327)


def test_every_status_has_a_message():
    assert len({status.message for status in Status}) == len(Status)
    error = SolveError(Status.LOST, "No equilibrium.")
    assert error.status is Status.LOST and isinstance(error, RuntimeError)


def test_labels_are_the_same_within_a_transformation():
    """What is known of a robot that is built there stays known."""

    def labels_of(length):
        leg = cpr.make_leg(
            cpr.PLANE,
            (0.0, 0.0),
            cpr.segmented_rod([cpr.kirchhoff_rod(cpr.PLANE, part, 0.02) for part in (length, 0.1)]),
            base_joint=cpr.passive(cpr.PLANE, cpr.pivot(cpr.PLANE)),
        )
        robot = cpr.make_robot(cpr.PLANE, [leg], oriented=True)
        return unknown_labels(robot), segment_count(robot, 0), robot.legs.rod.length[0]

    eager, within = labels_of(0.2), []
    jax.jit(lambda length: within.append(labels_of(length)[:2]) or length)(0.2)
    assert within == [eager[:2]]
    assert "eta1_3" in eager[0]
