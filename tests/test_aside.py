"""Functions that are called in a process of its own."""

import subprocess
import sys
import time

import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.aside import Aside


def test_calls_take_their_turns(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    with Aside("shutil") as aside:
        aside.call("pathlib:Path.write_text", first, "here")
        aside.call("shutil:copy", first, second)
    assert second.read_text() == "here"


def test_nobody_waits_for_a_call(tmp_path):
    """A pipe holds some 64 kB; more is sent while the calls before are under way."""
    begin = time.perf_counter()
    with Aside("json") as aside:
        aside.call("time:sleep", 3.0)
        aside.call("pathlib:Path.write_bytes", tmp_path / "much", bytes(10**7))
        assert time.perf_counter() - begin < 3.0
    assert (tmp_path / "much").stat().st_size == 10**7
    assert time.perf_counter() - begin > 3.0


def test_arrays_keep_their_digits(tmp_path):
    third = jnp.array([1.0]) / 3.0
    with Aside("numpy") as aside:
        aside.call("numpy:save", tmp_path / "third.npy", third)
    found = np.load(tmp_path / "third.npy")
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, third)


def test_what_fails_is_told(tmp_path, capfd):
    with pytest.raises(RuntimeError, match="functions of json has failed"), Aside("json") as aside:
        aside.call("json:loads", "{")
        aside.call("pathlib:Path.touch", tmp_path / "never")
    assert "JSONDecodeError" in capfd.readouterr().err
    assert not (tmp_path / "never").exists()


def test_what_fails_here_ends_it():
    begin = time.perf_counter()
    with pytest.raises(KeyError), Aside("json") as aside:
        aside.call("time:sleep", 60.0)
        raise KeyError
    assert time.perf_counter() - begin < 30.0
    assert aside._process.poll() is not None


@pytest.mark.parametrize("sent", [b"", b"\x05", b"\x64" + bytes(7) + b"half a message"])
def test_it_ends_quietly_with_the_process_that_began_it(sent):
    command = [sys.executable, "-m", "cpr_jax.aside", "json"]
    ended = subprocess.run(command, input=sent, capture_output=True, timeout=60)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, b"", b"")
