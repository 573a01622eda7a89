"""Work that several processes share, each on its own machine or on the same one.

They are started as JAX starts them: each calls `jax.distributed.initialize` and then runs the
same program. On CPUs set `jax_cpu_collectives_implementation` to `"gloo"` before.
"""

from collections.abc import Sequence
from typing import TypeVar

import jax
import numpy as np
from jax.experimental import multihost_utils

_Item = TypeVar("_Item")


def own_share(items: Sequence[_Item]) -> list[_Item]:
    """Every so many-th item, beginning with the number of this process."""
    return list(items[jax.process_index() :: jax.process_count()])


def gathered(own: np.ndarray, total: int) -> np.ndarray:
    """The rows of all processes in the order of the items, on every process.

    **Arguments:**

    - `own`: a row for each item of `own_share`.
    - `total`: the number of all items.
    """
    count = jax.process_count()
    if count == 1:
        return own
    rows = np.zeros((-(-total // count), *own.shape[1:]), own.dtype)
    rows[: len(own)] = own
    everybody = np.asarray(multihost_utils.process_allgather(rows))
    return everybody.swapaxes(0, 1).reshape(-1, *own.shape[1:])[:total]


def gathered_tables(own: list[np.ndarray], shape: tuple[int, int], total: int) -> np.ndarray:
    """The tables of all processes in the order of the items, below one another.

    **Arguments:**

    - `own`: a table for each item of `own_share`.
    - `shape`: of a whole one; only the last of all may have fewer rows, which are filled up.
    """
    if jax.process_count() == 1:
        return np.concatenate(own) if own else np.zeros((0, shape[1]))
    padded = [np.pad(table, ((0, shape[0] - len(table)), (0, 0))) for table in own]
    return gathered(np.array(padded).reshape(-1, *shape), total).reshape(-1, shape[1])
