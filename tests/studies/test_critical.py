"""Critical values beside the analytic buckling load."""

import dataclasses
import json
import pathlib

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.errors import InputError
from cpr_jax.robots.catalogue import rfrfr_straight
from cpr_jax.statics.equilibrium import solve_inverse
from cpr_jax.studies.critical import critical_value

CASE = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())[
    "buckling_t2"
]


@pytest.fixture(scope="module")
def compressed():
    """The straight robot with its apex at (0, √0.96), its legs straight under a load of 1 N."""
    robot = dataclasses.replace(rfrfr_straight(), f_P=jnp.array([0.0, -1.0]))
    apex = np.array([0.0, np.sqrt(0.96)])
    ways = apex - np.asarray(robot.legs.base_position)
    angles = np.arctan2(ways[:, 1], ways[:, 0])
    forces = -0.5 / np.sin(angles[0]) * ways
    solved = solve_inverse(robot, (0.0, 0.9))
    exact = jnp.asarray(angles), jnp.asarray(apex), jnp.asarray(np.column_stack([forces, [0, 0]]))
    return robot, eqx.tree_at(lambda e: (e.q_a, e.q_p, e.mu), solved, exact)


def test_two_legs_buckle_together(compressed):
    """The determinant keeps its sign there; the index does not."""
    robot, equilibrium = compressed
    found = critical_value(robot, equilibrium, "f_P_z", -9.0)
    assert found.value == pytest.approx(-CASE["critical_downward_force_N"], rel=1e-6)
    assert (found.before, found.after) == (0, 2)
    np.testing.assert_allclose(found.y[:4], [*equilibrium.q_a, *equilibrium.q_p], atol=1e-9)


def test_nothing_happens_before_the_load(compressed):
    robot, equilibrium = compressed
    found = critical_value(robot, equilibrium, "f_P_z", -6.0)
    assert np.isnan(found.value)
    assert found.before == found.after == 0


@pytest.mark.parametrize(
    ("parameter", "stop"), [("f_P_z", -1.0), ("f_P_z", np.nan), ("f_P_q", 1.0)]
)
def test_mistakes_are_named(compressed, parameter, stop):
    with pytest.raises(InputError, match=r"stop|f_P_q"):
        critical_value(*compressed, parameter, stop)
