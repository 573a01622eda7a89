"""What is compiled ahead is what a study then calls, and nothing else."""

import threading

import jax.numpy as jnp
import pytest

import cpr_jax as cpr
from cpr_jax import programs
from cpr_jax.analysis.parameters import ranges, select
from cpr_jax.robots.catalogue import rfrfr
from cpr_jax.statics.problem import imposed_rows
from cpr_jax.statics.shape import compile_shape, shape
from cpr_jax.studies import ahead
from cpr_jax.studies.ahead import compile_map, compile_study
from cpr_jax.studies.draws import Distribution
from cpr_jax.studies.follower import Follower
from cpr_jax.studies.monte_carlo import monte_carlo
from cpr_jax.studies.samples import Options, Prediction
from cpr_jax.studies.workspace import _CHUNK, workspace_map

AT_D = (0.05, 0.045)
"""Beside a singularity, where samples need to be followed."""


@pytest.fixture(autouse=True)
def unknown(monkeypatch):
    """As in a process that has compiled nothing ahead, and that has room for all of it."""
    monkeypatch.setattr(ahead, "_known", set())
    monkeypatch.setattr(programs, "make_room", lambda forget: None)


@pytest.fixture(scope="module")
def paper():
    return rfrfr()


def known():
    return {(made.__name__, key) for made in programs._all for key in made._known}


def names(pairs):
    return {name for name, _ in pairs}


def test_a_study(paper):
    study = monte_carlo(paper, cpr.solve_inverse(paper, AT_D), 1000)
    assert study.followed > 0
    called = known()
    assert {"expand", "slopes_at", "_ellipsoid", "_solve_chunk", "_follow_all"} <= names(called)
    selection = select(paper)
    options = Options(selection, Distribution.GAUSSIAN, Prediction.SECOND_ORDER)
    with compile_study(paper, options, ranges(paper, selection, None), followed=True):
        pass
    assert names(known() - called) == set()
    # It is not asked for again, by the whole or by a part.
    for followed in (True, False):
        assert not compile_study(paper, options, ranges(paper, selection, None), followed)._threads


def test_a_map(paper):
    spacing, box, places = 0.01, ((-0.05, 0.05), (0.15, 0.25)), (2, 3)
    workspace_map(paper, spacing=spacing, box=box)
    called = known()
    assert {"from_home", "polish", "_advance", "look_at_cells", "correct_points"} <= names(called)
    selection = select(paper)
    follower = Follower(paper, imposed_rows(paper, places), places, 10)
    half_ranges = ranges(paper, selection, None)
    with compile_map(follower, selection, half_ranges, places, 10, _CHUNK // 8, True) as compiling:
        compiling.wait("look")
    assert names(known() - called) == set()


def test_a_shape(paper):
    drawn = shape(paper, cpr.solve_inverse(paper, (0.0, 0.2)))
    assert drawn.rods.position.shape == (2, 51, 2)
    called = known()
    compile_shape(paper)
    assert "_shape" in names(called) and names(known() - called) == set()


def test_what_fails_ahead_is_left_for_the_call(paper, monkeypatch):
    """Nothing is printed of a mistake in a thread: who calls the program meets it."""
    printed: list = []
    monkeypatch.setattr(threading, "excepthook", printed.append)
    selection = select(paper)
    options = Options(selection, Distribution.GAUSSIAN, Prediction.SECOND_ORDER)
    with compile_study(paper, options, jnp.ones(7)) as failing:
        assert failing._threads
    assert not printed
    study = monte_carlo(paper, cpr.solve_inverse(paper, (0.0, 0.25)), 1000)
    assert study.solved == 1000
