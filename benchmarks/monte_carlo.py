"""Monte Carlo at (0, 0.2): cpr_jax and its peers on the same samples, at equal accuracy."""

import functools
from collections.abc import Callable

import numpy as np

import cpr_jax as cpr

from .child import available_cores
from .peers import POINT, Field, Reached, field, in_words
from .result import Result, Table, Verdict, at_least, at_most
from .timing import FirstCall, first_call, take_turns

ACCURACY = 1e-8
"""Largest error of a platform coordinate that counts as accurate, m."""

FEW, MANY, MOST = 2_000, 50_000, 1_000_000
"""Samples of the small study, of that beside fast peers, and of the large one."""

FASTER = {"scipy, as printed": 5000.0, "scipy, lean": 5000.0}
"""How many times faster per sample cpr_jax is to be."""

FASTER_THAN_FAST = {"CasADi": 50.0, "diffrax and optimistix": 150.0}

NATIVE, LONGEST = 5.0, 10.0
"""How many times slower than C++ it may be; how long the large study may take, s."""

ROUNDS = 5


def run(quick: bool) -> Result:
    """Measures cpr_jax at this accuracy beside each peer's coarsest accurate setting."""
    firsts = _first_calls()
    samples = MANY // 5 if quick else MANY
    sizes = [FEW, samples] + ([] if quick else [MOST])
    everyone = field(samples)
    notes = list(everyone.missing)
    reached: dict[str, Reached] = {}
    for name, ladder in everyone.ladders.items():
        if name == "cpr_jax":
            continue
        found = ladder.reach(ACCURACY)
        if found is None:
            notes.append(f"{name} is left out: none of its settings is accurate enough.")
        else:
            reached[name] = found

    calls: dict[str, Callable[[], object]] = {
        f"cpr_jax, {count:,} samples": functools.partial(_study, everyone, count) for count in sizes
    }
    for name, (contender, _, _) in reached.items():
        calls[name] = functools.partial(contender.solve, everyone.rho[: contender.samples])
    own = _study(everyone, samples)
    timings = take_turns(calls, 2 if quick else ROUNDS)
    error = float(np.max(np.abs(own.q_p - everyone.exact)))
    beside = timings[f"cpr_jax, {samples:,} samples"].wall / samples
    rows, per_sample = [], {}
    for count in sizes:
        timing = timings[f"cpr_jax, {count:,} samples"]
        first = firsts["monte_carlo, 2,000 samples"].total if count == FEW else None
        per_sample[f"cpr_jax, {count:,}"] = timing.wall / count
        name = f"cpr_jax, {in_words(own.scheme)}, {len(available_cores())} threads"
        wall, cpu = timing.wall / count, timing.cpu / count
        rows.append([name, count, first, wall, cpu, error, wall / beside])
    for name, (contender, first, error) in reached.items():
        count, timing = contender.samples, timings[name]
        per_sample[name] = timing.wall / count
        wall, cpu = timing.wall / count, timing.cpu / count
        rows.append([contender.name, count, first, wall, cpu, error, wall / beside])
    notes.append(
        f"The reference and scipy at its best agree to {everyone.agreement:.0e} m on "
        "the first samples."
    )
    columns = [
        ("program", "text"),
        ("samples", "count"),
        ("first call", "time"),
        ("per sample", "time"),
        ("CPU per sample", "time"),
        ("error", "error"),
        ("times", "ratio"),
    ]
    title = f"Monte Carlo with errors of at most {ACCURACY:.0e} m, warm, by turns"
    series = {"peers": {name: [(0.0, seconds)] for name, seconds in per_sample.items()}}
    tables = [_first_table(firsts), Table(title, columns, rows)]
    return Result(tables, _verdicts(per_sample, samples, sizes), series, notes)


def _study(everyone: Field, count: int) -> cpr.MonteCarlo:
    robot, equilibrium = everyone.robot, everyone.equilibrium
    tolerance = ACCURACY / float(np.max(robot.legs.rod.length))
    return cpr.monte_carlo(robot, equilibrium, count, keep=count, tolerance=tolerance)


def _first_calls() -> dict[str, FirstCall]:
    robot = cpr.rfrfr()
    firsts = {"solve_inverse": first_call(lambda: cpr.solve_inverse(robot, POINT))}
    equilibrium = cpr.solve_inverse(robot, POINT)
    firsts["monte_carlo, 2,000 samples"] = first_call(
        lambda: cpr.monte_carlo(robot, equilibrium, FEW)
    )
    return firsts


def _first_table(firsts: dict[str, FirstCall]) -> Table:
    columns = [("first call", "text"), ("tracing and compilation", "time"), ("whole call", "time")]
    rows = [[name, call.compile, call.total] for name, call in firsts.items()]
    return Table("First calls of cpr_jax, nothing compiled before", columns, rows)


def _verdicts(per_sample: dict[str, float], samples: int, sizes: list[int]) -> list[Verdict]:
    """What is required, wherever the peer was measured."""
    verdicts = []
    for name, bound in FASTER.items():
        for count in sizes:
            ratio = per_sample[name] / per_sample[f"cpr_jax, {count:,}"]
            text = f"times faster per sample than {name}, {count:,} samples"
            verdicts.append(at_least(text, ratio, bound))
    own = per_sample[f"cpr_jax, {samples:,}"]
    for name, bound in FASTER_THAN_FAST.items():
        if name in per_sample:
            text = f"times faster per sample than {name}, {samples:,} samples"
            verdicts.append(at_least(text, per_sample[name] / own, bound))
    cores = len(available_cores())
    native = f"C++, {cores} threads" if cores > 1 else "C++, 1 thread"
    if native in per_sample:
        text = f"times the time of {native}, {samples:,} samples"
        verdicts.append(at_most(text, own / per_sample[native], NATIVE))
    if MOST in sizes:
        whole = MOST * per_sample[f"cpr_jax, {MOST:,}"]
        verdicts.append(at_most("1,000,000 samples, s", whole, LONGEST))
    return verdicts
