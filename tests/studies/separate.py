"""One study in processes of its own, with other devices and other processes."""

import socket
import subprocess
import sys

import jax
import numpy as np

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
cells = np.zeros(0)
if {processes} == 1:
    from cpr_jax.statics.problem import inverse_rows
    from cpr_jax.statics.unknowns import unknown_scales
    from cpr_jax.studies.follower import Follower
    seed = cpr.solve_inverse(robot, (0.05, 0.15))
    goals = np.zeros((300, 4))
    goals[:, 2:] = (0.05, 0.15) + 1e-3 * np.random.default_rng(0).normal(size=(300, 2))
    guess = np.tile(np.asarray(seed.y / unknown_scales(robot)), (300, 1))
    guess[:, 2:4] = goals[:, 2:] / 0.25
    cells = Follower(robot, inverse_rows(robot), (2, 3), 5).advance(guess, goals).y
assert len(jax.local_devices()) == {devices} and jax.process_count() == {processes}
np.savez(
    sys.argv[1], rho=study.rho, q_p=study.q_p, status=study.status, inside=study.inside,
    mean=study.mean, covariance=study.covariance, counts=(study.solved, study.lost),
    cells=cells,
)
"""


def run(folder, devices=1, processes=1):
    """The study's numbers as each process has them."""
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = free.getsockname()[1]
    program = STUDY.format(devices=devices, processes=processes, port=port)
    files = [folder / f"{devices}-{processes}-{k}.npz" for k in range(processes)]
    # Programs that the other runs have made.
    cache = jax.config.jax_compilation_cache_dir
    started = [
        subprocess.Popen(
            [sys.executable, "-c", program, str(file), str(k), str(cache)],
            stderr=subprocess.PIPE,
            text=True,
        )
        for k, file in enumerate(files)
    ]
    for process in started:
        _, errors = process.communicate(timeout=250)
        assert process.returncode == 0, errors[-3000:]
    return [dict(np.load(file)) for file in files]
