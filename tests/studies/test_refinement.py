"""Which cell stands for which on a refined map."""

from types import SimpleNamespace

import numpy as np
import pytest

from cpr_jax.studies.front import Front
from cpr_jax.studies.refinement import representatives


def square(count, margin, seed):
    """What a front tells of a square grid, all of which is inside."""
    inner = (slice(margin, -margin),) * 2
    inside = np.zeros((count + 2 * margin,) * 2, bool)
    inside[inner] = True
    front = SimpleNamespace(inside=inside, inner=inner, margin=margin)
    front.seed = (seed[0] + margin, seed[1] + margin)
    front.lattice = lambda stride: Front.lattice(front, stride)
    return front


@pytest.mark.parametrize("stride", [2, 4, 8])
@pytest.mark.parametrize("count", [9, 10, 12, 15])
@pytest.mark.parametrize("seed", [(0, 0), (3, 7), (8, 5)])
def test_every_cell_has_one_close_by(stride, count, seed):
    """At the edges, too, beyond which the next cell of the lattice would lie."""
    front = square(count, stride, seed)
    (rows, columns), level = representatives(front, {stride: front.inside})
    own = np.indices((count, count))
    assert np.all(front.lattice(stride)[front.inner][rows, columns])
    away = np.abs(np.stack([rows, columns]) - own)
    assert np.max(away) < stride
    # Where the lattice goes on to both sides it is the nearest.
    middle = away[:, stride : count - stride, stride : count - stride]
    assert middle.size == 0 or np.max(middle) <= stride // 2
    assert not np.any(level)


def test_cells_of_a_finer_lattice_stand_for_what_is_around_them():
    front = square(9, 4, (0, 0))
    fine = np.zeros_like(front.inside)
    fine[front.inner][:5, :5] = True
    (rows, columns), level = representatives(front, {4: front.inside, 2: fine})
    assert (rows[2, 4], columns[2, 4], level[2, 4]) == (2, 4, 1)
    assert (rows[8, 7], columns[8, 7], level[8, 7]) == (8, 8, 0)
