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
import hashlib
import importlib.metadata
import io
import os
import pathlib
import pickle
import threading
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import equinox as eqx
import jax
from jax import export
from jax.extend.core import get_opaque_trace_state

from .atomic import write_atomically
from .collection import uncollected
from .compiler import HOT, QUICK, known_options
from .room import make_room, watch

_Function = TypeVar("_Function", bound=Callable[..., Any])

_UNDER = ("jax", "jaxlib", "equinox", "diffrax", "optimistix", "lineax", "numpy", "scipy")
"""Distributions that a traced program depends on."""

_WATCHED_BY = ("jax_disable_jit", "jax_debug_nans", "jax_debug_infs")

_tracing = threading.RLock()
"""Held by the thread that traces a program. Python runs one at a time in any case; in turn, each is
there for XLA to compile beside the next, which is not so if all end together."""

_folder: pathlib.Path | None = None
_all: "list[_Program]" = []

_outside: Any = None
"""JAX's state outside of all programs, once it is known: to compare it is quick."""


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
    """A compiled program, and what it returns: arrays in the places of `_Slot`s."""

    call: Callable[..., Any]
    leaves: list[Any]
    structure: Any

    @classmethod
    def of(cls, compiled: Callable[..., Any], outline: Any) -> "_Loaded":
        """Compiled here: a jitted call would compile once more for arrays from another."""
        return cls(compiled, *jax.tree.flatten(outline, is_leaf=lambda x: isinstance(x, _Slot)))

    def __call__(self, arrays):
        found = self.call(*arrays)
        filled = [found[x.number] if isinstance(x, _Slot) else x for x in self.leaves]
        return jax.tree.unflatten(self.structure, filled)


class _Slot(NamedTuple):
    """Stands for the array of this number in a tree whose other leaves are Python values."""

    number: int


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
        arrays, rest = [], []
        for leaf in leaves:
            if eqx.is_array(leaf):
                arrays.append(leaf)
                rest.append(_type_of(leaf))
            else:
                rest.append((type(leaf), leaf))
        if _is_within(arrays):
            return self._inner(*args, **kwargs)
        make_room(forget_all)
        devices = _devices(arrays)
        if devices is None or _is_watched():
            return self._alone(*args, **kwargs)
        place = getattr(jax.config, "jax_default_device", None)
        key = (structure, *rest, devices, place, bool(jax.config.read("jax_enable_x64")), _folder)
        loaded = self._load(key, args, kwargs)
        if loaded is None:
            return self._alone(*args, **kwargs)
        return loaded(arrays)

    @property
    def _options(self) -> dict[str, Any]:
        return known_options(tuple(self._wishes.items()))

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
        name = self._name(args, kwargs)
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
        arrays, _ = _outlined((args, kwargs))
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
            arrays, outline = _outlined(self._function(*args, **kwargs))
            outlines.append(outline)
            return arrays

        flat.__name__ = self._function.__name__
        return flat, jax.tree.leaves(dynamic), outlines

    def _make(self, args, kwargs) -> tuple[bytes, Any] | None:
        """The program and the outline of what it returns, or `None` if it cannot be kept."""
        flat, given, outlines = self._flat(args, kwargs)
        exported = export.export(jax.jit(flat))(*given)
        try:
            pickle.dumps(outlines[-1])
            return bytes(exported.serialize()), outlines[-1]
        except (pickle.PicklingError, AttributeError, TypeError, NotImplementedError):
            return None

    def _name(self, args, kwargs) -> str | None:
        """Of a program's file: a digest of all that it is made from."""
        arrays, outline = _outlined((args, kwargs))
        stream = io.BytesIO()
        try:
            pickle.dump(outline, stream)
        except (pickle.PicklingError, AttributeError, TypeError):
            return None
        parts = [
            f"{self._function.__module__}.{self._function.__qualname__}",
            _foundation(),
            jax.default_backend(),
            str(jax.config.read("jax_enable_x64")),
            *(str(_type_of(leaf)) for leaf in arrays),
        ]
        digest = hashlib.sha256("\n".join(parts).encode() + b"\n" + stream.getvalue())
        return f"{self._function.__name__}-{digest.hexdigest()[:32]}"


def program(function: _Function) -> _Function:
    """As `equinox.filter_jit`: arrays are traced, everything else is static.

    After `use_cache` its programs are also read from, and written to, the folder of the cache.
    Under `jax.jit`, `jax.vmap` or a derivative it is part of the surrounding program as usual.
    It is compiled in little time; what is worth more is a `hot_program`.
    """
    return _Program(function, QUICK)  # type: ignore[return-value]


def hot_program(function: _Function) -> _Function:
    """As `program`, compiled for longer to run in less time."""
    return _Program(function, HOT)  # type: ignore[return-value]


def quick_jit(function: Callable[..., Any]) -> Callable[..., Any]:
    """As `jax.jit`, compiled as a `program` is: for functions of users, which have no name to be
    kept under."""
    return jax.jit(function, compiler_options=known_options(tuple(QUICK.items())))


def _is_within(arrays) -> bool:
    """Whether a call is part of another program, whose options hold for it then."""
    global _outside
    if any(isinstance(array, jax.core.Tracer) for array in arrays):
        return True
    state = get_opaque_trace_state()
    if state == _outside:
        return False
    # Within `jax.jit` even arithmetic on constants is traced.
    if isinstance(jax.lax.neg(0.0), jax.core.Tracer):
        return True
    _outside = state
    return False


def _devices(arrays) -> tuple | None:
    """Where arrays lie, and which are bound to it; `None` if they lie on several devices."""
    if _is_single():
        # To ask each array takes as long as all the rest of a call.
        return ()
    found = [array for array in arrays if isinstance(array, jax.Array)]
    devices = frozenset().union(*(array.sharding.device_set for array in found))
    if len(devices) > 1:
        return None
    return devices, tuple(array.committed for array in found)


def _is_watched() -> bool:
    """Whether JAX is to look at each call itself, for debugging."""
    return any(getattr(jax.config, name) for name in _WATCHED_BY)


@functools.cache
def _is_single() -> bool:
    """Whether there is but one device; beside a GPU there always is the CPU."""
    return jax.device_count() == 1 and jax.default_backend() == "cpu"


def _type_of(leaf) -> tuple:
    return leaf.shape, leaf.dtype, bool(getattr(leaf, "weak_type", False))


def _outlined(tree) -> tuple[list[jax.Array], Any]:
    arrays = [leaf for leaf in jax.tree.leaves(tree) if eqx.is_array(leaf)]
    numbers = iter(range(len(arrays)))
    outline = jax.tree.map(lambda x: _Slot(next(numbers)) if eqx.is_array(x) else x, tree)
    return arrays, outline


@functools.cache
def _foundation() -> str:
    """Digest of the package's source and of the versions that it stands on."""
    digest = hashlib.sha256()
    root = pathlib.Path(__file__).parent
    for file in sorted(root.rglob("*.py")):
        digest.update(str(file.relative_to(root)).encode() + file.read_bytes())
    for name in _UNDER:
        digest.update(f"{name} {importlib.metadata.version(name)}\n".encode())
    return digest.hexdigest()
