"""Entry point: arguments are checked, and refused, before JAX is imported."""

import contextlib
import os
import pathlib
import re
import sys
import warnings
from collections.abc import Sequence
from typing import NoReturn

from ..collection import uncollected
from ..errors import InputError
from . import inputs, map_inputs, path_inputs
from .parser import build_parser

EXIT_INPUT = 2
EXIT_NO_SOLUTION = 3


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command; returns its exit code."""
    arguments = build_parser().parse_args(
        _protect_negatives(sys.argv[1:] if argv is None else argv)
    )
    warnings.showwarning = _show_warning
    try:
        with uncollected():
            return _run(arguments)
    except InputError as error:
        _complain(str(error))
        return EXIT_INPUT
    except BrokenPipeError:
        return 0
    except OSError as error:
        # What is read has messages of its own; what is left is what a command writes.
        place, reason = error.filename, error.strerror or str(error)
        option = "--figure" if arguments.command == "robots" else "--out"
        if place is None:
            _complain(f"the results cannot be written: {reason}")
            return EXIT_INPUT
        _complain(
            f"Argument `{option}` must be a place to write to, but {place!r} is not: {reason}."
        )
        return EXIT_INPUT
    except KeyboardInterrupt:
        kept = hasattr(arguments, "resume") and _has_parts(arguments.out)
        _complain("interrupted; --resume goes on with it" if kept else "interrupted")
        return 130


def command() -> NoReturn:
    """The command `cpr-jax`: `main` in a process of its own, which it ends."""
    code = main()
    with contextlib.suppress(BrokenPipeError):
        sys.stdout.flush()
        sys.stderr.flush()
    # All files are closed by now; what an interpreter tidies up at its end takes it half a second.
    os._exit(code)


def _has_parts(out: str | None) -> bool:
    """Whether a run to a file or into a folder has left parts to go on with."""
    if out is None:
        return False
    folders = pathlib.Path(f"{out}.parts"), pathlib.Path(out) / "parts"
    return any(path for folder in folders for path in folder.rglob("*.npz"))


def _run(arguments) -> int:
    if arguments.command == "robots":
        return _robots(arguments)
    if arguments.command == "validate":
        return _validate(arguments)
    if arguments.command == "paper":
        samples = inputs.positive_integer("--samples", arguments.samples, least=100)
        seed = inputs.positive_integer("--seed", arguments.seed, least=0)
        from .paper import paper

        return paper(arguments.out, samples, seed, arguments.json)

    request = inputs.check(arguments)
    if arguments.command == "monte-carlo":
        samples = inputs.positive_integer("--samples", arguments.samples)
        if arguments.resume and arguments.out is None:
            raise InputError("Argument `--resume` must come with `--out`, but there is none.")
        seed = inputs.positive_integer("--seed", arguments.seed, least=0)
        keep = inputs.positive_integer("--keep", arguments.keep)
    if arguments.command == "workspace":
        options = map_inputs.check_map(arguments, request)
    if arguments.command == "trajectory":
        path = path_inputs.check_path(arguments, request)
    from . import commands, session

    try:
        if arguments.command == "trajectory":
            from . import following

            return following.trajectory(request, path, arguments.json)
        if arguments.command == "workspace":
            from . import mapping

            return mapping.workspace(request, options, arguments.json)
        if arguments.command == "solve":
            return commands.solve(request, arguments.json)
        if arguments.command == "sensitivity":
            return commands.sensitivity(request, arguments.hold, arguments.json)
        return commands.monte_carlo(
            request,
            samples,
            seed,
            arguments.distribution,
            arguments.prediction,
            keep,
            arguments.out,
            arguments.resume,
            arguments.json,
        )
    except session.NoSolution as failure:
        _complain(str(failure))
        return EXIT_NO_SOLUTION


def _robots(arguments) -> int:
    if arguments.figure is None:
        from . import listing

        return listing.robots(arguments.json)
    file = inputs.figure_file("--figure", arguments.figure)
    from . import gallery, session

    try:
        return gallery.draw_robots(file, arguments.json)
    except session.NoSolution as failure:
        _complain(str(failure))
        return EXIT_NO_SOLUTION


def _validate(arguments) -> int:
    from . import listing

    if arguments.schema:
        return listing.schema()
    mistakes = listing.validate(arguments.files, arguments.json)
    for mistake in mistakes:
        _complain(mistake)
    return EXIT_INPUT if mistakes else 0


def _protect_negatives(argv: Sequence[str]) -> list[str]:
    """argparse takes `-50mm` for an option, unless there is a blank in it."""
    return [f" {word}" if re.match(r"-(\.?\d|inf)", word) else word for word in argv]


def _complain(message: str) -> None:
    print(f"cpr-jax: error: {message}", file=sys.stderr)


def _show_warning(message, category, filename, lineno, file=None, line=None) -> None:
    print(f"cpr-jax: warning: {message}", file=sys.stderr)
