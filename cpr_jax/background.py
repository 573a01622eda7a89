"""Work in threads of its own: programs that are compiled before they are called."""

import contextlib
import threading
from collections.abc import Callable

import jax
import numpy as np

from .geometry import floats
from .surroundings import inherited


def started(job: Callable[[], object]) -> threading.Thread:
    """A thread that compiles what will be needed; to be joined before it is.

    What goes wrong in it is left for whoever then calls the program, and meets the same mistake.
    """

    here = inherited(job)

    def quietly() -> None:
        with contextlib.suppress(Exception):
            here()

    thread = threading.Thread(target=quietly, name="cpr_jax-compile", daemon=True)
    thread.start()
    return thread


def not_a_number(*shape: int) -> jax.Array:
    """What programs are called with to be compiled: on NaN every iteration stops at once."""
    # From numpy: an operation alone would wait for what is being compiled.
    return floats(np.full(shape, np.nan))
