"""What a task finds: tables, verdicts on requirements, and series for the figure."""

from collections.abc import Sequence
from typing import Any, NamedTuple


class Table(NamedTuple):
    """Measured rows.

    **Attributes:**

    - `title`: a sentence.
    - `columns`: heading and kind of each: `text`, `count`, `time` (s), `error` (m), `ratio`,
        `rate` (1/s) or `memory` (MB).
    - `rows`: of plain numbers and strings; `None` where nothing was measured.
    """

    title: str
    columns: list[tuple[str, str]]
    rows: list[list[Any]]


class Verdict(NamedTuple):
    """Whether a requirement holds.

    **Attributes:**

    - `requirement`: what is asked for.
    - `measured`, `bound`: in its units; `least`: whether the bound is a lower one.
    """

    requirement: str
    measured: float
    bound: float
    least: bool

    @property
    def holds(self) -> bool:
        return self.measured >= self.bound if self.least else self.measured <= self.bound


def at_least(requirement: str, measured: float, bound: float) -> Verdict:
    """A requirement with a lower bound."""
    return Verdict(requirement, float(measured), float(bound), True)


def at_most(requirement: str, measured: float, bound: float) -> Verdict:
    """A requirement with an upper bound."""
    return Verdict(requirement, float(measured), float(bound), False)


class Result(NamedTuple):
    """Outcome of a task.

    **Attributes:**

    - `series`: curves of the figure: name, then points `(x, y)`, by panel.
    - `notes`: sentences, such as which peers are missing.
    """

    tables: list[Table]
    verdicts: list[Verdict]
    series: dict[str, dict[str, list[tuple[float, float]]]]
    notes: list[str]


def from_plain(content: dict[str, Any]) -> Result:
    """A result as it was written to JSON by its fields."""
    return Result(
        [Table(*table) for table in content["tables"]],
        [Verdict(*verdict) for verdict in content["verdicts"]],
        content["series"],
        content["notes"],
    )


def shown(value: Any, kind: str) -> str:
    """A number as tables have it."""
    if value is None:
        return ""
    if kind == "time":
        return _time(value)
    formats = {"text": "{}", "count": "{:,}", "error": "{:.0e}", "memory": "{:,.0f} MB"}
    if kind in formats:
        return formats[kind].format(value)
    digits = max(0, 2 - len(str(int(abs(value)))))
    return f"{value:,.{digits}f}" + ("×" if kind == "ratio" else "")


def _time(seconds: float) -> str:
    for unit, factor in (("s", 1.0), ("ms", 1e3)):
        if seconds * factor >= 1.0:
            return f"{seconds * factor:.3g} {unit}" if seconds < 1e3 else f"{seconds:.0f} s"
    return f"{seconds * 1e6:.3g} µs" if seconds * 1e6 < 1e3 else f"{seconds * 1e3:.2f} ms"


def as_text(table: Table) -> list[str]:
    """Lines of a table for a terminal."""
    cells = _cells(table)
    widths = [max(len(row[k]) for row in cells) for k in range(len(table.columns))]
    return [table.title, *("  ".join(_padded(row, widths, table)).rstrip() for row in cells)]


def as_markdown(table: Table) -> list[str]:
    """Lines of a table for a document."""
    head, *body = ["| " + " | ".join(row) + " |" for row in _cells(table)]
    rule = "|" + "|".join("---" if kind == "text" else "---:" for _, kind in table.columns) + "|"
    return [f"**{table.title}**", "", head, rule, *body, ""]


def verdict_lines(verdicts: Sequence[Verdict]) -> list[tuple[str, str, str]]:
    """Requirement, what was measured, and whether it holds."""
    lines = []
    for verdict in verdicts:
        sign = "≥" if verdict.least else "≤"
        measured = f"{verdict.measured:,.3g} ({sign} {verdict.bound:,.6g})"
        if verdict.measured >= 1e3:
            measured = f"{verdict.measured:,.0f} ({sign} {verdict.bound:,.0f})"
        lines.append((verdict.requirement, measured, "holds" if verdict.holds else "does not hold"))
    return lines


def _cells(table: Table) -> list[list[str]]:
    kinds = [kind for _, kind in table.columns]
    body = [[shown(v, k) for v, k in zip(row, kinds, strict=True)] for row in table.rows]
    return [[heading for heading, _ in table.columns], *body]


def _padded(row: list[str], widths: list[int], table: Table) -> list[str]:
    kinds = [kind for _, kind in table.columns]
    return [
        cell.ljust(width) if kind == "text" else cell.rjust(width)
        for cell, width, kind in zip(row, widths, kinds, strict=True)
    ]
