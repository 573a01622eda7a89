"""How time grows with samples, with legs and with devices."""

import functools
from typing import Any

import numpy as np

import cpr_jax as cpr
from cpr_jax.robots.catalogue_space import GRAVITY

from .child import available_cores, measured_apart
from .peers import POINT
from .result import Result, Table, Verdict, at_most
from .timing import first_call, take_turns

SAMPLES = (100, 1_000, 10_000, 100_000, 1_000_000)
LEGS = (3, 6, 12)

_RADIUS, _LENGTH, _MASS = 0.087, 0.4, 0.1
_DEVICE_SAMPLES = 200_000


def run(quick: bool) -> Result:
    """All three, one after the other."""
    samples = _samples(SAMPLES[:-1] if quick else SAMPLES)
    legs = _legs(LEGS[:-1] if quick else LEGS)
    devices = _devices(_DEVICE_SAMPLES // 10 if quick else _DEVICE_SAMPLES)
    series = {
        "samples": {"cpr_jax": [(row[0], row[1]) for row in samples.rows]},
        "legs": {
            "first call": [(row[0], row[2]) for row in legs.rows],
            "warm solve": [(row[0], row[3]) for row in legs.rows],
        },
    }
    return Result([samples, legs, devices], _verdicts(legs), series, [])


def _samples(counts: tuple[int, ...]) -> Table:
    robot = cpr.rfrfr()
    equilibrium = cpr.solve_inverse(robot, POINT)
    calls = {
        str(count): functools.partial(cpr.monte_carlo, robot, equilibrium, count)
        for count in counts
    }
    calls[str(counts[0])]()
    timings = take_turns(calls, 3)
    rows = [[n, timings[str(n)].wall, timings[str(n)].wall / n] for n in counts]
    columns = [("samples", "count"), ("whole study", "time"), ("per sample", "time")]
    return Table("Monte Carlo over its samples, warm", columns, rows)


def many_legs(count: int) -> cpr.Robot:
    """A platform on equal upright legs, fed rods of 1 mm radius clamped but for their twist."""
    steel = cpr.Material(E=200e9, nu=0.25, density=8000.0)
    upright, force = (0.0, -np.pi / 2.0, 0.0), (0.0, 0.0, -GRAVITY)
    # A little curved: rods that are quite straight take a program more to be put together.
    rod = cpr.section_rod(cpr.SPACE, _LENGTH, cpr.circle(0.001), steel, 0.5, gravity=force)
    bases = 2.0 * np.pi * np.arange(count) / count
    # Each leg leans to one side, the next one to the other.
    places = bases + np.where(np.arange(count) % 2 == 0, 0.7, -0.7) * (count % 2 == 0)

    def ring(angle: float) -> tuple[float, float, float]:
        return (_RADIUS * np.cos(angle), _RADIUS * np.sin(angle), 0.0)

    legs = [
        cpr.make_leg(
            cpr.SPACE,
            ring(base),
            rod,
            base_rotation=upright,
            screw=np.zeros(6),
            feed=1.0,
            joint=cpr.swivel(cpr.SPACE),
            attachment_position=ring(place),
            attachment_rotation=upright,
        )
        for base, place in zip(bases, places, strict=True)
    ]
    return cpr.make_robot(
        cpr.SPACE,
        legs,
        oriented=True,
        loads=[((0.0, 0.0, 0.0), (0.0, 0.0, -_MASS * GRAVITY))],
        home=(np.full(count, 0.01), (0.0, 0.0, _LENGTH, 0.0, 0.0, 0.0)),
        name=f"{count} legs",
    )


def _legs(counts: tuple[int, ...]) -> Table:
    rows: dict[int, list[Any]] = {}
    # In turns, of which the quicker counts: one of them may meet a busy machine.
    for count in 2 * counts:
        feeds = 0.02 + 0.005 * np.cos(2.0 * np.pi * np.arange(count) / count)
        solve = functools.partial(cpr.solve_forward, many_legs(count), feeds)
        call = first_call(solve)
        if count not in rows or call.compile < rows[count][1]:
            warm = take_turns({"solve": solve}, 5)["solve"].wall
            rows[count] = [count, call.compile, call.total, warm]
    columns = [
        ("legs", "count"),
        ("compilation", "time"),
        ("first call", "time"),
        ("warm solve", "time"),
    ]
    title = "Spatial robots of equal legs, a forward solve from home"
    return Table(title, columns, list(rows.values()))


def _verdicts(legs: Table) -> list[Verdict]:
    compilation = {row[0]: row[1] for row in legs.rows}
    verdicts = [at_most("compilation of a six-leg solve, s", compilation[6], 15.0)]
    if 12 in compilation:
        growth = compilation[12] / compilation[3]
        verdicts.append(at_most("compilation with 12 legs, times that with 3", growth, 1.2))
    return verdicts


def _devices(samples: int) -> Table:
    cores = len(available_cores())
    settings = sorted({(1, 1), (cores, 1), (cores, 2)})
    rows: list[list[Any]] = []
    for used, devices in settings:
        arguments = {"samples": samples}
        seconds = measured_apart("scaling", "study_time", arguments, cores=used, devices=devices)
        rows.append([used, devices, samples, seconds / samples])
    columns = [
        ("cores", "count"),
        ("CPU devices", "count"),
        ("samples", "count"),
        ("per sample", "time"),
    ]
    return Table("Monte Carlo over cores and JAX devices, each in its own process", columns, rows)


def study_time(samples: int) -> float:
    """Median time of a warm study, s."""
    robot = cpr.rfrfr()
    equilibrium = cpr.solve_inverse(robot, POINT)

    def study() -> cpr.MonteCarlo:
        return cpr.monte_carlo(robot, equilibrium, samples)

    study()
    return take_turns({"study": study}, 3)["study"].wall
