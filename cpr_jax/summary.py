"""Results as `print` shows them: their numbers, in SI units, rather than the shapes of arrays."""

from typing import Any

import jax
import numpy as np

from .outline import are_traced


def summary(result: Any, title: str, **lines: Any) -> str:
    """A title and a line for each number or array; of traced or batched results their structure.

    **Arguments:**

    - `lines`: names and values.
    """
    values = jax.tree.leaves(lines)
    if are_traced(values):
        return repr(result)
    width = max(len(name) for name in lines)
    shown = [title]
    for name, value in lines.items():
        text = value if isinstance(value, str) else _numbers(value)
        indent = "\n" + " " * (width + 4)
        shown.append(f"  {name:<{width}}  {text.replace(chr(10), indent)}")
    return "\n".join(shown)


def in_notebook(self: Any, printer: Any, cycle: bool) -> None:
    """`_repr_pretty_` of what has a summary: a cell of a notebook shows it as `print` does."""
    printer.text(str(self))


def _numbers(value: Any) -> str:
    array = np.asarray(value)
    if array.ndim == 0:
        return f"{array.item():.6g}"
    return np.array2string(array, formatter={"float_kind": lambda x: f"{x: .6g}"}, separator=" ")
