"""What the numbers of a map are called."""

import cpr_jax as cpr
from cpr_jax.studies.variables import unknowns_of_legs

from ..robots.test_embedding import planar_robot


def test_unknowns_of_legs_are_wrenches_where_nothing_moves_at_the_base():
    names = unknowns_of_legs(cpr.rfrfr())
    assert names["wrench"] == ["n_y", "n_z", "m_x"]
    assert names["mu_label"][1].tolist() == [["n1_y", "n1_z", "m1_x"], ["n2_y", "n2_z", "m2_x"]]
    assert names["mu_unit"][1].tolist() == [["N", "N", "N m"]] * 2


def test_unknowns_of_passive_joints_are_not_called_wrenches():
    """A passive pivot, a passive slide along its second axis, and a clamp."""
    names = unknowns_of_legs(planar_robot())
    assert names["wrench"] == ["1", "2", "3"]
    assert names["mu_label"][1].tolist() == [
        ["n1_1", "n1_2", "eta1_3"],
        ["n2_1", "s2_2", "m2_3"],
        ["n3_1", "n3_2", "m3_3"],
    ]
    assert names["mu_unit"][1].tolist() == [["N", "N", "rad"], ["N", "m", "N m"], ["N", "N", "N m"]]
