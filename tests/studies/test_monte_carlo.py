"""Monte Carlo: counts, coverage, reproducibility, lanes without an equilibrium."""

import dataclasses
import importlib

import numpy as np
import pytest
from scipy.stats import binomtest

import cpr_jax as cpr
from cpr_jax.analysis.ellipsoid import LINEAR_COVERAGE, linear_coverage
from cpr_jax.errors import InputError
from cpr_jax.studies.outcome import clopper_pearson
from cpr_jax.studies.paper_samples import POINTS
from cpr_jax.studies.tally import merged

from ..oracles import planar_shooting


@pytest.fixture(scope="module")
def robot():
    return cpr.rfrfr()


@pytest.fixture(scope="module")
def equilibria(robot):
    return {name: cpr.solve_inverse(robot, point) for name, point in POINTS.items()}


@pytest.fixture(scope="module")
def studies(robot, equilibria):
    return {name: cpr.monte_carlo(robot, e, 2000) for name, e in equilibria.items()}


@pytest.mark.parametrize("name", ["A", "B", "C"])
def test_every_sample_is_solved_and_most_are_inside(studies, name):
    study = studies[name]
    assert (study.solved, study.lost, study.failed) == (2000, 0, 0)
    assert 0.97 < study.coverage < 0.99
    assert study.coverage_interval[0] < study.coverage < study.coverage_interval[1]
    assert study.coverage == np.mean(study.inside)


def test_samples_solve_the_independent_model(robot, equilibria, studies):
    """The platform of every 200th sample, against scipy's shooting from its own guess."""
    study = studies["B"]
    q_a = np.asarray(equilibria["B"].q_a)
    start = np.asarray(equilibria["B"].y)
    for k in range(0, 2000, 200):
        k_1, r_1, k_2, r_2 = study.rho[k]
        oracle = planar_shooting.PlanarRobot(k_b=(k_1, k_2), curvature=(1 / r_1, 1 / r_2))
        y = planar_shooting.forward(oracle, q_a, start)
        np.testing.assert_allclose(study.q_p[k], y[2:4], atol=1e-8)


def test_one_parameter_has_the_coverage_of_a_line(robot, equilibria):
    """Its platforms lie on a curve; along the line that linear theory has, 99.73 % are inside."""
    study = cpr.monte_carlo(
        robot, equilibria["A"], 20_000, parameters=["k_b1"], delta={"k_b1": 1e-4}
    )
    low, high = study.coverage_interval
    assert low < linear_coverage(1) < high
    away = np.abs(study.rho[:, 0] - float(study.sensitivity.rho[0])) / 1e-4
    clear = np.abs(away - 1.0) > 0.02
    np.testing.assert_array_equal(study.inside[clear], away[clear] < 1.0)


def test_moments_of_nothing_are_unknown():
    nothing = merged([], 2)
    assert np.all(np.isnan(nothing.covariance))
    one = nothing._replace(solved=1)
    assert np.all(np.isnan(one.covariance))


def test_an_equilibrium_of_another_robot_is_refused(robot, equilibria):
    longer = cpr.rfrfr(l=0.26)
    for study in (cpr.monte_carlo, cpr.sensitivity):
        with pytest.raises(InputError, match="`equilibrium` must be one of"):
            study(longer, equilibria["A"])
        with pytest.raises(InputError, match="`equilibrium` must be an equilibrium of a robot"):
            study(cpr.three_rfr(), equilibria["A"])


def test_windows_are_there_until_the_outcome_is_saved(robot, equilibria, tmp_path):
    def fail(study):
        raise OSError("disk full")

    arguments = {"samples": 300, "folder": tmp_path / "run"}
    with pytest.raises(OSError, match="disk full"):
        cpr.monte_carlo(robot, equilibria["A"], **arguments, save=fail)
    kept = sorted(path.name for path in (tmp_path / "run" / "parts-0").iterdir())
    assert kept == ["configuration.json", "window-000000000000.npz"]
    saved = []
    study = cpr.monte_carlo(robot, equilibria["A"], **arguments, resume=True, save=saved.append)
    assert saved == [study]
    assert not (tmp_path / "run" / "parts-0").exists()


