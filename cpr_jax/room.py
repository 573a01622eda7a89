"""Room for compiled programs.

Each loop of a program is mapped into memory by itself, and Linux limits how many such pieces a
process may have: one that has compiled some dozens of large programs would be killed by the next.
"""

import functools
import pathlib
from collections.abc import Callable

import jax

_MAPS = pathlib.Path("/proc/self/maps")
_LIMIT = pathlib.Path("/proc/sys/vm/max_map_count")

_SHARE = 0.4
"""Share of the limit from which on room is made; two large programs may be under way."""

_crowded = False


@functools.cache
def watch() -> None:
    """From now on, looks after each compilation whether there is room for the next."""
    jax.monitoring.register_event_duration_secs_listener(_look)


def make_room(forget: Callable[[], None]) -> None:
    """Drops all compiled programs if there is little room left; what is needed is made again.

    **Arguments:**

    - `forget`: drops programs that are kept elsewhere than in JAX.
    """
    global _crowded
    if _crowded:
        _crowded = False
        forget()
        jax.clear_caches()


def _look(event: str, duration_secs: float, **kwargs: str | int) -> None:
    global _crowded
    if "backend_compile" in event or "cache_retrieval" in event:
        _crowded = _crowded or _pieces() > _SHARE * _most()


def _pieces() -> int:
    try:
        return _MAPS.read_bytes().count(b"\n")
    except OSError:  # not on Linux
        return 0


@functools.cache
def _most() -> float:
    try:
        return float(_LIMIT.read_text())
    except OSError:
        return float("inf")
