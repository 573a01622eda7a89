"""Many rods along one axis, in blocks."""

import math

import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax.rods.batching import block_size, over_rods


@pytest.mark.parametrize("numbers", [1, 7, 13, 91, 5000])
def test_blocks_are_powers_of_two_within_their_bounds(numbers):
    size = block_size(numbers)
    assert 32 <= size <= 512
    assert size & (size - 1) == 0


@pytest.mark.parametrize("over", [(), (3,), (3, 5), (4, 20)])
@pytest.mark.parametrize("size", [4, 512])
def test_rods_in_blocks_are_the_rods_themselves(over, size):
    generator = np.random.default_rng(0)
    vector, number = generator.normal(size=(2, *over)), generator.normal(size=over)
    common = generator.normal(size=(2, *(1,) * len(over)))
    number_of_rods = math.prod(over)

    def single(vector, number, common, compact):
        assert compact == (number_of_rods <= 16)
        return {"turned": jnp.stack([vector[1] * number, -vector[0]]) + common, "plain": number}

    rods = over_rods(single, lambda function: function, [(2,), (), (2,)], size)
    found = rods(*map(jnp.asarray, (vector, number, common)))
    turned = np.stack([vector[1] * number, -vector[0]]) + common
    # A product and a sum in one operation round once.
    np.testing.assert_allclose(found["turned"], turned, rtol=0.0, atol=4e-15)
    np.testing.assert_array_equal(found["plain"], number)
