"""Independent batches on all cores."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

_In = TypeVar("_In")
_Out = TypeVar("_Out")

WORKERS = min(4, len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 2)
"""Batches in flight: XLA leaves cores idle on arrays as small as those of one batch."""


def in_parallel(function: Callable[[_In], _Out], items: Iterable[_In]) -> list[_Out]:
    """`function` of each item, in order; several at a time, each by itself deterministic."""
    work = list(items)
    if len(work) < 2 or WORKERS < 2:
        return [function(item) for item in work]
    with ThreadPoolExecutor(WORKERS) as pool:
        return list(pool.map(function, work))
