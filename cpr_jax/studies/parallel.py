"""Independent batches on all cores and devices."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import jax
import numpy as np

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
    workers = max(WORKERS, jax.local_device_count())
    if len(work) < 2:
        return [function(item) for item in work]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(function, work))


def padded(rows: np.ndarray, size: int) -> np.ndarray:
    """Rows filled up with the last one, so that one compiled program serves any number."""
    return np.concatenate([rows, np.repeat(rows[-1:], size - len(rows), axis=0)])
