"""Work that several processes share, each on its own machine or on the same one.

They are started as JAX starts them: each calls `jax.distributed.initialize` and then runs the
same program. On CPUs set `jax_cpu_collectives_implementation` to `"gloo"` before.
"""

import itertools
from collections.abc import Sequence
from typing import TypeVar

import jax
import numpy as np
from jax._src import distributed
from jax.experimental import multihost_utils

_Item = TypeVar("_Item")

_LONGEST = 10**9
"""For how long processes wait for one another, ms: eleven days."""

_turn = itertools.count()
"""How often they have; all processes run the same program."""


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
    _wait_for_all()
    everybody = np.asarray(multihost_utils.process_allgather(rows))
    return everybody.swapaxes(0, 1).reshape(-1, *own.shape[1:])[:total]


def _wait_for_all() -> None:
    """Until all processes are here. Collective operations give the slowest one half a minute."""
    # JAX has no public name for it; its own checkpoints wait like this.
    client = distributed.global_state.client
    if client is not None:
        client.wait_at_barrier(f"cpr_jax-{next(_turn)}", _LONGEST)


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
