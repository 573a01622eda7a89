"""Reports of a run: on the terminal, as JSON, in the README of this folder."""

import json
import pathlib
import re
from typing import Any

from cpr_jax.atomic import write_atomically
from cpr_jax.plain import plain

from .result import Result, as_markdown, as_text, from_plain, verdict_lines

_README = pathlib.Path(__file__).with_name("README.md")
_BEGIN, _END = "<!-- last run -->", "<!-- end of the last run -->"


def print_result(name: str, entry: dict[str, Any]) -> None:
    """Prints what a task found."""
    result = from_plain(entry)
    print(f"\n{name}: {_times(entry)}")
    for table in result.tables:
        print("\n" + "\n".join(as_text(table)))
    print_verdicts(result)
    print("\n".join(["", *result.notes]) if result.notes else "", flush=True)


def print_verdicts(result: Result) -> None:
    """Prints a line for each requirement."""
    lines = verdict_lines(result.verdicts)
    if not lines:
        return
    print()
    widths = [max(len(line[k]) for line in lines) for k in range(2)]
    for text, measured, verdict in lines:
        print(f"{text:{widths[0]}}  {measured:>{widths[1]}}  {verdict}")


def save(run: dict[str, Any], file: pathlib.Path) -> None:
    """Writes a run, so that what is measured outlives it."""
    file.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(plain(run), indent=1, ensure_ascii=False) + "\n"
    write_atomically(file, lambda part: part.write_text(text))


def load_run(file: pathlib.Path) -> dict[str, Any]:
    """A run that was saved."""
    return json.loads(file.read_text())


def publish(run: dict[str, Any]) -> None:
    """Puts the tables and verdicts of a run into the README of this folder."""
    section = "\n".join([_BEGIN, "", *_markdown(run), _END])
    text = _README.read_text()
    found = re.compile(f"{re.escape(_BEGIN)}.*{re.escape(_END)}", re.DOTALL)
    new = found.sub(lambda _: section, text)
    write_atomically(_README, lambda part: part.write_text(new))


def _markdown(run: dict[str, Any]) -> list[str]:
    where = run["environment"]
    versions = ", ".join(f"{name} {version}" for name, version in where["versions"].items())
    lines = [f"{where['cores']} cores of an {where['processor']}; {versions}.", ""]
    results = {name: from_plain(entry) for name, entry in run["tasks"].items()}
    lines += ["| requirement | measured | |", "|---|---:|---|"]
    for result in results.values():
        lines += ["| " + " | ".join(line) + " |" for line in verdict_lines(result.verdicts)]
    for name, result in results.items():
        lines += ["", f"### {name}", "", _times(run["tasks"][name]), ""]
        for table in result.tables:
            lines += as_markdown(table)
        lines += result.notes
    return [*lines, ""]


def _times(entry: dict[str, Any]) -> str:
    before, after = (", ".join(map(str, entry[key])) for key in ("load_before", "load_after"))
    return f"{entry['seconds']:.0f} s, load average {before} before, {after} after."
