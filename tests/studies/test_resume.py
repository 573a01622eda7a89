"""A map that is killed: nothing finished is lost, and the rest gives the same bits."""

import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import time

import jax
import numpy as np
import pytest
import xarray as xr

from cpr_jax.errors import InputError
from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.studies import stages, workspace
from cpr_jax.studies.workspace import workspace_map

pytestmark = pytest.mark.optimised

# A state after every batch: moments of every kind to be killed at.
PROGRAM = """
import os, sys
import jax
jax.config.update("jax_enable_x64", True)
import cpr_jax
from cpr_jax.studies import stages, workspace
cpr_jax.use_cache(sys.argv[2])
from cpr_jax.robots.catalogue import rfrfr
stages._SAVE_EVERY = 0.0
workspace.workspace_map(rfrfr(), spacing=0.005, out=sys.argv[1], resume=True)
"""


def start(folder, cache):
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(folder), str(cache)],
        env={**os.environ, "JAX_PLATFORMS": "cpu"},
    )


def load(folder) -> xr.Dataset:
    with xr.open_dataset(pathlib.Path(folder) / "map.nc", engine="h5netcdf") as dataset:
        return dataset.load()


@pytest.fixture(scope="module")
def cache():
    """Programs that the other tests of maps have compiled."""
    return jax.config.jax_compilation_cache_dir


def wait_for_states(process, folder, count: int) -> None:
    """Until a run has written a number of states, of which it writes one after every batch."""
    file = folder / "parts" / "front-0.npz"
    last, seen = None, 0
    while process.poll() is None and seen < count:
        with contextlib.suppress(FileNotFoundError):
            written = file.stat().st_mtime_ns
            seen += written != last
            last = written
        time.sleep(0.0005)


def test_killed_at_random_moments(tmp_path, cache):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    assert start(whole, cache).wait() == 0
    random = np.random.default_rng(0)
    for _ in range(2):
        process = start(killed, cache)
        wait_for_states(process, killed, random.integers(1, 30))
        # Also between two states, or in the middle of writing one.
        time.sleep(random.uniform(0.0, 0.01))
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert start(killed, cache).wait() == 0
    xr.testing.assert_identical(load(killed), load(whole))
    assert sorted(path.name for path in killed.iterdir()) == ["map.nc"]


def test_a_refined_map_goes_on_where_it_was(tmp_path, monkeypatch):
    """Interrupted while it looks at the cells of each level in turn."""
    case = {"spacing": 0.03, "refine": 2, "box": ((0.0, -0.06), (0.18, 0.24))}
    monkeypatch.setattr(workspace, "_CHUNK", 64)
    whole = workspace_map(rfrfr(), **case)
    assert set(np.unique(whole["level"])) == {0, 1, 2}
    look, calls = stages.look_at_cells, []

    def interrupted(*arguments):
        calls.append(arguments)
        if len(calls) % 2 == 0:
            raise KeyboardInterrupt
        return look(*arguments)

    monkeypatch.setattr(stages, "look_at_cells", interrupted)
    interruptions = 0
    while True:
        try:
            dataset = workspace_map(rfrfr(), out=tmp_path, resume=True, **case)
            break
        except KeyboardInterrupt:
            interruptions += 1
    assert interruptions >= 3
    xr.testing.assert_identical(dataset, whole)


def test_a_finished_map_is_loaded_and_another_one_refused(tmp_path):
    box = ((0.0, 0.18), (0.06, 0.24))
    first = workspace_map(rfrfr(), spacing=0.02, box=box, out=tmp_path)
    again = workspace_map(rfrfr(), spacing=0.02, box=box, out=tmp_path, resume=True)
    xr.testing.assert_identical(again, first)
    # Another map is not written over, by mistake in a word of the call.
    with pytest.raises(InputError, match=r"`resume` must .* \(cells: \[4, 4\] then"):
        workspace_map(rfrfr(), spacing=0.03, box=box, out=tmp_path, resume=True)
    with xr.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as kept:
        assert kept.sizes == first.sizes
    # Parts of another configuration are not gone on with.
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "configuration.json").write_text('{"spacing": 1}')
    with pytest.raises(InputError, match="resume"):
        workspace_map(rfrfr(l=0.26), spacing=0.02, box=box, out=tmp_path, resume=True)
