"""Programs that outlive a process: what was traced and compiled once is not again.

JAX's own persistent cache spares the compilation of a program, but not its tracing, which takes
longer than most runs. Here a program is kept as `jax.export` serialises it, under a name made
from everything it was traced from: the function, the package's source, the versions of what it
stands on, and the types and static values of its arguments.

Without a folder to keep them in they are compiled ahead of their calls all the same: to look one up
here takes a fraction of what a call of `equinox.filter_jit` takes.
"""

import contextlib
import functools
import os
import pathlib
import pickle
import threading
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import equinox as eqx
import jax
from jax import export

from .atomic import write_atomically
from .collection import uncollected
from .compiler import BRIEF, HOT, QUICK, is_hardly_optimised, options_of
from .outline import Slot, outlined, parted
from .program_name import name_of
from .room import make_room, watch
from .surroundings import devices_of, is_on_cpu, is_watched, is_within, set_here

_Function = TypeVar("_Function", bound=Callable[..., Any])

_tracing = threading.RLock()
"""Held by the thread that traces a program. Python runs one at a time in any case; in turn, each is
there for XLA to compile beside the next, which is not so if all end together."""

_folder: pathlib.Path | None = None
_all: "list[_Program]" = []


def use_cache(folder: str | os.PathLike | None = None) -> pathlib.Path:
    """Keeps compiled programs in a folder, so that later processes start at once.

    Call it before the first solve. The command line does; `CPR_JAX_CACHE` is its folder.

    **Arguments:**

    - `folder`: by default `cpr_jax` in `XDG_CACHE_HOME` or `~/.cache`. Like any cache of
        compiled programs it must be yours alone to write: what lies in it is executed.

    **Returns:** the folder.
    """
    global _folder
    if folder is None:
        home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
        folder = pathlib.Path(home).expanduser() / "cpr_jax"
    _folder = pathlib.Path(folder)
    jax.config.update("jax_compilation_cache_dir", str(_folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)
    return _folder


class _Loaded(NamedTuple):
    """A compiled program, and what it returns: arrays in the places of `Slot`s."""

    call: Callable[..., Any]
    leaves: list[Any]
    structure: Any

    @classmethod
    def of(cls, compiled: Callable[..., Any], outline: Any) -> "_Loaded":
        """Compiled here: a jitted call would compile once more for arrays from another."""
        return cls(compiled, *jax.tree.flatten(outline, is_leaf=lambda x: isinstance(x, Slot)))

    def __call__(self, arrays):
        found = self.call(*arrays)
        filled = [found[x.number] if isinstance(x, Slot) else x for x in self.leaves]
        return jax.tree.unflatten(self.structure, filled)


def forget_all() -> None:
    """Drops all programs that are loaded; those in the folder stay."""
    for each in _all:
        each.forget()


class _Program:
    """A function of pytrees; see `program`."""

    def __init__(self, function: Callable[..., Any], wishes: dict[str, Any]):
        functools.update_wrapper(self, function)
        self._function = function
        self._wishes = wishes
        self._inner = eqx.filter_jit(function)
        self._outer: Callable[..., Any] | None = None
        self._known: dict[Any, _Loaded | None] = {}
        self._lock = threading.Lock()
        self._busy: dict[Any, threading.Lock] = {}
        watch()
        _all.append(self)

    def __call__(self, *args, **kwargs):
        leaves, structure = jax.tree.flatten((args, kwargs))
        arrays, rest = parted(leaves)
        if is_within(arrays):
            return self._inner(*args, **kwargs)
        make_room(forget_all)
        devices = devices_of(arrays)
        if devices is None or is_watched():
            return self._alone(*args, **kwargs)
        key = (structure, *rest, devices, *set_here(), is_hardly_optimised(), _folder)
        loaded = self._load(key, args, kwargs)
        if loaded is None:
            return self._alone(*args, **kwargs)
        return loaded(arrays)

    @property
    def _options(self) -> dict[str, Any]:
        return options_of(self._wishes)

    def _alone(self, *args, **kwargs):
        """A call that is a program of its own, not kept."""
        with self._lock:
            if self._outer is None:
                # What its types leave out is handed on to `jax.jit`.
                jit: Any = eqx.filter_jit
                self._outer = jit(self._function, compiler_options=self._options)
        return self._outer(*args, **kwargs)

    def _load(self, key, args, kwargs) -> _Loaded | None:
        known = self._known
        if key in known:
            return known[key]
        with self._lock:
            busy = self._busy.setdefault(key, threading.Lock())
        # One thread makes a program, another that wants the same one waits for it.
        with busy:
            if key not in known:
                known[key] = self._find_or_make(args, kwargs)
        return known[key]

    def forget(self) -> None:
        """Drops what was loaded; calls that are under way keep theirs."""
        self._known = {}

    def _find_or_make(self, args, kwargs) -> _Loaded | None:
        with _tracing, uncollected():
            traced = self._find_or_trace(args, kwargs)
        if traced is None:
            return None
        lowered, outline = traced
        return _Loaded.of(lowered.compile(self._options), outline)

    def _find_or_trace(self, args, kwargs) -> tuple[jax.stages.Lowered, Any] | None:
        """What XLA is to compile, and the outline of what it returns; `None` if it is not kept."""
        if _folder is None:
            flat, given, outlines = self._flat(args, kwargs)
            return jax.jit(flat).lower(*given), outlines[-1]
        name = name_of(self._function, args, kwargs)
        if name is None:
            return None
        file = _folder / "programs" / name
        try:
            exported, outline = pickle.loads(file.read_bytes())
        except Exception:  # whatever is wrong with a file, the program can be made again
            made = self._make(args, kwargs)
            if made is None:
                return None
            exported, outline = made
            content = pickle.dumps(made)
            # A cache that cannot be written costs time, nothing else.
            with contextlib.suppress(OSError):
                write_atomically(file, lambda part: part.write_bytes(content))
        call = jax.jit(export.deserialize(bytearray(exported)).call)
        arrays, _ = outlined((args, kwargs))
        return call.lower(*arrays), outline

    def _flat(self, args, kwargs) -> tuple[Callable[..., list[jax.Array]], list[Any], list[Any]]:
        """The function from arrays to arrays, its arguments, and a list for its outlines.

        When it is traced, the outline of what it returns is added to the list.
        """
        dynamic, static = eqx.partition((args, kwargs), eqx.is_array)
        outlines = []

        def flat(*leaves):
            moving = jax.tree.unflatten(jax.tree.structure(dynamic), leaves)
            args, kwargs = eqx.combine(moving, static)
            arrays, outline = outlined(self._function(*args, **kwargs))
            outlines.append(outline)
            return arrays

        flat.__name__ = self._function.__name__
        return flat, jax.tree.leaves(dynamic), outlines

    def _make(self, args, kwargs) -> tuple[bytes, Any] | None:
        """The program and the outline of what it returns, or `None` if it cannot be kept."""
        flat, given, outlines = self._flat(args, kwargs)
        # Beside a GPU arrays may still be bound to the CPU.
        platforms = ["cpu"] if is_on_cpu(given) else None
        exported = export.export(jax.jit(flat), platforms=platforms)(*given)
        try:
            pickle.dumps(outlines[-1])
            return bytes(exported.serialize()), outlines[-1]
        except (pickle.PicklingError, AttributeError, TypeError, NotImplementedError):
            return None


def program(function: _Function) -> _Function:
    """As `equinox.filter_jit`: arrays are traced, everything else is static.

    After `use_cache` its programs are also read from, and written to, the folder of the cache.
    Under `jax.jit`, `jax.vmap` or a derivative it is part of the surrounding program as usual.
    It is compiled in little time; what is worth more is a `hot_program`, what is worth less is a
    `brief_program`.
    """
    return _Program(function, QUICK)  # type: ignore[return-value]


def brief_program(function: _Function) -> _Function:
    """As `program`, compiled in half the time: for what runs through a robot once, in some
    milliseconds, and waits for nothing but its compilation."""
    return _Program(function, BRIEF)  # type: ignore[return-value]


def hot_program(function: _Function) -> _Function:
    """As `program`, compiled for longer to run in less time."""
    return _Program(function, HOT)  # type: ignore[return-value]


def quick_jit(function: Callable[..., Any]) -> Callable[..., Any]:
    """As `jax.jit`, compiled as a `program` is: for functions of users, which have no name to be
    kept under."""
    return jax.jit(function, compiler_options=options_of(QUICK))
