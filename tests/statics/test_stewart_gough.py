"""Six-leg robots of other people's programs, from a cold start."""

import dataclasses
import json
import pathlib

import jax
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cpr_jax.analysis.stability import stability
from cpr_jax.geometry import floats
from cpr_jax.robots.catalogue_space import stewart_gough, stewart_gough_clamped
from cpr_jax.statics.residual import residual
from cpr_jax.statics.solve import solve_forward, solve_inverse
from cpr_jax.statics.status import Status
from cpr_jax.statics.unknowns import unknown_scales, unravel
from tests.oracles import stewart_gough as oracle

CASES = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())
TILT = np.deg2rad(10.0)


@pytest.fixture(scope="module")
def orientation():
    return Rotation.from_rotvec([0.0, TILT, 0.0]).as_matrix()


def test_the_published_case(orientation):
    """The oracle is the published program; its digits belong to the row that it prints."""
    case = CASES["stewart_gough_till"]
    lengths, wrenches = oracle.inverse(np.array(case["pose"]["p"]), orientation, printed=True)
    np.testing.assert_allclose(lengths, case["lengths"], rtol=0, atol=5e-10)
    np.testing.assert_allclose(wrenches[0, :3], case["leg_1"]["n_base"], rtol=0, atol=5e-8)
    np.testing.assert_allclose(wrenches[0, 3:], case["leg_1"]["m_base"], rtol=0, atol=5e-8)


@pytest.fixture(scope="module")
def robot():
    return stewart_gough()


@pytest.fixture(scope="module")
def solved(robot):
    return solve_inverse(robot, (0.0, 0.0, 0.4, 0.0, TILT, 0.0))


def test_the_robot_with_a_free_twist(solved, orientation):
    """Lengths and base wrenches of the oracle with the row of a joint."""
    assert int(solved.status) == Status.SOLVED
    lengths, wrenches = oracle.inverse(np.array([0.0, 0.0, 0.4]), orientation)
    np.testing.assert_allclose(0.4 + solved.q_a, lengths, rtol=0, atol=1e-9)
    np.testing.assert_allclose(solved.base_wrenches, wrenches, rtol=0, atol=1e-7)


def test_conditioning_does_not_depend_on_how_the_orientation_is_written(robot, solved):
    """As what it is: the slopes of the residual along small rotations, by differences."""
    there = np.array([0.0, 0.0, 0.4, 0.0, TILT - 2.0 * np.pi, 0.0])
    again = solve_inverse(robot, there, guess=dataclasses.replace(solved, q_p=floats(there)))
    np.testing.assert_allclose(again.q_a, solved.q_a, rtol=0, atol=1e-10)
    units = np.asarray(unknown_scales(robot))
    rows = jax.jit(lambda y: residual(robot, unravel(robot, y)))
    begin, step = np.asarray(solved.y), 1e-5

    def moved(k, by):
        y = begin.copy()
        if 9 <= k < 12:
            turned = Rotation.from_rotvec(by * np.eye(3)[k - 9]) * Rotation.from_rotvec(y[9:12])
            y[9:12] = turned.as_rotvec()
        else:
            y[k] += by * units[k]
        return np.asarray(rows(y))

    columns = [(moved(k, step) - moved(k, -step)) / (2.0 * step) for k in range(6, len(begin))]
    sizes = np.linalg.svd(np.stack(columns, axis=1))[1]
    for measures in (solved.measures, again.measures):
        assert float(measures.sigma_t2) == pytest.approx(sizes[-1], rel=1e-5)
        assert float(measures.condition) == pytest.approx(sizes[0] / sizes[-1], rel=1e-5)
    assert float(again.measures.sigma_t2) == pytest.approx(
        float(solved.measures.sigma_t2), rel=1e-9
    )
    assert float(again.measures.sign_t2) == float(solved.measures.sign_t2)


def test_its_stiffness_is_symmetric(robot, solved):
    """So is that of every robot whose parts are all conservative."""
    found = stability(robot, solved)
    stiffness = np.asarray(found.platform_stiffness)
    size = np.abs(stiffness)[np.diag_indices(6)]
    scale = np.sqrt(size[:, None] * size)
    np.testing.assert_allclose(stiffness / scale, stiffness.T / scale, rtol=0, atol=1e-8)
    assert int(found.index) == 0


def test_forward_and_inverse_agree(robot, solved):
    forward = solve_forward(robot, solved.q_a)
    np.testing.assert_allclose(forward.q_p, solved.q_p, rtol=0, atol=1e-10)


def test_rods_that_spin_in_their_base():
    """The passive joints turn as the platform does, and carry no moment about the rods."""
    robot = stewart_gough_clamped()
    case = CASES["six_rod_clamped"]
    straight = solve_forward(robot, np.zeros(6))
    np.testing.assert_allclose(straight.q_p[:3], case["forward"]["p"], rtol=0, atol=1e-9)
    twisted = solve_forward(robot, np.array([0.03, 0.0, 0.03, 0.0, 0.05, 0.0]))
    np.testing.assert_allclose(twisted.base_wrenches[:, 5], 0.0, rtol=0, atol=1e-12)
    assert np.all(np.abs(twisted.mu[:, 3]) > 0.01), "they turn"


def test_a_robot_that_hangs_is_turned_by_the_shorter_way(robot, solved):
    """Rotation vectors of less than half a turn lie all around where its home is."""
    upside = Rotation.from_rotvec([np.pi - 1e-3, 0.0, 0.0])

    def moved(vectors):
        return floats(upside.apply(np.array(vectors)))

    def turned(rotations):
        return floats((upside * Rotation.from_rotvec(np.array(rotations))).as_rotvec())

    legs, loads, home = robot.legs, robot.loads, robot.home
    rod = dataclasses.replace(legs.rod, force=moved(legs.rod.force))
    hanging = dataclasses.replace(
        robot,
        legs=dataclasses.replace(
            legs,
            base_position=moved(legs.base_position),
            base_rotation=turned(legs.base_rotation),
            rod=rod,
        ),
        loads=dataclasses.replace(loads, force=moved(loads.force)),
        home=dataclasses.replace(
            home, q_p=floats(np.concatenate([moved(home.q_p[:3]), turned(home.q_p[3:])]))
        ),
    )
    asked = (upside * Rotation.from_rotvec([TILT, 0.0, 0.0])).as_rotvec()
    assert np.linalg.norm(asked - hanging.home.q_p[3:]) > 1.9 * np.pi
    found = solve_inverse(hanging, np.concatenate([moved((0.0, 0.0, 0.4)), asked]))
    upright = solve_inverse(robot, (0.0, 0.0, 0.4, TILT, 0.0, 0.0))
    np.testing.assert_allclose(found.q_a, upright.q_a, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.q_p[3:], asked, rtol=0, atol=1e-12)
