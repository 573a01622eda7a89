"""Processes that share a study, and a study that is interrupted: the numbers of one run."""

import sys

import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.errors import InputError
from cpr_jax.studies import samples as windows
from cpr_jax.studies.monte_carlo import monte_carlo

from .separate import run


def test_two_processes_give_the_numbers_of_one_to_both(folder, alone):
    for study in run(folder, processes=2):
        for name in alone.keys() - {"cells"}:
            np.testing.assert_array_equal(study[name], alone[name], err_msg=name)


@pytest.fixture(scope="module")
def small():
    robot = cpr.rfrfr()
    return robot, cpr.solve_inverse(robot, (0.06, 0.18))


def test_a_study_that_is_interrupted_goes_on(small, tmp_path, monkeypatch):
    module = sys.modules[monte_carlo.__module__]
    for place in (module, windows):
        monkeypatch.setattr(place, "WINDOW", 1)
    whole = monte_carlo(*small, 3000)
    solve, solved = windows.solve_window, []

    def counted(*arguments):
        if len(solved) == 2:
            raise KeyboardInterrupt
        solved.append(arguments[4])
        return solve(*arguments)

    monkeypatch.setattr(module, "solve_window", counted)
    with pytest.raises(KeyboardInterrupt):
        monte_carlo(*small, 3000, folder=tmp_path)
    assert solved == [0, 1024]
    with pytest.raises(InputError, match="resume"):
        monte_carlo(*small, 3000, seed=1, folder=tmp_path, resume=True)
    solved.pop()
    again = monte_carlo(*small, 3000, folder=tmp_path, resume=True)
    assert solved == [0, 2048]
    for name in ("rho", "q_p", "status", "inside", "mean", "covariance", "coverage"):
        np.testing.assert_array_equal(getattr(again, name), getattr(whole, name))
    assert not any(tmp_path.rglob("*.npz"))
