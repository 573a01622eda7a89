"""Monte Carlo and maps of a robot whose rods have several segments."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select
from cpr_jax.robots.catalogue import rfrfr
from tests.oracles import cosserat
from tests.oracles.whole_robot import unbalanced
from tests.statics.segmented import stepped

DELTA = {"k_b1_1": 3e-3, "k_b1_2": 5e-3, "l1_2": 2e-3, "kappa2_2": 0.2, "l2_1": 2e-3}
JUNCTION = 0.6


@pytest.fixture(scope="module")
def robot():
    return stepped(rfrfr(), [(JUNCTION, 1.0 - JUNCTION)] * 2, seed=4, spread=0.5)


def test_samples_are_equilibria(robot):
    """Every 40th sample, solved by itself and balanced by an independent integration."""
    nominal = cpr.solve_inverse(robot, (0.03, 0.18))
    study = cpr.monte_carlo(robot, nominal, 400, parameters=list(DELTA), delta=DELTA)
    assert (study.solved, study.lost, study.failed) == (400, 0, 0)
    assert 0.95 < study.coverage <= 1.0
    selection = select(robot, list(DELTA))

    @jax.jit
    def solve(rho):
        varied = selection.set(robot, rho)
        return varied, cpr.solve_forward(varied, nominal.q_a, guess=nominal)

    for k in range(0, 400, 40):
        varied, found = solve(jnp.asarray(study.rho[k]))
        np.testing.assert_allclose(study.q_p[k], found.q_p, rtol=0, atol=1e-8)
        assert unbalanced(varied, found.y) < 1e-8


@pytest.fixture(scope="module")
def mapped(robot):
    box = ((0.0, 0.15), (0.06, 0.21))
    return cpr.workspace_map(robot, parameters=list(DELTA), delta=DELTA, spacing=0.03, box=box)


def test_curvature_and_moment_of_cells(robot, mapped):
    """The largest along the rods, where a junction has two curvatures; by scipy."""
    rod = robot.legs.rod
    for cell in (mapped.isel(y=i, z=j) for i in range(2) for j in range(2)):
        curvatures, moments = [], []
        for leg in range(2):
            q = float(cell["q_a"][leg])
            n_y, n_z, m = np.asarray(cell["mu"][leg])
            turn = np.array([[np.cos(q), np.sin(q)], [-np.sin(q), np.cos(q)]])
            force, moment = np.pad(turn @ (n_y, n_z), (0, 1)), np.array([0.0, 0.0, m])
            frame = np.eye(3)
            for j, share in enumerate((JUNCTION, 1.0 - JUNCTION)):
                part, at = (rod, leg) if j == 0 else (rod.further, (leg, 0))
                c = float(part.curvature_compliance[at][0])
                rest = float(part.precurvature[at][0])
                local = cosserat.SpatialRod(
                    0.25 * share,
                    np.array([1.0, 1.0, c]),
                    np.array([0.0, 0.0, rest]),
                    load=frame.T @ np.pad(turn @ np.asarray(part.force[at]), (0, 1)),
                )
                s = np.linspace(0.0, local.length, 11)
                _, R, n, m_s, *_ = cosserat.integrate(local, frame.T @ force, moment, s)
                curvatures.append(np.max(np.abs(c * m_s[:, 2] + rest)))
                moments.append(np.max(np.abs(m_s[:, 2])))
                force, moment, frame = frame @ n[-1], m_s[-1], frame @ R[-1]
        np.testing.assert_allclose(float(cell["curvature"]), max(curvatures), rtol=1e-7)
        np.testing.assert_allclose(float(cell["moment"]), max(moments), rtol=1e-7)