def test_lost_samples_are_counted_apart(studies):
    study = studies["D"]
    assert study.lost > 0
    assert study.solved + study.lost + study.failed == study.samples == 2000
    assert study.failed == 0
    lost = study.status == cpr.Status.LOST
    assert np.sum(lost) == study.lost
    assert np.all(np.isnan(study.q_p[lost]))
    assert not np.any(study.inside[lost])
    assert study.coverage == np.sum(study.inside) / 2000


def test_small_ranges_give_the_linear_coverage(robot, equilibria):
    small = {label: float(value) / 100 for label, value in robot.uncertainty.items()}
    study = cpr.monte_carlo(robot, equilibria["B"], 20_000, delta=small)
    low, high = study.coverage_interval
    assert low <= LINEAR_COVERAGE <= high
    # The covariance of a linear image: K / 9.
    np.testing.assert_allclose(
        study.covariance, np.asarray(study.ellipsoid.kernel) / 9, rtol=0.05, atol=1e-12
    )


def test_samples_do_not_depend_on_how_many_there_are(robot, equilibria, studies):
    more = cpr.monte_carlo(robot, equilibria["A"], 5000, keep=2000)
    assert more.samples == more.solved == 5000
    assert more.status.shape == (2000,)
    np.testing.assert_array_equal(more.q_p, studies["A"].q_p)
    other = cpr.monte_carlo(robot, equilibria["A"], 2000, seed=1)
    assert not np.array_equal(other.rho, studies["A"].rho)


@pytest.mark.parametrize("distribution", ["ellipsoid", "box"])
def test_uniform_distributions_stay_in_their_set(robot, equilibria, distribution):
    study = cpr.monte_carlo(robot, equilibria["A"], 2000, distribution=distribution)
    step = (study.rho - np.asarray(study.sensitivity.rho)) / np.asarray(study.sensitivity.delta)
    if distribution == "box":
        assert np.max(np.abs(step)) <= 1.0
        assert np.mean(step**2) == pytest.approx(1 / 3, rel=0.05)
    else:
        radius = np.linalg.norm(step, axis=1)
        assert np.max(radius) <= 1.0 + 1e-12
        # Uniform in a ball of dimension 4: E[r²] = 4/6.
        assert np.mean(radius**2) == pytest.approx(2 / 3, rel=0.05)


@pytest.mark.parametrize("hits", [0, 1, 1952, 1999, 2000])
def test_confidence_interval(hits):
    low, high = clopper_pearson(hits, 2000)
    exact = binomtest(hits, 2000).proportion_ci(0.95, method="exact")
    assert (low, high) == pytest.approx((exact.low, exact.high), abs=1e-12)


def test_steps_follow_from_the_tolerance(robot, equilibria, studies):
    study = studies["C"]
    assert study.error <= 1e-8
    loose = cpr.monte_carlo(robot, equilibria["C"], 100, tolerance=1e-5)
    assert loose.scheme.work < study.scheme.work
    assert loose.error > study.error
    # What it leaves, beside a much finer integration.
    fine = cpr.monte_carlo(robot, equilibria["C"], 100, steps=40)
    assert 0.0 < np.max(np.abs(loose.q_p - fine.q_p)) < 1e-5
    np.testing.assert_allclose(study.q_p[:100], fine.q_p, atol=1e-8)


