"""Devices and processes that share a study: the numbers of one."""

import socket
import subprocess
import sys

import numpy as np
import pytest

import cpr_jax as cpr
from cpr_jax.errors import InputError
from cpr_jax.studies import samples as windows
from cpr_jax.studies.monte_carlo import monte_carlo

# Small windows, so that a study has several of them.
STUDY = """
import sys
import jax
jax.config.update("jax_enable_x64", True)
jax.config.update("jax_num_cpu_devices", {devices})
if {processes} > 1:
    jax.config.update("jax_cpu_collectives_implementation", "gloo")
    jax.distributed.initialize("localhost:{port}", {processes}, int(sys.argv[2]))
import numpy as np
import cpr_jax as cpr
from cpr_jax.studies import monte_carlo, samples
monte_carlo.WINDOW = samples.WINDOW = 2
cpr.use_cache(sys.argv[3])
robot = cpr.rfrfr()
study = cpr.monte_carlo(robot, cpr.solve_inverse(robot, (0.05, 0.045)), 7000, keep=5000)
map_ = None
if {processes} == 1:
    map_ = cpr.workspace_map(robot, spacing=0.02)["semi_axis_max"].values
assert len(jax.local_devices()) == {devices} and jax.process_count() == {processes}
np.savez(
    sys.argv[1], rho=study.rho, q_p=study.q_p, status=study.status, inside=study.inside,
    mean=study.mean, covariance=study.covariance, counts=(study.solved, study.lost),
    map=np.zeros(0) if map_ is None else map_,
)
"""


def run(folder, devices=1, processes=1):
    """The study's numbers as each process has them."""
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = free.getsockname()[1]
    program = STUDY.format(devices=devices, processes=processes, port=port)
    files = [folder / f"{devices}-{processes}-{k}.npz" for k in range(processes)]
    started = [
        subprocess.Popen(
            [sys.executable, "-c", program, str(file), str(k), str(folder / "cache")],
            stderr=subprocess.PIPE,
            text=True,
        )
        for k, file in enumerate(files)
    ]
    for process in started:
        _, errors = process.communicate(timeout=250)
        assert process.returncode == 0, errors[-3000:]
    return [dict(np.load(file)) for file in files]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("studies")


@pytest.fixture(scope="module")
def alone(folder):
    (study,) = run(folder)
    return study


def test_two_devices_give_the_numbers_of_one(folder, alone):
    (both,) = run(folder, devices=2)
    for name, values in alone.items():
        np.testing.assert_array_equal(both[name], values, err_msg=name)


def test_two_processes_give_the_numbers_of_one_to_both(folder, alone):
    for study in run(folder, processes=2):
        for name in alone.keys() - {"map"}:
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
        solved.append(arguments[3])
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
