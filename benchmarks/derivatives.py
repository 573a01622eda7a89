"""What derivatives cost: the gradient of a batch of solves, and Π_y beside the values."""

import jax
import jax.numpy as jnp
import numpy as np

import cpr_jax as cpr
from cpr_jax.analysis.parameters import select

from .peers import POINT
from .result import Result, Table, at_most
from .timing import first_call, take_turns

DESIGN = ("k_b1", "k_b2", "r_c1", "r_c2", "l1", "l2", "a1", "a2", "b1", "b2")
"""The design parameters of the gradient."""

GRADIENT, SENSITIVITY = 4.0, 1.3
"""How many times the batch solve its gradient may take, and values with Π_y the values."""

LANES = 1024

_AROUND = 0.02


def targets(lanes: int) -> jax.Array:
    """End-effectors around `POINT`, m."""
    spread = np.random.default_rng(0).uniform(-_AROUND, _AROUND, (lanes, 2))
    return jnp.asarray(POINT + spread)


def run(quick: bool) -> Result:
    """Solves of a batch of targets, from the equilibrium in their middle."""
    robot = cpr.rfrfr()
    middle = cpr.solve_inverse(robot, POINT)
    design = select(robot, DESIGN)
    rho, points = design.get(robot), targets(LANES)

    def solved(robot, point) -> cpr.Equilibrium:
        return cpr.solve_inverse(robot, point, guess=middle, throw=False)

    def objective(rho, points):
        varied = design.set(robot, rho)
        return jnp.mean(jax.vmap(lambda point: jnp.sum(solved(varied, point).q_a ** 2))(points))

    def with_sensitivity(point):
        equilibrium = solved(robot, point)
        return equilibrium.y, cpr.sensitivity(robot, equilibrium).Pi_y

    value, gradient = jax.jit(objective), jax.jit(jax.value_and_grad(objective))
    values = jax.jit(jax.vmap(lambda point: solved(robot, point).y))
    with_Pi = jax.jit(jax.vmap(with_sensitivity))
    calls = {
        "mean objective of the batch": lambda: value(rho, points),
        f"with its gradient in {len(DESIGN)} design parameters": lambda: gradient(rho, points),
        "values y": lambda: values(points),
        "values y with Π_y": lambda: with_Pi(points),
    }
    firsts = {name: first_call(call) for name, call in calls.items()}
    # Clearing the caches for one first call has cleared those of the calls before it.
    for call in calls.values():
        call()
    timings = take_turns(calls, 3 if quick else 9)
    rows, ratios = [], {}
    for name, beside in zip(calls, [0, 0, 2, 2], strict=True):
        wall = timings[name].wall
        ratios[name] = wall / timings[list(calls)[beside]].wall
        first = firsts[name]
        rows.append([name, first.compile, first.total, wall / LANES, ratios[name]])
    columns = [
        ("what", "text"),
        ("compilation", "time"),
        ("first call", "time"),
        ("per lane", "time"),
        ("times", "ratio"),
    ]
    _, gradient_name, _, both_name = calls
    verdicts = [
        at_most("batch gradient, times the batch solve", ratios[gradient_name], GRADIENT),
        at_most("values with Π_y, times the values alone", ratios[both_name], SENSITIVITY),
    ]
    title = f"Derivatives of a batch of {LANES:,} inverse solves"
    return Result([Table(title, columns, rows)], verdicts, {}, [])