def test_root_finding_leaves_less_than_the_integration(robot, equilibria, studies):
    """Where `steps` are given, roots are found to rounding."""
    study = studies["C"]
    exact = cpr.monte_carlo(robot, equilibria["C"], study.samples, steps=study.scheme)
    np.testing.assert_array_equal(study.status, exact.status)
    left = np.max(np.abs(study.q_p - exact.q_p))
    assert 1e-12 < left < 0.5 * study.error


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"samples": 0}, "samples"),
        ({"samples": 2.5}, "samples"),
        ({"samples": True}, "samples"),
        ({"samples": 2**32 + 1}, "samples"),
        ({"seed": -1}, "seed"),
        ({"seed": 2**64}, "seed"),
        ({"distribution": "normal"}, "distribution"),
        ({"prediction": "none"}, "prediction"),
        ({"steps": 0}, "steps"),
        ({"steps": "ten"}, "steps"),
        ({"steps": 2.5}, "steps"),
        ({"tolerance": float("nan")}, "tolerance"),
        ({"tolerance": -1.0}, "tolerance"),
        ({"tolerance": "fine"}, "tolerance"),
        ({"keep": -1}, "keep"),
        ({"resume": True}, "folder"),
        ({"parameters": ["k"]}, "parameters"),
    ],
)
def test_mistakes_are_named(robot, equilibria, arguments, field):
    with pytest.raises(ValueError, match=f"`{field}` must"):
        cpr.monte_carlo(robot, equilibria["A"], **arguments)


def test_an_unsolved_equilibrium_is_refused(robot):
    lost = cpr.solve_inverse(robot, (0.0, 2.0), throw=False)
    with pytest.raises(ValueError, match="`equilibrium` must be solved"):
        cpr.monte_carlo(robot, lost)


def test_unknown_ranges_are_refused_before_anything_is_computed(robot, equilibria, monkeypatch):
    """What a mistake leads to is no program that is compiled first."""
    for module in ("cpr_jax.analysis.sensitivity", "cpr_jax.studies.monte_carlo"):
        monkeypatch.setattr(importlib.import_module(module), "slopes_at", None)
    for study in (cpr.sensitivity, cpr.monte_carlo):
        with pytest.raises(cpr.InputError, match=r"`delta`.*'nothing'"):
            study(robot, equilibria["A"], delta={"nothing": 1.0})


def test_a_parameter_that_does_not_vary_changes_nothing_however_soft_rods_are():
    """The robot a fiftieth in size: its stiffness is 2e-8 N m² there."""
    size, soft = 0.02, 1e-6
    robot = cpr.rfrfr(
        l=0.25 * size,
        a=0.045 * size,
        b=0.035 * size,
        d=0.2 * size,
        k_b=0.0183 * soft,
        r_c=(-size, size),
        f_P=(0.0, soft / size**2),
    )
    home = cpr.Home(robot.home.q_a, size * robot.home.q_p)
    robot = dataclasses.replace(robot, home=home)
    ranges = {"k_b1": 0.0, "l1": 2.5e-3 * size}
    equilibrium = cpr.solve_inverse(robot, (0.05 * size, 0.045 * size))
    options = {"parameters": tuple(ranges), "delta": ranges}
    found = cpr.monte_carlo(robot, equilibrium, 300, **options)
    options["delta"] = ranges | {"k_b1": 1e-12 * 0.0183 * soft}
    nearly = cpr.monte_carlo(robot, equilibrium, 300, **options)
    np.testing.assert_array_equal(found.status, nearly.status)
    assert found.solved > 200 and found.error < 1e-8


def test_what_makes_samples_worthless_is_said(robot, equilibria):
    """Steps that do not integrate the rods, and ranges that leave nothing of them."""
    coarse = cpr.Scheme(4, 4, 2)
    with pytest.warns(
        UserWarning, match=r"the tips of rods are off by up to 0\.0.*give finer `steps`"
    ):
        cpr.monte_carlo(robot, equilibria["A"], 200, steps=coarse)
    with pytest.warns(UserWarning, match="half range of k_b1 is 1 in SI units, more than"):
        study = cpr.monte_carlo(robot, equilibria["A"], 200, delta={"k_b1": 1.0})
    assert study.solved < 200
