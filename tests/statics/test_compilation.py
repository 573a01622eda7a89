"""What a solve compiles: nothing more for other numbers, no larger programs for more legs."""

import jax
import jax.numpy as jnp
import numpy as np

import cpr_jax as cpr
from cpr_jax.geometry import PLANE
from cpr_jax.robots.joint import clamped
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod


def many_legs(count):
    """A planar platform on equal legs with revolute motors."""
    places = np.linspace(-0.1, 0.1, count)
    legs = [
        make_leg(
            PLANE,
            (place, 0.0),
            kirchhoff_rod(PLANE, 0.3, 0.01),
            joint=clamped(PLANE),
            attachment_position=(0.5 * place, 0.0),
        )
        for place in places
    ]
    home = np.full(count, np.pi / 2.0), (0.0, 0.3, 0.0)
    return make_robot(PLANE, legs, oriented=True, home=home)


def test_programs_do_not_grow_with_the_number_of_legs():
    """Nor does their compilation: whatever runs over legs is an axis or a loop."""

    def operations(count):
        robot = many_legs(count)
        solve = jax.jit(lambda robot, q_a: vars(cpr.solve_forward(robot, q_a))["measures"])
        return solve.lower(robot, jnp.zeros(count)).as_text().count("\n")

    assert operations(4) == operations(12)


def test_another_number_of_steps_compiles_nothing(paper):
    compiled = []

    def listen(event, duration, **_):
        if event.endswith("backend_compile_duration"):
            compiled.append(event)

    # Where earlier tests have compiled much, the first call may ask for room. The second makes it
    # on its way by dropping all programs, so that those of its start are the third's to compile.
    for _ in range(3):
        cpr.solve_inverse(paper, (0.02, 0.21), steps=12)
    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        cpr.solve_inverse(paper, (0.02, 0.21), steps=14)
        assert not compiled
        # The listener does hear of compilations.
        jax.jit(lambda x: 3.0 * x + 2.0)(0.5)
        assert compiled
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)
