"""Finished parts of a long run: kept whole, recognised when the run goes on."""

import contextlib
import hashlib
import json
import pathlib
import threading
import zipfile
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from ..atomic import write_atomically
from ..errors import InputError, shown

_CONFIGURATION = "configuration.json"

_DAMAGED = ValueError, EOFError, KeyError, OSError, RuntimeError, zipfile.BadZipFile
"""What reading a file ends with that is not there or not whole, whichever of its bits is wrong."""

_reading = threading.Lock()
"""numpy parses the header of an array as Python, which two threads must not do at the same time
before Python 3.11.8 and 3.12.2: a SystemError about the depth of its recursion."""


class Parts:
    """A folder of named parts that belong to one configuration.

    Each part is one file with the checksum of its arrays inside; it is whole, or it is not
    there. A part that does not match its checksum is computed again.

    **Arguments:**

    - `folder`: where the parts are, or `None` to keep nothing.
    - `configuration`: what decides every number of the run.
    - `resume`: go on with the parts that are there, if there are any.
    - `field`: the argument that gave the folder, for errors to name.

    **Raises:** `InputError` where the parts are of another run, where there are parts without
    `resume`, which would be lost, or where the folder holds something else: what was not written
    here is not touched.
    """

    def __init__(
        self,
        folder: pathlib.Path | None,
        configuration: dict[str, Any],
        resume: bool,
        field: str = "folder",
    ) -> None:
        self.folder = folder
        self.known = 0
        self._own: set[str] = set()
        if folder is None:
            return
        self._text = json.dumps(configuration, indent=2, sort_keys=True)
        # Of two runs that began in one folder at once neither takes up parts of the other.
        self._run = hashlib.sha256(self._text.encode()).hexdigest()
        path = folder / _CONFIGURATION
        if resume and path.exists():
            refuse_other(json.loads(path.read_text()), json.loads(self._text), folder)
        else:
            _refuse_others(folder, field)
            refuse_unfinished(folder, sorted(folder.glob("*.npz")))
            self.clear()
            self._begin(folder)

    def _begin(self, folder: pathlib.Path) -> None:
        path = folder / _CONFIGURATION
        write_atomically(path, lambda file: file.write_text(self._text + "\n"))

    def load(self, name: str) -> dict[str, np.ndarray] | None:
        """A part, or `None` where there is none or a damaged one."""
        if self.folder is None:
            return None
        path = self.folder / f"{name}.npz"
        try:
            with _reading, np.load(path) as file:
                arrays = {key: file[key] for key in file.files}
        except _DAMAGED:
            return None
        stored, run = arrays.pop("checksum", None), arrays.pop("run", None)
        if stored is None or str(stored) != _checksum(arrays) or str(run) != self._run:
            return None
        self.known += 1
        self._own.add(path.name)
        return arrays

    def save(self, name: str, arrays: dict[str, np.ndarray]) -> None:
        """Keeps a part; a part of the same name is replaced."""
        if self.folder is None:
            return
        about = {"checksum": np.array(_checksum(arrays)), "run": np.array(self._run)}
        stored: dict[str, Any] = {**about, **arrays}

        def write(path: pathlib.Path) -> None:
            with path.open("wb") as stream:
                np.savez(stream, **stored)

        if not (self.folder / _CONFIGURATION).exists():
            # Another run of the same numbers is through.
            self._begin(self.folder)
        path = self.folder / f"{name}.npz"
        write_atomically(path, write)
        self._own.add(path.name)

    def clear(self) -> None:
        """Removes the parts of this run and what an interrupted write has left.

        Parts of another run, one that began in this folder at the same time, stay.
        """
        if self.folder is None or not self.folder.exists():
            return
        with contextlib.suppress(FileNotFoundError):
            found = {path.name: path for path in self.folder.iterdir() if _is_kept(path)}
            others = {name for name in found if name.endswith(".npz")} - self._own
            # The configuration goes last: if this is interrupted, the rest is still known by it.
            for name in sorted(found, key=lambda name: name == _CONFIGURATION):
                if name not in others and not (others and name == _CONFIGURATION):
                    found[name].unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.folder.rmdir()


def _is_kept(path: pathlib.Path) -> bool:
    """Whether a file has a name that parts have, or what an interrupted write leaves."""
    interrupted = path.name.startswith(".") and path.suffix == ".part"
    return path.is_file() and (path.name == _CONFIGURATION or path.suffix == ".npz" or interrupted)


def _refuse_others(folder: pathlib.Path, field: str) -> None:
    if not folder.exists():
        return
    if not folder.is_dir():
        raise InputError(f"Argument `{field}` must leave {folder} to a folder, but it is a file.")
    written = (folder / _CONFIGURATION).exists()
    others = [path.name for path in folder.iterdir() if not _is_kept(path)]
    others += [path.name for path in folder.glob("*.npz") if not written]
    if others:
        raise InputError(
            f"Argument `{field}` must leave {folder} to the parts of a run, but it holds "
            f"{shown(min(others))}, which is none."
        )


def refuse_unfinished(folder: pathlib.Path, finished: Sequence[pathlib.Path]) -> None:
    """Whatever took hours is not written over because somebody has forgotten a word."""
    if finished:
        raise InputError(
            f"Argument `resume` must be given to go on with the interrupted run in {folder}, of "
            f"which {len(finished)} finished {'part' if len(finished) == 1 else 'parts'} would be "
            "lost without it. To begin anew remove that folder."
        )


def _checksum(arrays: dict[str, np.ndarray]) -> str:
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def digest(tree: Any) -> str:
    """A fingerprint of all numbers of a pytree."""
    leaves = {f"{k:04}": np.asarray(leaf) for k, leaf in enumerate(jax.tree.leaves(tree))}
    return _checksum(leaves)


def refuse_other(old: dict, new: dict, folder: pathlib.Path) -> None:
    """What was computed with other numbers is not gone on with, nor written over."""
    names = sorted(key for key in {*old, *new} if old.get(key) != new.get(key))
    if names:
        changes = "; ".join(f"{name}: {old.get(name)} then, {new.get(name)} now" for name in names)
        raise InputError(
            f"Argument `resume` must go on with the same configuration, but the run in {folder} "
            f"has another one ({changes})."
        )
