"""Samples: those that are taken for sure are on the branch."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from benchmarks.timing import CompileClock
from cpr_jax.analysis.expansion import HeldEquations, expand
from cpr_jax.analysis.parameters import ranges, select
from cpr_jax.rods.solver import Scheme
from cpr_jax.statics.chord import EXACT
from cpr_jax.statics.continuation import Corrected, follow
from cpr_jax.statics.linear import solve_with_sign
from cpr_jax.statics.unknowns import unknown_scales
from cpr_jax.studies import samples as module
from cpr_jax.studies.draws import Distribution
from cpr_jax.studies.paper_samples import POINTS

STEPS = 10


@pytest.fixture(scope="module")
def robot():
    return cpr.rfrfr()


def prepared(robot, point, prediction=module.Prediction.SECOND_ORDER):
    nominal = cpr.sensitivity(robot, cpr.solve_inverse(robot, point))
    selection = select(robot)
    delta = ranges(robot, selection, None)
    expansion = expand(robot, selection, nominal.y, nominal.Pi_y, delta)
    scheme, enough = np.asarray(Scheme(STEPS)), np.asarray(EXACT)
    study = module.Study(robot, nominal.y, delta, expansion, scheme, enough)
    options = module.Options(selection, Distribution.GAUSSIAN, prediction)
    return study, options, cpr.ellipsoid(nominal)


def newton_corrector(equations):
    """Newton's method with the exact Jacobian at each of its turns, and the exact slope."""

    def correct(predicted, _, h, dh, reach):
        def unfinished(state):
            y, norm, _, _, count = state
            near = jnp.max(jnp.abs(y - predicted)) < reach
            return (count < 8) & (norm > 1e-9) & near

        def newton(state):
            y, *_, count = state
            f, jacobian = equations(y, h), jax.jacfwd(equations)(y, h)
            change, sign = solve_with_sign(jacobian, -f)
            return y + change, jnp.max(jnp.abs(f)), sign, jacobian, count + 1

        one = jnp.ones(())
        first = predicted, jnp.inf * one, one, jnp.eye(predicted.size), jnp.array(0)
        y, norm, sign, jacobian, _ = jax.lax.while_loop(unfinished, newton, first)
        _, shift = jax.jvp(lambda h: equations(y, h), (h,), (dh,))
        return Corrected(y, norm <= 1e-9, sign, solve_with_sign(jacobian, -shift)[0])

    return correct


@eqx.filter_jit
def followed(study, selection, rho):
    """Every sample followed from the nominal parameters, which decides what its branch is."""
    robot, expansion = study.robot, study.expansion
    correct = newton_corrector(HeldEquations(robot, selection, study.y, study.scheme))

    def one(rho):
        way = jnp.stack([expansion.rho, rho])
        track = follow(correct, expansion.y, way, first_step=0.1)
        return (track.y * unknown_scales(robot)[robot.n_a :])[: robot.n_p], track.status

    return jax.vmap(one)(rho)


@pytest.mark.parametrize(
    "point, doubtful",
    [(POINTS["C"], 0.0), (POINTS["D"], 0.1), ((0.08, 0.03), 0.05), ((0.03, 0.05), 0.004)],
)
def test_samples_are_where_following_leads(robot, point, doubtful):
    """Three of the points lie beside the singularity, where many samples are lost."""
    study, options, ellipse = prepared(robot, point)
    window = module.solve_window(study, options, ellipse, seed=0, first=0, count=module.CHUNK)
    places, status = map(np.asarray, followed(study, options.selection, window.rho))
    assert doubtful <= np.mean(window.followed) < 0.5
    np.testing.assert_array_equal(window.status, status)
    solved = status == cpr.Status.SOLVED
    np.testing.assert_allclose(window.q_p[solved], places[solved], atol=1e-9)


def test_other_accuracies_are_the_same_program(robot):
    study, options, ellipse = prepared(robot, POINTS["C"])
    window = module.solve_window(study, options, ellipse, seed=0, first=0, count=100)
    finer = eqx.tree_at(lambda study: study.scheme, study, np.asarray(Scheme(3 * STEPS)))
    with CompileClock() as clock:
        other = module.solve_window(finer, options, ellipse, seed=0, first=0, count=100)
    assert clock.seconds == 0.0
    assert 0.0 < np.max(np.abs(other.q_p - window.q_p)) < 1e-9
    with CompileClock() as clock:
        jax.jit(lambda x: 3.0 * x)(study.y)
    assert clock.seconds > 0.0


def test_both_predictions_lead_to_the_same_samples(robot):
    for_tangent = prepared(robot, POINTS["C"], module.Prediction.TANGENT)
    tangent = module.solve_window(*for_tangent, seed=3, first=0, count=500)
    second = module.solve_window(*prepared(robot, POINTS["C"]), seed=3, first=0, count=500)
    np.testing.assert_array_equal(tangent.rho, second.rho)
    np.testing.assert_allclose(tangent.q_p, second.q_p, atol=1e-9)
    assert np.sum(tangent.followed) >= np.sum(second.followed)


def test_a_window_is_its_chunks(robot):
    prepared_ = prepared(robot, POINTS["D"])
    window = module.solve_window(*prepared_, seed=1, first=0, count=module.CHUNK + 100)
    rest = module.solve_window(*prepared_, seed=1, first=module.CHUNK, count=100)
    for whole, part in zip(window, rest, strict=True):
        np.testing.assert_array_equal(whole[module.CHUNK :], part)
