"""`python -m benchmarks`: the project beside its peers, at equal accuracy, in one run."""

import argparse
import importlib
import pathlib
import time
from typing import Any

import jax

jax.config.update("jax_enable_x64", True)

from .figure import draw  # noqa: E402
from .report import load_run, print_result, publish, save  # noqa: E402
from .timing import environment, load  # noqa: E402

TASKS = {
    "monte-carlo": "monte_carlo",
    "precision": "precision",
    "maps": "maps",
    "derivatives": "derivatives",
    "hard-lanes": "hard_lanes",
    "scaling": "scaling",
    "six-legs": "six_legs",
}
"""Modules of the tasks by name, in the order of the run."""

_PICTURE = pathlib.Path(__file__).with_name("benchmarks")


def main() -> int:
    """Runs the tasks one after the other; what is finished is printed and written at once."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "--tasks", nargs="+", choices=TASKS, default=list(TASKS), help="by default all"
    )
    parser.add_argument("--quick", action="store_true", help="small sizes, few repeats")
    parser.add_argument(
        "--out",
        type=pathlib.Path,
        default=pathlib.Path("results") / "benchmarks",
        metavar="FOLDER",
        help="for run.json and benchmarks.png (default: results/benchmarks)",
    )
    parser.add_argument(
        "--add", action="store_true", help="keep the other tasks of the run in the folder"
    )
    parser.add_argument(
        "--publish", action="store_true", help="refresh the README and the figure beside it"
    )
    parser.add_argument(
        "--no-run", action="store_true", help="only show or publish the run in the folder"
    )
    arguments = parser.parse_args()

    file = arguments.out / "run.json"
    kept = arguments.add or arguments.no_run
    tasks: dict[str, Any] = load_run(file)["tasks"] if kept and file.exists() else {}
    run = {"environment": environment(), "tasks": tasks}
    if arguments.no_run:
        run = load_run(file)
        for name, entry in tasks.items():
            print_result(name, entry)
    else:
        for name in arguments.tasks:
            tasks[name] = _measured(name, arguments.quick)
            run["tasks"] = {key: tasks[key] for key in TASKS if key in tasks}
            save(run, file)
            print_result(name, tasks[name])
    draw(run, arguments.out / "benchmarks")
    if arguments.publish:
        draw(run, _PICTURE)
        publish(run)
    return 0


def _measured(name: str, quick: bool) -> dict[str, Any]:
    """A task's result with the load of the machine before and after."""
    before, begin = load(), time.perf_counter()
    result = importlib.import_module(f".{TASKS[name]}", __package__).run(quick)
    return {
        "load_before": before,
        "load_after": load(),
        "seconds": time.perf_counter() - begin,
        **result._asdict(),
    }


if __name__ == "__main__":
    raise SystemExit(main())
