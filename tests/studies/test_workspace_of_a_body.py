"""A map of a robot whose platform has an orientation, which is held."""

import json

import numpy as np

from cpr_jax.robots.catalogue import three_rfr
from cpr_jax.statics.equilibrium import solve_inverse
from cpr_jax.studies.workspace import workspace_map


def test_a_platform_with_an_orientation_keeps_it():
    robot = three_rfr()
    seed = solve_inverse(robot, robot.home.q_p)
    dataset = workspace_map(robot, seed, spacing=0.02, box=((-0.06, -0.06), (0.06, 0.06)))
    assert dict(dataset.sizes)["motor"] == 3
    (held,) = json.loads(dataset.attrs["held"]).items()
    assert held == ("phi_P_x", float(seed.q_p[2]))
    assert np.sum(dataset["index"].values >= 0) > 20
    assert dataset["Pi_p"].shape[2] == 3
    # One cell beside a solve of its own from the seed.
    cell = dataset.sel(y=0.02, z=-0.02, method="nearest")
    point = (float(cell["y"]), float(cell["z"]), held[1])
    single = solve_inverse(robot, point, guess=seed)
    np.testing.assert_allclose(cell["q_a"], single.q_a, rtol=0, atol=1e-9)
    np.testing.assert_allclose(cell["motor_torque"], single.motor_torques, rtol=0, atol=1e-9)
