"""Processes that share a study, and a study that is interrupted: the numbers of one run."""

import socket
import subprocess
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


WAITING = """
import sys, time
import jax
jax.config.update("jax_enable_x64", True)
jax.config.update("jax_num_cpu_devices", 1)
jax.config.update("jax_cpu_collectives_implementation", "gloo")
number = int(sys.argv[1])
jax.distributed.initialize("localhost:" + sys.argv[2], 2, number)
import numpy as np
from cpr_jax.studies.processes import gathered, own_share
rows = np.array([[float(item)] for item in own_share(range(5))])
time.sleep(40.0 * number)
for _ in range(2):
    np.testing.assert_array_equal(gathered(rows, 5), np.arange(5.0)[:, None])
"""


def test_a_slow_process_is_waited_for():
    """However long it takes; what gathers the numbers gives up after half a minute."""
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = str(free.getsockname()[1])
    started = [
        subprocess.Popen(
            [sys.executable, "-c", WAITING, str(k), port], stderr=subprocess.PIPE, text=True
        )
        for k in range(2)
    ]
    for process in started:
        _, errors = process.communicate(timeout=200)
        assert process.returncode == 0, errors[-3000:]


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
    assert solved == [0, windows.CHUNK]
    with pytest.raises(InputError, match="resume"):
        monte_carlo(*small, 3000, seed=1, folder=tmp_path, resume=True)
    solved.pop()
    again = monte_carlo(*small, 3000, folder=tmp_path, resume=True)
    assert solved == [0, 2 * windows.CHUNK]
    for name in ("rho", "q_p", "status", "inside", "mean", "covariance", "coverage"):
        np.testing.assert_array_equal(getattr(again, name), getattr(whole, name))
    assert not any(tmp_path.rglob("*.npz"))
