"""The mistakes of users, apart from those of programs."""

import numbers
from collections.abc import Mapping

_LONGEST = 60


class InputError(ValueError):
    """A mistake in what the user gave; the command line turns it into exit code 2.

    Its message is one line: what must hold, and what was given instead.
    """


def shown(value: object) -> str:
    """A value as an error message shows it: short, on one line, without control characters."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    try:
        text = repr(value) if isinstance(value, str | int | float) else repr(str(value))
    except ValueError:  # Python refuses to print integers of thousands of digits.
        return "a number too long to print"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def check_integer(name: str, value: object, least: int = 1, most: int | None = None) -> None:
    """Refuses an argument that is not an integer within bounds."""
    fits = isinstance(value, int) and not isinstance(value, bool)
    if fits and value >= least and (most is None or value <= most):  # type: ignore[operator]
        return
    expected = f"an integer from {least} " + ("on" if most is None else f"to {most}")
    if (least, most) == (1, None):
        expected = "a positive integer"
    # A number of numpy is an array to a program, which it would become an argument of.
    foreign = isinstance(value, numbers.Integral) and not isinstance(value, int)
    kind = f" of type {type(value).__name__}, not int" if foreign else ""
    raise InputError(f"Argument `{name}` must be {expected}, but it is {shown(value)}{kind}.")
