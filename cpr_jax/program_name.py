"""The name that a program is kept under: a digest of all that it is made from."""

import functools
import hashlib
import importlib.metadata
import io
import pathlib
import pickle
from collections.abc import Callable
from typing import Any

import jax

from .outline import outlined, type_of
from .surroundings import is_on_cpu

_UNDER = ("jax", "jaxlib", "equinox", "diffrax", "optimistix", "lineax", "numpy", "scipy")
"""Distributions that a traced program depends on."""


def name_of(function: Callable[..., Any], args, kwargs) -> str | None:
    """Of the file of a program; `None` for one that cannot be kept."""
    arrays, outline = outlined((args, kwargs))
    stream = io.BytesIO()
    try:
        pickle.dump(outline, stream)
    except (pickle.PicklingError, AttributeError, TypeError):
        return None
    parts = [
        f"{function.__module__}.{function.__qualname__}",
        _foundation(),
        "cpu" if is_on_cpu(arrays) else jax.default_backend(),
        str(jax.config.read("jax_enable_x64")),
        *(str(type_of(leaf)) for leaf in arrays),
    ]
    digest = hashlib.sha256("\n".join(parts).encode() + b"\n" + stream.getvalue())
    return f"{function.__name__}-{digest.hexdigest()[:32]}"


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
