"""The stability index against chains of rigid links, closed forms, and the sensitivity."""

import dataclasses
import json
import pathlib

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cpr_jax as cpr
from cpr_jax.analysis.stability import stability
from cpr_jax.robots.catalogue import rfrfr_straight, three_rfr
from cpr_jax.robots.embedding import in_space
from cpr_jax.statics.equilibrium import Equilibrium
from cpr_jax.statics.problem import Problem, forward_rows, inverse_rows
from cpr_jax.statics.roots import find_root
from cpr_jax.statics.status import Status
from cpr_jax.statics.unknowns import unravel
from tests.oracles import discrete_stability
from tests.statics.common import in_space_unknowns, like_rfrfr

CASE = json.loads((pathlib.Path(__file__).parents[1] / "reference_cases.json").read_text())[
    "buckling_t2"
]


def at(robot, y) -> Equilibrium:
    """The equilibrium with the unknowns `y`, of which the stability needs no more."""
    state = unravel(robot, y)
    return Equilibrium(
        *state,
        base_wrenches=state.mu,
        status=jnp.asarray(0),
        residual=jnp.asarray(0.0),
        measures=None,
        branch="given",
    )


def in_blocks(function, lanes):
    """Batches of any length by one compiled program for `lanes` of them."""
    compiled = eqx.filter_jit(
        lambda robot, *args: jax.vmap(lambda *args: function(robot, *args))(*args),
        compiler_options={"xla_backend_optimization_level": 1},
    )

    def batch(robot, *args):
        count = len(args[0])
        rows = np.resize(np.arange(count), -(-count // lanes) * lanes).reshape(-1, lanes)
        parts = [compiled(robot, *(np.asarray(arg)[block] for arg in args)) for block in rows]
        return jax.tree.map(lambda *leaves: np.concatenate(leaves)[:count], *parts)

    return batch


def _solved(robot, imposed, y):
    problem = Problem(robot, imposed, y[: robot.n_a + robot.n_p])
    return find_root(problem, y, max_iterations=40, verify=False)


FEW = 40
solved = in_blocks(_solved, 400)
judged = in_blocks(lambda robot, y: stability(robot, at(robot, y)), FEW)
linearised = in_blocks(
    lambda robot, y: cpr.sensitivity(robot, at(robot, y)).platform_stiffness, FEW
)


def random_starts(robot, seed, count, place, turn, force):
    """Unknowns at random that satisfy the balance of the platform and of the moments of legs.

    **Arguments:**

    - `count`: how many.
    - `place`, `turn`: how far the platform is from the middle of the motors, in rod lengths, and
        from its home, rad.
    - `force`: largest force along an axis, in units of `k_b / l²`.
    """
    rng = np.random.default_rng(seed)
    chains = discrete_stability.read(robot)
    n, n_p, length = robot.n, robot.n_p, np.mean(chains.length)
    middle = np.mean(chains.base) + (0.0 if robot.oriented else 0.4j * length)
    point = middle + place * length * (rng.uniform(-1, 1, (count, 2)) @ [1.0, 1.0j])
    angle = turn * rng.uniform(-1, 1, count)
    arms = np.exp(1j * angle)[:, None] * chains.attachment
    ends = point[:, None] + arms
    q = np.angle(ends - chains.base) - chains.heading + rng.uniform(-1, 1, (count, n))

    forces = (
        force * np.mean(chains.k_b[:, 0] / chains.length**2) * rng.uniform(-1, 1, (count, 2 * n))
    )
    balance = np.zeros((count, 3, 2 * n))
    balance[:, 0, 0::2] = balance[:, 1, 1::2] = 1.0
    balance[:, 2, 0::2], balance[:, 2, 1::2] = -arms.imag, arms.real
    balance = balance[:, :n_p]
    load = np.array([chains.force.real, chains.force.imag, chains.moment])[:n_p]
    excess = np.einsum("kij,kj->ki", balance, forces) - load
    forces = (forces - np.einsum("kij,kj->ki", np.linalg.pinv(balance), excess)).reshape(-1, n, 2)

    levers = ends - chains.base - chains.a * np.exp(1j * (q + chains.heading))
    moments = np.imag(np.conj(levers) * (forces @ [1.0, 1.0j]))
    wrenches = np.concatenate([forces, moments[:, :, None]], axis=2).reshape(count, -1)
    pose = np.stack([point.real, point.imag, angle], axis=1)[:, :n_p]
    return np.concatenate([q, pose, wrenches], axis=1)


def random_equilibria(robot, count, *, held, free):
    """Equilibria near random starts, half with the motors held and half with the platform."""
    y = [random_starts(robot, seed, count // 2, **how) for seed, how in enumerate((held, free))]
    rows = np.repeat([forward_rows(robot), inverse_rows(robot)], count // 2, axis=0)
    found = solved(robot, rows, np.concatenate(y))
    return found.y[found.status == Status.SOLVED]


@pytest.fixture(scope="module")
def two_legs(robot):
    anywhere = {"place": 0.3, "turn": 0.0}
    return robot, random_equilibria(
        robot, 2800, held={**anywhere, "force": 60.0}, free={**anywhere, "force": 30.0}
    )


@pytest.fixture(scope="module")
def triangle():
    """The 3-RFR robot. Without weight, but compiled with it, as the robot that has it."""
    robot = three_rfr()
    rod = dataclasses.replace(robot.legs.rod, force=jnp.zeros((3, 2)))
    return eqx.tree_at(lambda r: r.legs.rod, robot, rod)


@pytest.fixture(scope="module")
def three_legs(triangle):
    anywhere = {"place": 0.2, "turn": 1.5}
    return triangle, random_equilibria(
        triangle, 2400, held={**anywhere, "force": 10.0}, free={**anywhere, "force": 5.0}
    )


@pytest.fixture(scope="module")
def all_features(triangle):
    """Three unlike legs with weight, bent rigid segments and a clamped joint."""
    robot = eqx.tree_at(
        lambda r: (
            r.m_P,
            r.legs.a,
            r.legs.b,
            r.legs.base_rotation,
            r.legs.attachment_rotation,
            r.legs.joint.free,
            r.legs.rod.length,
            r.legs.rod.curvature_compliance,
            r.legs.rod.precurvature,
            r.legs.rod.force,
        ),
        triangle,
        (
            jnp.array([0.02]),
            jnp.array([[0.02, 0.01], [0.03, -0.01], [0.0, 0.02]]),
            jnp.array([[0.02, -0.01], [0.01, 0.01], [0.02, 0.0]]),
            jnp.array([[0.3], [-0.4], [0.1]]),
            jnp.array([[0.3], [2.0], [1.0]]),
            jnp.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
            jnp.array([0.4, 0.5, 0.35]),
            1.0 / jnp.array([[0.0183], [0.03], [0.01]]),
            jnp.array([[2.0], [-1.0], [0.0]]),
            jnp.array([[0.2, -0.5], [0.0, -0.8], [0.3, 0.4]]),
        ),
    )
    anywhere = {"place": 0.3, "turn": 2.0, "force": 15.0}
    return robot, random_equilibria(robot, 2400, held=anywhere, free=anywhere)


def by_chains(robot, y, links=240):
    n_a, n_q = robot.n_a, robot.n_a + robot.n_p
    return discrete_stability.judge(
        discrete_stability.read(robot),
        y[:, :n_a],
        y[:, n_a:n_q],
        y[:, n_q:].reshape(-1, robot.n, 3),
        links,
    )


@pytest.mark.parametrize(
    ("which", "least", "unstable", "twice"),
    [("two_legs", 500, 200, 20), ("three_legs", 500, 100, 10), ("all_features", 80, 10, 0)],
)
def test_index_of_random_equilibria(which, least, unstable, twice, request):
    robot, y = request.getfixturevalue(which)
    chains = by_chains(robot, y)
    # Next to a singularity the discretisation decides, if it does not lose the equilibrium.
    sure = ~chains.doubtful & (chains.moved < 0.01)
    result = judged(robot, y)
    np.testing.assert_array_equal(result.index[sure], chains.index[sure])
    np.testing.assert_array_equal(result.leg_indices[sure], chains.leg_indices[sure])
    np.testing.assert_array_equal(result.stable, result.index == 0)
    assert np.mean(sure) > 0.95
    assert np.sum(sure) >= least
    assert np.sum(chains.index[sure] >= 1) >= unstable
    assert np.sum(chains.index[sure] >= 2) >= twice


def gentle(robot, y):
    """Equilibria with the least forces: the more there is, the less accurate is integration."""
    forces = y[:, robot.n_a + robot.n_p :].reshape(len(y), -1, 3)[:, :, :2]
    return y[np.argsort(np.max(np.abs(forces), axis=(1, 2)))[:FEW]]


@pytest.mark.parametrize("which", ["two_legs", "three_legs", "all_features"])
def test_platform_stiffness(which, request):
    robot, y = request.getfixturevalue(which)
    few = gentle(robot, y)
    K = judged(robot, few).platform_stiffness
    size = np.max(np.abs(K), axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(K / size, np.swapaxes(K, 1, 2) / size, rtol=0, atol=1e-12)
    np.testing.assert_allclose(K / size, linearised(robot, few) / size, rtol=0, atol=1e-8)
    coarse, fine = (by_chains(robot, few[::8], links).stiffness for links in (120, 240))
    extrapolated = (4.0 * fine - coarse) / 3.0
    np.testing.assert_allclose(K[::8] / size[::8], extrapolated / size[::8], rtol=0, atol=1e-5)


def test_index_jumps_by_two_where_both_legs_buckle():
    robot = like_rfrfr(rfrfr_straight())
    height = np.sqrt(0.96)
    angles = np.arctan2([height, height], [0.2, -0.2])
    along = np.stack([np.cos(angles), np.sin(angles), [0.0, 0.0]], axis=1)
    for factor, index in ((1.0 - 1e-5, 0), (1.0 + 1e-5, 2)):
        load = factor * CASE["critical_downward_force_N"]
        loaded = dataclasses.replace(robot, f_P=jnp.array([0.0, -load]))
        wrenches = -load / (2.0 * height) * along
        y = jnp.concatenate([angles, jnp.array([0.0, height]), wrenches.reshape(-1)])
        result = judged(loaded, y[None])
        assert result.index[0] == index
        np.testing.assert_array_equal(result.leg_indices[0], [index // 2, index // 2])


def columns(robot, wrenches, free):
    """A robot with straight rods of length 1 and stiffness 1, and its unknowns.

    The wrenches at the bases are in the axes of the rods.
    """
    geometry = robot.geometry
    legs = robot.legs
    straight = eqx.tree_at(
        lambda r: (
            r.legs.rod.length,
            r.legs.rod.curvature_compliance,
            r.legs.rod.precurvature,
            r.legs.joint.free,
        ),
        robot,
        (
            jnp.ones(3),
            jnp.ones_like(legs.rod.curvature_compliance),
            jnp.zeros_like(legs.rod.precurvature),
            jnp.tile(jnp.asarray(free, float), (3, 1)),
        ),
    )

    def world(rotation, wrench):
        axes = geometry.rows(geometry.exp(rotation))
        force = geometry.rotate(axes, wrench[: geometry.d])
        moment = geometry.to_outer(axes, wrench[geometry.d :])
        return jnp.stack([*force, *moment])

    mu = jax.vmap(world)(legs.base_rotation, jnp.asarray(wrenches, float))
    y = jnp.concatenate([jnp.zeros(robot.n_a + robot.n_p), mu.reshape(-1)])
    return straight, y


# Roots of sin(u/2) (tan(u/2) - u/2) and of tan(u) - u: u² is the critical force of a column with
# both ends clamped, and with one of them on a pivot.
CLAMPED = np.array([2.0 * np.pi, 8.9868189, 4.0 * np.pi, 15.4505037]) ** 2
PIVOTED = np.array([4.4934095, 7.7252518, 10.9041217, 14.0661939]) ** 2


@pytest.mark.parametrize("force", [-300.0, 10.0, 20.19, 20.20, 50.0, 100.0, 200.0])
def test_columns_in_the_plane(triangle, force):
    """Leg indices of Euler's columns, under tension too."""
    for free, critical in (([0, 0, 0], CLAMPED), ([0, 0, 1], PIVOTED)):
        robot, y = columns(triangle, [[-force, 0.0, 0.0]] * 3, free)
        result = judged(robot, y[None])
        np.testing.assert_array_equal(result.leg_indices[0], np.sum(critical < force))


@pytest.fixture(scope="module")
def spatial():
    return in_space(three_rfr())


@pytest.mark.parametrize("force", [-300.0, 10.0, 20.19, 20.20, 50.0, 100.0, 200.0])
def test_columns_in_space(spatial, force):
    """Each way to buckle counts twice, but for a pivot, which is free about one axis."""
    clamped, pivoted = np.sum(force > CLAMPED), np.sum(force > PIVOTED)
    wrenches = [[-force, 0.0, 0.0, 0.0, 0.0, 0.0]] * 3
    for free, index in (
        ([0, 0, 0, 0, 0, 0], 2 * clamped),
        ([0, 0, 0, 0, 0, 1], clamped + pivoted),
        ([0, 0, 0, 1, 1, 1], 2 * pivoted),
    ):
        robot, y = columns(spatial, wrenches, free)
        np.testing.assert_array_equal(judged(robot, y[None]).leg_indices[0], index)


@pytest.mark.parametrize(("moment", "index"), [(8.98, 0), (8.99, 2), (15.4, 2), (15.5, 4)])
def test_shafts(spatial, moment, index):
    """Greenhill's twisted rod with clamped ends buckles where tan(M/2) = M/2."""
    for sign in (-1.0, 1.0):
        wrenches = [[0.0, 0.0, 0.0, sign * moment, 0.0, 0.0]] * 3
        robot, y = columns(spatial, wrenches, [0] * 6)
        np.testing.assert_array_equal(judged(robot, y[None]).leg_indices[0], index)


def test_planar_robot_in_space(three_legs, spatial):
    robot, y = three_legs
    few = gentle(robot, y)
    plane = judged(robot, few)
    space = judged(spatial, jax.vmap(lambda y: in_space_unknowns(spatial, y))(few))
    K = space.platform_stiffness
    size = np.max(np.abs(K), axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(K / size, np.swapaxes(K, 1, 2) / size, rtol=0, atol=1e-12)
    block = K[:, 1:4, 1:4]
    np.testing.assert_allclose(block / size, plane.platform_stiffness / size, rtol=0, atol=1e-8)
    across = K[:, 1:4][:, :, [0, 4, 5]]
    np.testing.assert_allclose(across / size, 0.0, rtol=0, atol=1e-10)
    assert np.all(space.index >= plane.index)


def test_pushed_out_of_its_plane(spatial):
    """The stiffness undoes what small loads do, where pivots carry moments across their axes."""
    loads = np.vstack([np.zeros(6), *(s * np.diag([1e-4] * 3 + [1e-5] * 3) for s in (1.0, -1.0))])
    steady = np.pad(spatial.f_P + np.array([0.3, 0.1, 0.0]), (0, 3))
    home = spatial.home
    n_q = spatial.n_a + spatial.n_p
    start = jnp.concatenate([home.q_a, home.q_p, jnp.zeros(spatial.n_y - n_q)])

    @jax.jit
    @jax.vmap
    def solve(load):
        loaded = dataclasses.replace(spatial, f_P=load[:3], m_P=load[3:])
        problem = Problem(loaded, forward_rows(spatial), start[:n_q])
        return find_root(problem, start, verify=False)

    found = solve(jnp.asarray(steady + loads))
    assert np.all(found.status == Status.SOLVED)
    n_a = spatial.n_a
    poses = np.array(found.y[:, n_a:n_q])
    turns = Rotation.from_rotvec(poses[:, 3:])
    moved = np.hstack([poses[1:7, :3] - poses[7:, :3], (turns[1:7] * turns[7:].inv()).as_rotvec()])
    compliance = moved.T / (2.0 * np.max(loads, axis=1)[1:7])
    K = judged(spatial, found.y[:1]).platform_stiffness[0]
    np.testing.assert_allclose(K @ compliance, np.eye(6), rtol=0, atol=1e-5)
    assert np.max(np.abs(found.y[0, n_q:].reshape(3, 6)[:, 4:])) > 1e-2


def test_no_equilibrium(two_legs):
    robot, y = two_legs
    some = np.array(y[:6])
    some[1], some[4, -1] = np.nan, np.nan
    result = judged(robot, some)
    lost = np.array([False, True, False, False, True, False])
    np.testing.assert_array_equal(result.index == -1, lost)
    np.testing.assert_array_equal(result.leg_indices == -1, np.stack([lost, lost], axis=1))
    assert not np.any(result.stable[lost])


def test_its_stiffness_has_no_derivatives(robot, equilibria):
    """And says so: the zeros of a constant would be wrong."""

    def stiffness(load):
        return cpr.stability(dataclasses.replace(robot, f_P=load), equilibria[0.06, 0.15])

    found = jax.jit(lambda load: jax.jvp(stiffness, (load,), (load,)))(robot.f_P)
    value, slope = (part.platform_stiffness for part in found)
    assert np.all(np.isfinite(value)) and np.all(np.isnan(slope))
