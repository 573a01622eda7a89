"""What one percent of hard lanes costs a batch."""

from unittest import mock

import jax
import jax.numpy as jnp
import numpy as np

import cpr_jax as cpr
from cpr_jax.studies import samples

from .derivatives import LANES, targets
from .peers import POINT
from .result import Result, Table, at_most
from .timing import take_turns

REQUIRED = 1.3
"""How many times the time of a batch without hard lanes one with 1 % of them may take."""

SHARE = 0.01

_SAMPLES = 100_000
_STEPS = 5
_FAR = (0.06, 0.06)
"""A target far from the start of the solves, m."""


def run(quick: bool) -> Result:
    """Monte Carlo with samples that must be followed, and solves under `vmap` with a long way."""
    robot = cpr.rfrfr()
    middle = cpr.solve_inverse(robot, POINT)
    count = _SAMPLES // 5 if quick else _SAMPLES

    def study(scale: float, patience: int = samples.PATIENCE) -> cpr.MonteCarlo:
        delta = {name: scale * float(value) for name, value in robot.uncertainty.items()}
        with mock.patch.object(samples, "PATIENCE", patience):
            return cpr.monte_carlo(robot, middle, count, delta=delta, steps=_STEPS)

    @jax.jit
    @jax.vmap
    def solved(point):
        return cpr.solve_inverse(robot, point, guess=middle, throw=False)

    scale = _scale_with(SHARE, study)
    easy = targets(LANES)
    lanes = np.arange(0, LANES, round(1.0 / SHARE))
    hard = easy.at[lanes].set(jnp.asarray(_FAR))
    calls = {
        "Monte Carlo, hard samples given up": lambda: study(scale, 0),
        "Monte Carlo, hard samples followed": lambda: study(scale),
        "solve_inverse under vmap, all near": lambda: solved(easy),
        "solve_inverse under vmap, 1 % far": lambda: solved(hard),
    }
    followed = study(scale).followed / count
    shares = [followed, followed, 0.0, len(lanes) / LANES]
    for call in calls.values():
        jax.block_until_ready(call())
    timings = take_turns(calls, 3 if quick else 7)
    names, rows, ratios = list(calls), [], []
    for k, (name, share) in enumerate(zip(names, shares, strict=True)):
        wall, lanes_in = timings[name].wall, count if k < 2 else LANES
        ratios.append(wall / timings[names[k - k % 2]].wall)
        rows.append([name, lanes_in, f"{100 * share:.2g} %", wall / lanes_in, ratios[-1]])
    columns = [
        ("batch", "text"),
        ("lanes", "count"),
        ("hard", "text"),
        ("per lane", "time"),
        ("times", "ratio"),
    ]
    verdicts = [
        at_most("1 % hard samples of Monte Carlo, times giving them up", ratios[1], REQUIRED),
        at_most("1 % hard lanes under vmap, times none", ratios[3], REQUIRED),
    ]
    return Result([Table("One percent of hard lanes", columns, rows)], verdicts, {}, [])


def _scale_with(share: float, study) -> float:
    """How much larger uncertainties must be for this share of samples to be followed."""
    low, high = 0.5, 3.0
    for _ in range(8):
        scale = 0.5 * (low + high)
        found = study(scale)
        low, high = (scale, high) if found.followed < share * found.samples else (low, scale)
    return high
