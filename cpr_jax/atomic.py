"""Files that are whole, or not there."""

import os
import pathlib
import tempfile
from collections.abc import Callable

_TRIES = 3
"""Writes of one file, where others tidy up what is being written."""


def write_atomically(
    path: str | os.PathLike,
    write: Callable[[pathlib.Path], object],
    scratch: pathlib.Path | None = None,
) -> None:
    """Writes a file through a temporary name: it is whole, or it is not there.

    **Arguments:**

    - `write`: called with the temporary path, which ends in `.part`.
    - `scratch`: folder of the temporary file, on the same disk; by default that of the file.
    """
    for tried in range(_TRIES):
        try:
            return _write(pathlib.Path(path), write, scratch)
        except FileNotFoundError:
            # They take it for one that an interrupted write has left.
            if tried + 1 == _TRIES:
                raise


def _write(target: pathlib.Path, write, scratch: pathlib.Path | None) -> None:
    folder = scratch or target.parent
    for needed in (target.parent, folder):
        needed.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=".", suffix=".part", dir=folder)
    os.close(handle)
    temporary = pathlib.Path(name)
    try:
        write(temporary)
        with open(temporary, "rb") as stream:
            os.fsync(stream.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)
