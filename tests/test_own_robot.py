"""The robot of one's own that the documentation builds."""

import pytest

import cpr_jax
from tests.readme import ROOT, code_of, printed_arrays


def test_a_robot_of_ones_own(capsys):
    """The solve holds, and the slope of the energy is that of two more solves."""
    page = (ROOT / "docs" / "robots-in-python.md").read_text()
    names: dict = {}
    exec(code_of(page, "own"), names)
    slope = float(printed_arrays(capsys)[-1])
    step = 1e-6
    ends = [
        cpr_jax.solve_inverse(names["build"](0.002 + sign * step), (0.01, -0.01, 0.1))
        for sign in (1.0, -1.0)
    ]
    by_hand = float(ends[0].measures.energy - ends[1].measures.energy) / (2.0 * step)
    assert slope == pytest.approx(by_hand, rel=1e-5)
