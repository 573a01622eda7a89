"""Compiled programs make room before the limit of a process is reached."""

import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax import programs, room
from cpr_jax.programs import program


@pytest.mark.parametrize("cached", [False, True])
def test_room_is_made_before_the_limit(cached, monkeypatch, tmp_path):
    """With a limit that is always exceeded, each program that is compiled drops the others."""
    if cached:
        monkeypatch.setattr(programs, "_folder", tmp_path)
    monkeypatch.setattr(programs, "_all", [])
    monkeypatch.setattr(room, "_pieces", lambda: 100)

    @program
    def twice(x):
        return 2.0 * x

    dropped, (three, four, five) = [], (jnp.ones(n) for n in (3, 4, 5))
    monkeypatch.setattr(room.jax, "clear_caches", lambda: dropped.append(twice._known))
    monkeypatch.setattr(room, "_most", lambda: 1000.0)
    monkeypatch.setattr(room, "_crowded", False)
    np.testing.assert_array_equal(twice(three), 2.0)
    np.testing.assert_array_equal(twice(four), 2.0)
    assert dropped == []
    monkeypatch.setattr(room, "_most", lambda: 120.0)
    np.testing.assert_array_equal(twice(five), 2.0)
    assert dropped == []
    np.testing.assert_array_equal(twice(three), 2.0)
    assert len(dropped) == 1
    assert len(twice._known) == 1


def test_a_compilation_is_seen():
    """JAX tells of compilations, and Linux of the pieces that they map."""
    if not room._MAPS.exists():
        pytest.skip("there is no such limit here")
    assert 0 < room._pieces() < room._most() < float("inf")
