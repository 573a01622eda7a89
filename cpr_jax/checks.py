"""What arguments must be, traced ones as far as they are known."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .errors import InputError, shown
from .outline import are_traced


def check_shape(name: str, value: Any, *shapes: tuple[int, ...]) -> None:
    """Refuses numbers, traced ones too, that have none of some shapes."""
    shape = np.shape(jnp.asarray(value) if _is_traced(value) else value)
    if shape not in shapes:
        expected = " or ".join(map(str, shapes))
        raise InputError(f"Argument `{name}` must have shape {expected}, but it has shape {shape}.")


def check_vector(name: str, value: Any, size: int) -> None:
    """Refuses what has not so many numbers in a row; one alone may be a scalar."""
    check_shape(name, value, (size,), *([()] if size == 1 else []))


def check_positive(name: str, value: Any, or_zero: bool = False) -> None:
    """Refuses numbers that are not positive; traced ones are not known."""
    if _is_traced(value):
        return
    expected = "not be negative" if or_zero else "be positive"
    try:
        numbers = np.asarray(value, float)
    except (TypeError, ValueError):
        expected, numbers = "be a number", np.array(np.nan)
    if np.any(np.isnan(numbers) | (numbers < 0.0)) or (not or_zero and np.any(numbers == 0.0)):
        raise InputError(f"Argument `{name}` must {expected}, but it is {shown(value)}.")


def check_between(name: str, value: Any, low: float, high: float) -> None:
    """Refuses numbers outside of bounds, or at the lower one; traced ones are not known."""
    if not _is_traced(value) and not np.all(
        (low < np.asarray(value)) & (np.asarray(value) <= high)
    ):
        raise InputError(
            f"Argument `{name}` must be greater than {low:g} and at most {high:g}, but it is "
            f"{shown(value)}."
        )


def check_finite(name: str, value: Any) -> None:
    """Refuses what is infinite, NaN or no number; traced ones are not known."""
    if _is_traced(value):
        return
    try:
        finite = np.all(np.isfinite(np.asarray(value, float)))
    except (TypeError, ValueError):
        raise InputError(f"Argument `{name}` must be numbers, but it is {shown(value)}.") from None
    if not finite:
        raise InputError(f"Argument `{name}` must be finite, but it is {shown(value)}.")


def finite_rows(name: str, values: Any, labels: Sequence[str], least: int = 1) -> np.ndarray:
    """Rows of finite numbers as an array, one number for each label; refuses anything else."""
    try:
        rows = np.asarray(values, float)
    except (TypeError, ValueError):
        rows = np.empty(0)
    if rows.ndim != 2 or len(rows) < least or rows.shape[1] != len(labels):
        count = "rows" if least == 1 else f"at least {least} rows"
        raise InputError(
            f"Argument `{name}` must be {count} of {len(labels)} numbers ({', '.join(labels)}), "
            f"but it is {shown(values)}."
        )
    check_finite(name, rows)
    return rows


def check_on_map(
    name: str, points: np.ndarray, labels: Sequence[str], lines: Sequence[np.ndarray]
) -> None:
    """Refuses points of which one lies further off a map than half a cell.

    **Arguments:**

    - `points`: finite, shape `(k, 2)`.
    - `lines`: the coordinates of the cells along each axis, equidistant.
    """
    for values, label, line in zip(points.T, labels, lines, strict=True):
        half = 0.5 * (line[1] - line[0])
        off = values[(values < line[0] - half) | (values > line[-1] + half)]
        if len(off) == 0:
            continue
        mirrored = line[0] == 0.0 and -line[-1] - half <= off[0] < 0.0
        raise InputError(
            f"Argument `{name}` must be on the map, whose {label} goes from {line[0]:g} to "
            f"{line[-1]:g} in SI units, but its {label} is {off[0]:g}."
            + (" A map of both halves takes `symmetry=False`." if mirrored else "")
        )


def check_kind(name: str, value: Any, kind: type, example: str) -> None:
    """Refuses what is no instance of a class.

    **Arguments:**

    - `example`: what is expected, in words.
    """
    if not isinstance(value, kind):
        raise InputError(
            f"Argument `{name}` must be {example}, but it is {shown(value)} of type "
            f"{type(value).__name__}."
        )


def _is_traced(value: Any) -> bool:
    return are_traced(jax.tree.leaves(value))
