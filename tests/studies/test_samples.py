"""Samples: those that are taken for sure are on the branch."""

import jax.numpy as jnp
import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.analysis.expansion import expand
from cpr_jax.analysis.parameters import ranges, select
from cpr_jax.studies import samples as module
from cpr_jax.studies.draws import Distribution
from cpr_jax.studies.paper import POINTS

STEPS = 10


@pytest.fixture(scope="module")
def robot():
    return cpr.rfrfr()


def prepared(robot, point, prediction=module.Prediction.SECOND_ORDER):
    nominal = cpr.sensitivity(robot, cpr.solve_inverse(robot, point))
    selection = select(robot)
    delta = ranges(robot, selection, None)
    expansion = expand(robot, selection, nominal.y, nominal.Pi_y, delta, STEPS)
    study = module.Study(robot, nominal.y, delta, expansion, cpr.ellipsoid(nominal))
    return study, module.Options(selection, Distribution.GAUSSIAN, prediction, STEPS)


def followed(study, options, rho):
    """Every sample followed from the nominal parameters, which decides what its branch is."""
    found = [
        module._follow_all(study, options, rho[k : k + module.RESCUED], jnp.asarray(400))
        for k in range(0, len(rho), module.RESCUED)
    ]
    return (
        np.concatenate([np.asarray(part) for part in parts]) for parts in zip(*found, strict=True)
    )


@pytest.mark.parametrize("point", [POINTS["C"], POINTS["D"], (0.08, 0.03), (0.03, 0.05)])
def test_sure_samples_are_where_following_leads(robot, point):
    """Three of the points lie beside the singularity, where many samples are lost."""
    study, options = prepared(robot, point)
    chunk = module._solve_chunk(study, options, jnp.asarray(0), jnp.asarray(0))
    rho, q_p, sure = map(np.asarray, chunk)
    places, status = followed(study, options, rho)
    assert np.mean(sure) > 0.6
    assert np.all(status[sure] == cpr.Status.SOLVED)
    np.testing.assert_allclose(q_p[sure], places[sure], atol=1e-9)


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
