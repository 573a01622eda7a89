"""What `print` shows of results: numbers where there are some, structure where not."""

import jax
import numpy as np
import pytest

import cpr_jax as cpr


@pytest.fixture(scope="module")
def robot():
    return cpr.rfrfr()


@pytest.fixture(scope="module")
def equilibrium(robot):
    return cpr.solve_inverse(robot, (0.0, 0.2))


def numbers(text, name):
    """Those of the line, or lines, that begin with a name."""
    after = text.split(f"\n  {name} ")[1].split("\n  ")[0]
    return np.array(after.replace("[", " ").replace("]", " ").split(), float)


def test_an_equilibrium(equilibrium):
    text = str(equilibrium)
    assert text.startswith("Equilibrium on the branch of 'home': solved\n")
    for name, value in (
        ("q_a", equilibrium.q_a),
        ("q_p", equilibrium.q_p),
        ("motor_torques", equilibrium.motor_torques),
        ("energy", equilibrium.measures.energy),
    ):
        np.testing.assert_allclose(numbers(text, name), np.atleast_1d(value), rtol=1e-5, atol=1e-12)


def test_where_there_is_none_it_says_why(robot):
    lost = cpr.solve_inverse(robot, (0.0, 0.6), throw=False)
    assert "a leg is too short" in str(lost) and "nan" in str(lost)


def test_batches_and_traced_results_show_their_structure(robot, equilibrium):
    batch = jax.tree.map(lambda leaf: np.stack([leaf, leaf]), equilibrium)
    assert str(batch) == repr(batch)
    seen = []
    jax.jit(lambda e: seen.append((str(e), repr(e))))(equilibrium)
    assert seen[0][0] == seen[0][1]


def test_sensitivity_ellipsoid_and_study(robot, equilibrium):
    sensitivity = cpr.sensitivity(robot, equilibrium)
    text = str(sensitivity)
    assert "k_b1, r_c1, k_b2, r_c2 with the motors held" in text
    first = numbers(text, "Pi_p")
    np.testing.assert_allclose(first, np.ravel(sensitivity.Pi_p)[: len(first)], rtol=1e-5)
    ellipse = cpr.ellipsoid(sensitivity)
    np.testing.assert_allclose(numbers(str(ellipse), "semi_axes"), ellipse.semi_axes, rtol=1e-5)
    study = cpr.monte_carlo(robot, equilibrium, samples=100)
    assert str(study).startswith("Monte Carlo study of 100 samples: 100 solved, 0 lost, 0 failed")
    assert numbers(str(study), "coverage")[0] == pytest.approx(study.coverage)


def test_stability_and_mobility(robot, equilibrium):
    stability = cpr.stability(robot, equilibrium)
    assert numbers(str(stability), "index") == [0.0]
    mobility = cpr.mobility(robot, equilibrium)
    expected = np.ravel(mobility.jacobian)[:2]
    np.testing.assert_allclose(numbers(str(mobility), "jacobian")[:2], expected, rtol=1e-5)


def test_a_notebook_shows_what_print_shows(robot, equilibrium):
    class Printer:
        def text(self, text):
            self.shown = text

    sensitivity = cpr.sensitivity(robot, equilibrium)
    study = cpr.monte_carlo(robot, equilibrium, samples=100)
    for result in (equilibrium, sensitivity, cpr.ellipsoid(sensitivity), study):
        printer = Printer()
        result._repr_pretty_(printer, False)
        assert printer.shown == str(result)
