"""Schemes of integration: their order, their work, what is refused."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax import InputError, Scheme
from cpr_jax.geometry import PLANE
from cpr_jax.rods.integration import rod_tip
from cpr_jax.rods.rod import kirchhoff_rod
from cpr_jax.rods.solver import ExtrapolatedMidpoint, as_scheme, checked_scheme
from tests.oracles import elastica

LOAD = 3.0
EXACT = elastica.cantilever(LOAD)
EXACT_TIP = np.array([EXACT.along, EXACT.across])


@jax.jit
def cantilever_tip(scheme):
    """Tip of the elastica under `P L² / EI = 3` with the clamp's moment of the closed form."""
    rod = kirchhoff_rod(PLANE, 1.0, 1.0)
    return rod_tip(PLANE, rod, jnp.array([0.0, LOAD]), jnp.array([EXACT.moment]), scheme).position


LOADS = jnp.linspace(0.5, LOAD, 24)


def tip_under(load, scheme):
    rod = kirchhoff_rod(PLANE, 1.0, 1.0)
    return rod_tip(PLANE, rod, jnp.array([0.0, 1.0]) * load, jnp.array([1.0]) * load, scheme)[0]


def evaluations(scheme, compact):
    """Of the right-hand side, in one step."""
    counted = 0

    class Terms:
        def vf(self, t, y, args):
            nonlocal counted
            counted += 1
            return [-y[0]]

    with jax.disable_jit():
        ExtrapolatedMidpoint(scheme.order, scheme.least, compact).step(
            Terms(), 0.0, 1.0, [jnp.ones(())], None, None, False
        )
    return counted


@pytest.mark.parametrize(
    "order, least, counts",
    [
        (4, 6, (4, 6)),
        (6, 8, (4, 6)),
        (8, 4, (3, 5)),
        (8, 10, (2, 3)),
        (10, 8, (2, 3)),
        (12, 4, (2, 3)),
    ],
)
def test_the_tip_converges_with_the_order_of_its_scheme(order, least, counts):
    # One program serves all schemes.
    errors = [
        np.max(np.abs(cantilever_tip(as_scheme(Scheme(n, order, least))) - EXACT_TIP))
        for n in counts
    ]
    rate = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert errors[-1] > 1e-13, "rounding would hide the order"
    assert rate == pytest.approx(order, abs=1.0)


@pytest.mark.parametrize("order, least", [(2, 4), (8, 4), (10, 4), (12, 8), (16, 6)])
def test_weights_cancel_even_powers(order, least):
    """The moments `Σ w_k n_k^(-2j)` are one for j = 0 and zero up to half the order."""
    rules = order // 2
    weights = ExtrapolatedMidpoint(order, least).weights[:rules]
    squares = 1.0 / (least + 2.0 * np.arange(rules)) ** 2
    moments = [np.sum(weights * squares**j) for j in range(rules)]
    np.testing.assert_allclose(moments, [1.0] + [0.0] * (rules - 1), atol=1e-11)


@pytest.mark.parametrize("order, least", [(8, 6), (10, 4)])
def test_few_rods_and_many_have_the_same_tips(order, least):
    """Compact programs and fast ones differ in rounding, which the weights multiply."""
    scheme = Scheme(8, order, least)
    few, many = (
        jax.jit(jax.vmap(lambda load: tip_under(load, scheme)))(LOADS[:count])
        for count in (4, len(LOADS))
    )
    weights = ExtrapolatedMidpoint(order, least).weights[: order // 2]
    rounding = scheme.steps * np.sum(np.abs(weights)) * np.finfo(float).eps
    np.testing.assert_allclose(few, many[:4], rtol=0, atol=rounding)


def test_work_counts_the_evaluations():
    """But for one less of a compact step, which does not go beyond its end."""
    scheme = Scheme(1, 8, 6)
    assert evaluations(scheme, compact=False) == scheme.work == 1 + 6 + 8 + 10 + 12
    assert evaluations(scheme, compact=True) == scheme.work - 1


def test_a_number_of_steps_is_of_order_ten():
    np.testing.assert_array_equal(as_scheme(7), Scheme(7, 10, 4))
    np.testing.assert_array_equal(as_scheme(np.array([2, 8, 6])), Scheme(2, 8, 6))
    assert checked_scheme("steps", 7) == Scheme(7, 10, 4)


@pytest.mark.parametrize(
    "steps, field",
    [
        (0, "steps"),
        (2.0, "steps"),
        (Scheme(0), "steps.steps"),
        (Scheme(1, 7), "steps.order"),
        (Scheme(1, 18), "steps.order"),
        (Scheme(1, 8, 3), "steps.least"),
    ],
)
def test_what_is_no_scheme_is_refused(steps, field):
    with pytest.raises(InputError, match=f"`{field}`"):
        checked_scheme("steps", steps)
