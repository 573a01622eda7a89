"""Independent batches on all cores and devices."""

import functools
import os
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TypeVar

import jax
import numpy as np

from .surroundings import inherited

_In = TypeVar("_In")
_Out = TypeVar("_Out")

_CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 2

WORKERS = min(4, _CORES) + 1
"""Batches in flight on a device: XLA leaves cores idle on arrays as small as those of one, and
while Python prepares a batch, too."""


def on_devices(tree: _In) -> list[_In]:
    """A pytree on each local device, for batches to take turns."""
    devices = jax.local_devices()
    return [tree] if len(devices) == 1 else [jax.device_put(tree, device) for device in devices]


def in_parallel(function: Callable[[_In], _Out], items: Iterable[_In]) -> list[_Out]:
    """`function` of each item, in order; several at a time, each by itself deterministic."""
    work = list(items)
    waiting = deque(range(len(work)))
    found: dict[int, _Out] = {}

    def work_off() -> None:
        while waiting:
            try:
                k = waiting.popleft()
            except IndexError:  # another thread was quicker
                break
            try:
                found[k] = function(work[k])
            except BaseException:
                waiting.clear()
                raise

    # The caller is one of the workers: it waits for none that has not begun.
    workers = max(WORKERS, jax.local_device_count())
    pool, helping = _pool(workers), inherited(work_off)
    helpers = [pool.submit(helping) for _ in range(min(workers, len(work)) - 1)]
    try:
        work_off()
    finally:
        begun = [helper for helper in helpers if not helper.cancel()]
        wait(begun)
    for helper in begun:
        helper.result()
    return [found[k] for k in range(len(work))]


@functools.cache
def _pool(workers: int) -> ThreadPoolExecutor:
    """Threads that stay: to start them takes as long as a small batch."""
    return ThreadPoolExecutor(workers, thread_name_prefix="cpr_jax")


if hasattr(os, "register_at_fork"):
    # A forked process has the pool, but none of its threads.
    os.register_at_fork(after_in_child=_pool.cache_clear)


def padded(rows: np.ndarray, size: int) -> np.ndarray:
    """Rows filled up with the last one, so that one compiled program serves any number."""
    return np.concatenate([rows, np.repeat(rows[-1:], size - len(rows), axis=0)])
