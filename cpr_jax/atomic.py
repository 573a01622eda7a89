"""Files that are whole, or not there."""

import os
import pathlib
import tempfile
from collections.abc import Callable


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
    target = pathlib.Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    folder = scratch or target.parent
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
