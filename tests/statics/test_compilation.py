"""What a solve compiles: nothing more for other numbers, no larger programs for more legs."""

import contextlib
import dataclasses
import os
import pathlib
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.geometry import PLANE
from cpr_jax.robots.joint import clamped
from cpr_jax.robots.leg import make_leg
from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.rod import kirchhoff_rod

ROOT = pathlib.Path(__file__).parents[2]


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


def operations(count):
    """How many a solve of so many legs has before XLA sees it."""
    robot = many_legs(count)
    solve = jax.jit(lambda robot, q_a: vars(cpr.solve_forward(robot, q_a))["measures"])
    return solve.lower(robot, jnp.zeros(count)).as_text().count("\n")


def test_programs_do_not_grow_with_the_number_of_legs():
    """Nor does their compilation: whatever runs over legs is an axis or a loop."""
    # Apart from what other tests have traced: beside them it was once a little more for one.
    code = f"from {__name__} import operations; print(operations(4), operations(12))"
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
        env=os.environ | {"JAX_ENABLE_X64": "1"},
    )
    few, many = map(int, done.stdout.split())
    assert few == many > 1000


@contextlib.contextmanager
def compilations():
    """A list that gets an entry for each program that is compiled meanwhile."""
    compiled = []

    def listen(event, duration, **_):
        if event.endswith("backend_compile_duration"):
            compiled.append(event)

    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        yield compiled
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)


def other_steps(robot):
    return robot, 14


def other_name_and_half_ranges(robot):
    return dataclasses.replace(robot, name="another", uncertainty={"l1": jnp.array(1e-3)}), 12


@pytest.mark.parametrize("other", [other_steps, other_name_and_half_ranges])
def test_what_no_program_depends_on_compiles_nothing(paper, other):
    def solved(robot, steps):
        at = cpr.solve_inverse(robot, (0.02, 0.21), steps=steps)
        cpr.stability(robot, at)
        cpr.shape(robot, at)

    robot, steps = other(paper)
    # Where earlier tests have compiled much, the first call may ask for room. The second makes it
    # on its way by dropping all programs, so that those of its start are the third's to compile.
    for _ in range(3):
        solved(paper, 12)
    with compilations() as compiled:
        solved(robot, steps)
        assert not compiled
        # The list does tell of compilations.
        jax.jit(lambda x: 3.0 * x + 2.0)(0.5)
        assert compiled
