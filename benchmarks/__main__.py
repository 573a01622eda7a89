"""`python -m benchmarks`: the project beside its peers."""

import argparse
import json
import pathlib

import jax

jax.config.update("jax_enable_x64", True)

from cpr_jax.atomic import write_atomically  # noqa: E402
from cpr_jax.plain import plain  # noqa: E402

from .monte_carlo import POINT, REQUIRED, Outcome, run  # noqa: E402
from .peers import ACCURACY, PeerRow, run_peers  # noqa: E402
from .timing import environment  # noqa: E402


def main() -> int:
    """Runs the benchmark, prints its tables, writes its numbers."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "--samples",
        type=_positive,
        default=2000,
        metavar="N",
        help="samples of the smaller study; the larger has ten times as many (default: 2000)",
    )
    parser.add_argument(
        "--peer-samples",
        type=_positive,
        default=50_000,
        metavar="N",
        help="samples beside the other peers; slow ones solve fewer (default: 50000)",
    )
    parser.add_argument(
        "--rounds", type=_positive, default=7, metavar="R", help="repeats (default: 7)"
    )
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the numbers")
    arguments = parser.parse_args()

    before = environment()
    outcome = run(arguments.samples, arguments.rounds)
    load_after = environment()["load"]
    print(f"Load average {before['load']} before, {load_after} after; {before['cores']} cores.")
    print(", ".join(f"{name} {version}" for name, version in before["versions"].items()))
    print_tables(outcome)
    rows, missing = run_peers(POINT, arguments.peer_samples, arguments.rounds)
    print_peers(rows, missing)
    if arguments.json is not None:
        report = {
            "rows": [row._asdict() for row in outcome.rows],
            "first_calls": {name: call._asdict() for name, call in outcome.first_calls.items()},
            "peers": [row._asdict() for row in rows],
            "missing_peers": missing,
            "required_ratio": REQUIRED,
            "environment": {**before, "load_after": load_after},
        }
        text = json.dumps(plain(report), indent=2) + "\n"
        write_atomically(arguments.json, lambda file: file.write_text(text))
    return 0


def print_tables(outcome: Outcome) -> None:
    """Prints the first calls, the rows, and whether the requirement holds."""
    print("\nFirst calls of cpr_jax, nothing compiled before")
    print(f"{'':26}{'trace+compile':>14}{'whole call':>12}")
    for name, call in outcome.first_calls.items():
        print(f"{name:26}{call.compile:12.2f} s{call.total:10.2f} s")

    print("\nWarm calls, medians per sample")
    print(f"{'':26}{'samples':>8}{'time':>12}{'CPU time':>12}{'error':>11}")
    for row in outcome.rows:
        wall, cpu = 1e6 * row.wall, 1e6 * row.cpu
        print(f"{row.name:26}{row.samples:8}{wall:9.1f} µs{cpu:9.1f} µs{row.error:9.0e} m")

    print(f"\ncpr_jax is to be {REQUIRED:.0f} times faster per sample, at equal accuracy")
    for row in outcome.rows:
        for peer, ratio in row.ratios.items():
            verdict = "holds" if ratio >= REQUIRED else "does not hold"
            print(f"{row.name:20}{row.samples:7} beside {peer:18}{ratio:7.0f}×  {verdict}")


def print_peers(rows: list[PeerRow], missing: list[str]) -> None:
    """Prints the other peers, and which are missing."""
    print(f"\nOther peers, errors of at most {ACCURACY:.0e} m")
    print(f"{'':44}{'samples':>8}{'first call':>12}{'time':>12}{'error':>9}{'times':>9}")
    for row in rows:
        wall = 1e6 * row.wall
        print(
            f"{row.name:44}{row.samples:8}{row.first:10.2f} s{wall:9.2f} µs"
            f"{row.error:9.0e}{row.ratio:8.1f}×"
        )
    for line in missing:
        print(line)


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("must be at least 1")
    return number


if __name__ == "__main__":
    raise SystemExit(main())
