"""Corrections that eliminate leg by leg, beside dense linear algebra and `jax.jacfwd`."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.robots.catalogue import rfrfr, rfrfr_straight, three_pfr
from cpr_jax.robots.catalogue_space import three_rfs
from cpr_jax.rods.solver import Scheme
from cpr_jax.statics.accuracy import MENU
from cpr_jax.statics.correction import _correct, _rough, linearised, settle
from cpr_jax.statics.correction import values as values_of_lanes
from cpr_jax.statics.linear import eliminated_but_one
from cpr_jax.statics.problem import Problem, forward_rows, full_residual
from cpr_jax.statics.solve import solve_forward
from cpr_jax.statics.unknowns import unknown_scales

STEPS = 2
RNG = np.random.default_rng(0)
ROBOTS = [rfrfr, rfrfr_straight, three_pfr, three_rfs]

linear = jax.jit(linearised, static_argnums=2)
corrected = jax.jit(_correct, static_argnums=(3, 4))


def problem_of(robot):
    """Any target and offset: nothing here needs an equilibrium."""
    n_q = robot.n_a + robot.n_p
    target, offset = RNG.normal(size=n_q), RNG.normal(size=robot.n_y - robot.n_a)
    return Problem(robot, forward_rows(robot), jnp.asarray(target), jnp.asarray(offset))


@pytest.mark.parametrize("scheme", [*MENU, Scheme(5), Scheme(10), Scheme(20)])
def test_the_jacobian_of_chords_takes_no_more_work_than_they_do(scheme):
    rough = Scheme(*np.asarray(_rough(np.asarray(scheme))))
    assert rough.work <= scheme.work
    assert rough == scheme or rough.work >= Scheme(2, 8, 8).work


@pytest.mark.parametrize("make", ROBOTS)
def test_values_and_jacobian_beside_automatic_ones(make):
    robot = make()
    problem, y = problem_of(robot), jnp.asarray(0.3 * RNG.normal(size=robot.n_y))

    def residual(y):
        return full_residual(y, problem, STEPS)

    values, matrix = linear(problem, y, STEPS)
    whole = jax.jit(lambda y: (residual(y), jax.jacfwd(residual)(y)))
    expected_values, expected = whole(y)
    np.testing.assert_allclose(values, expected_values, rtol=0, atol=1e-12)
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(matrix, expected, rtol=0, atol=1e-13 * scale)


@pytest.mark.parametrize("make", ROBOTS)
def test_values_of_a_batch_and_their_derivative_beside_those_of_one_case(make):
    robot = make()
    problem, ys = problem_of(robot), jnp.asarray(0.3 * RNG.normal(size=(3, robot.n_y)))

    def one(y):
        return values_of_lanes(problem, y, STEPS, robot)

    def plain(y):
        return full_residual(y, problem, STEPS)

    found, expected = jax.jit(jax.vmap(one))(ys), jax.jit(jax.vmap(plain))(ys)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    slope, expected = jax.jit(jax.jacfwd(one))(ys[0]), jax.jit(jax.jacfwd(plain))(ys[0])
    np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-13 * np.max(np.abs(expected)))


@pytest.mark.parametrize("make", ROBOTS)
def test_units_of_another_robot_scale_the_rows_and_nothing_else(make):
    robot = make()
    length = robot.legs.rod.length
    other = eqx.tree_at(lambda robot: robot.legs.rod.length, robot, 1.3 * length)
    problem = dataclasses.replace(problem_of(robot), offset=None)
    ys = 0.3 * RNG.normal(size=(3, robot.n_y)) * unknown_scales(robot)

    def rows(units):
        solve = jax.vmap(lambda y: values_of_lanes(problem, y, STEPS, units))
        return np.asarray(jax.jit(solve)(ys / unknown_scales(units)))

    own, foreign = rows(robot), rows(other)
    ratios = foreign / own
    np.testing.assert_allclose(ratios, np.broadcast_to(ratios[0], ratios.shape), rtol=1e-9)
    # Lengths by 1.3, forces by 1 / 1.3², moments by 1 / 1.3, angles by 1.
    expected = np.array([1.0 / 1.3, 1.3**2, 1.3, 1.0])
    assert np.all(np.min(np.abs(ratios[0][:, None] / expected - 1.0), axis=1) < 1e-9)


@pytest.mark.parametrize("make", ROBOTS)
@pytest.mark.parametrize("bent", [True, False], ids=["bent", "at rest"])
def test_one_correction_solves_the_linear_system(make, bent):
    """Also while rods are straight, when the block of a leg by itself is singular."""
    robot = make()
    problem = problem_of(robot)
    y = 0.3 * RNG.normal(size=robot.n_y)
    if not bent:
        y[robot.n_a + robot.n_p :] = 0.0
    rights = jnp.asarray(RNG.normal(size=(robot.n_y, 2)))
    values, matrix = (np.asarray(part) for part in linear(problem, jnp.asarray(y), STEPS))
    found = corrected(problem, jnp.asarray(y), rights, STEPS, 0)
    size = np.linalg.cond(matrix)
    np.testing.assert_allclose(matrix @ (found.y - y), -values, rtol=0, atol=1e-14 * size)
    np.testing.assert_allclose(matrix @ found.slope, rights, rtol=0, atol=1e-14 * size)
    assert float(found.sign) == np.linalg.slogdet(matrix)[0]
    np.testing.assert_allclose(found.residual, np.max(np.abs(values)), rtol=1e-12)


def test_batches_over_any_part_of_a_problem():
    """Lanes in the unknowns, in one number of the robot, or in both give what single cases do."""
    robot = rfrfr()
    problem, y = problem_of(robot), jnp.asarray(0.3 * RNG.normal(size=robot.n_y))
    rights = jnp.asarray(RNG.normal(size=(robot.n_y, 1)))
    factors = jnp.asarray(RNG.uniform(0.9, 1.1, 4))

    def one(place, start):
        legs = dataclasses.replace(robot.legs, attachment_position=place * jnp.ones((2, 2)))
        varied = dataclasses.replace(robot, legs=legs, f_P=place * robot.f_P)
        return _correct(dataclasses.replace(problem, robot=varied), start * y, rights, STEPS, 2)

    alone = jax.jit(one)
    single = [alone(a, b) for a, b in zip(factors, factors, strict=True)]
    for in_axes, picked in (((0, 0), range(4)), ((0, None), [0]), ((None, 0), [0])):
        given = [factors if axis == 0 else factors[0] for axis in in_axes]
        batch = jax.jit(jax.vmap(one, in_axes=in_axes))(*given)
        for k in picked:
            expected = jax.tree.leaves(single[k])
            lane = [leaf[k] for leaf in jax.tree.leaves(batch)]
            for a, b in zip(lane, expected, strict=True):
                np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)


def test_chords_lead_to_the_same_root_and_far_guesses_are_given_up():
    robot = rfrfr()
    assert robot.home is not None
    known = solve_forward(robot, robot.home.q_a + 0.05)
    root_y = known.y / unknown_scales(robot)
    problem = Problem(robot, forward_rows(robot), jnp.append(known.q_a, known.q_p))
    none = jnp.zeros((robot.n_y, 0))

    def settled(guess, chords, **options):
        return jax.jit(lambda y: settle(problem, y, none, 10, chords, **options))(guess)

    near = root_y + 1e-3 * RNG.normal(size=robot.n_y)
    for root in (settled(near, 0), settled(near, 2)):
        assert bool(root.converged)
        np.testing.assert_allclose(root.y, root_y, rtol=0, atol=1e-9)
    # From farther away it would converge too, but nobody could tell to which branch.
    far = root_y + 0.05
    assert not bool(settled(far, 0).converged)
    wide = settled(far, 0, reach=10.0)
    assert bool(wide.converged)
    np.testing.assert_allclose(wide.y, root_y, rtol=0, atol=1e-9)


@pytest.mark.parametrize("n", [1, 2, 3, 6])
def test_elimination_of_all_unknowns_but_one(n):
    """Beside numpy, on regular systems and on one that has the rank n - 1."""
    matrix, rights = RNG.normal(size=(n, n, 70)), RNG.normal(size=(n, 2, 70))
    matrix[:, :, 3] = 0.0
    left, right = RNG.normal(size=(2, n, max(n - 1, 1)))
    if n > 1:
        matrix[:, :, 3] = left @ right.T
    found = eliminated_but_one(jnp.asarray(matrix), jnp.asarray(rights))
    free = found.left / found.own
    x = np.asarray(found.solved + found.weak[:, None] * free)
    for k in (0, 1, 2, 69):
        expected = np.linalg.solve(matrix[..., k], rights[..., k])
        np.testing.assert_allclose(x[..., k], expected, rtol=1e-9, atol=1e-9)
        sign = np.linalg.slogdet(matrix[..., k])[0]
        assert float(found.sign[k] * np.sign(found.own[k])) == sign
    assert abs(float(found.own[3])) < 1e-13
    np.testing.assert_allclose(matrix[..., 3] @ found.weak[:, 3], 0.0, rtol=0, atol=1e-12)
    assert np.all(np.isfinite(found.solved[..., 3]))


@pytest.mark.parametrize("make", [rfrfr, three_rfs])
def test_all_that_is_done_along_the_rods_of_a_batch_is_one_kernel(make):
    """Values are, and values with tangents: started one by one, their parts take three times as
    long."""
    if jax.default_backend() != "cpu":
        pytest.skip("only the back end for the CPU has kernels to be started")
    robot = make()
    problem, ys = problem_of(robot), jnp.zeros((64, robot.n_y))
    rights = jnp.zeros((robot.n_y, 2))
    batch = jax.jit(jax.vmap(lambda y: settle(problem, y, rights, jnp.asarray(STEPS), chords=2)))
    assert batch.lower(ys).as_text().count("xla_cpu_small_call") == 2
