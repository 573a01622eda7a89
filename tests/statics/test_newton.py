"""The root finder and its derivative on small problems with known roots."""

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest

from cpr_jax.statics.newton import LaneAdjoint, LaneNewton

SOLVED = optx.RESULTS.successful


def find(function, start, args, max_steps=30, **options):
    """One root find as the package does it."""
    return optx.root_find(
        lambda y, args: (function(y, args), None),
        LaneNewton(**options),
        start,
        args=args,
        has_aux=True,
        max_steps=max_steps,
        adjoint=LaneAdjoint(),
        throw=False,
    )


def circle_and_line(y, radius):
    """Meets at `radius / sqrt 2` in both coordinates."""
    return jnp.stack([y[0] ** 2 + y[1] ** 2 - radius**2, y[0] - y[1]])


def test_a_root_is_exact_to_rounding():
    found = jax.jit(lambda r: find(circle_and_line, jnp.array([3.0, 0.5]), r))(2.0)
    assert bool(found.result == SOLVED)
    np.testing.assert_allclose(found.value, np.sqrt(2.0), rtol=1e-15)


def test_damping_reaches_what_plain_newton_overshoots():
    """From 3, Newton's method on the arcus tangens diverges."""
    found = jax.jit(lambda y: find(lambda y, _: jnp.arctan(y), y, None, max_step=10.0))(
        jnp.array([3.0])
    )
    assert bool(found.result == SOLVED)
    np.testing.assert_allclose(found.value, 0.0, rtol=0, atol=1e-15)


def test_no_root_is_no_success():
    found = jax.jit(lambda y: find(lambda y, _: y**2 + 1.0, y, None))(jnp.array([0.7]))
    assert not bool(found.result == SOLVED)


def test_a_singular_jacobian_is_no_success():
    def degenerate(y, _):
        return jnp.stack([y[0] + y[1] - 1.0, 2.0 * y[0] + 2.0 * y[1] - 3.0])

    found = jax.jit(lambda y: find(degenerate, y, None))(jnp.zeros(2))
    assert not bool(found.result == SOLVED)


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_derivatives_of_a_root_to_third_order(mode):
    """The root of `y³ = a` has the derivatives of `a^(1/3)`."""

    def root(a):
        return find(lambda y, a: y**3 - a, jnp.array([1.3]), a).value[0]

    a = 2.0
    orders = jax.jit(lambda a: (mode(root)(a), mode(mode(root))(a), mode(mode(mode(root)))(a)))(a)
    exact = [a ** (-2 / 3) / 3, -2 / 9 * a ** (-5 / 3), 10 / 27 * a ** (-8 / 3)]
    np.testing.assert_allclose(orders, exact, rtol=1e-12)


def test_derivatives_in_several_arguments():
    """Only some of the arguments may be perturbed, and pytrees may hold them."""

    def root(args):
        def equation(y, args):
            return args["scale"] * y**2 - args["value"]

        return find(equation, jnp.array([1.0]), args).value[0]

    args = {"scale": jnp.asarray(0.5), "value": jnp.asarray(3.0)}
    gradient = jax.jit(jax.grad(root))(args)
    y = np.sqrt(6.0)
    np.testing.assert_allclose(gradient["value"], 1.0 / y, rtol=1e-12)
    np.testing.assert_allclose(gradient["scale"], -y, rtol=1e-12)
    only = jax.jit(jax.grad(lambda value: root({**args, "value": value})))(args["value"])
    np.testing.assert_allclose(only, 1.0 / y, rtol=1e-12)


def test_the_start_has_no_derivative():
    def root(start):
        return find(lambda y, a: y**3 - a, start, 2.0).value[0]

    np.testing.assert_array_equal(jax.jit(jax.grad(root))(jnp.array([1.3])), 0.0)


def test_lanes_fail_on_their_own():
    """Lanes without a root and lanes of NaN; the others have their roots and derivatives."""

    @jax.jit
    @jax.vmap
    def solve(a):
        def value(a):
            found = find(lambda y, a: y**2 - a, jnp.array([1.0]), a)
            return found.value[0], found.result == SOLVED

        return value(a), jax.grad(value, has_aux=True)(a)[0]

    a = jnp.array([4.0, -1.0, jnp.nan, 9.0, jnp.inf])
    (values, solved), slopes = solve(a)
    np.testing.assert_array_equal(solved, [True, False, False, True, False])
    np.testing.assert_allclose(values[np.array([0, 3])], [2.0, 3.0], rtol=1e-15)
    np.testing.assert_allclose(slopes[np.array([0, 3])], [0.25, 1.0 / 6.0], rtol=1e-14)
    np.testing.assert_array_equal(slopes[np.array([1, 2, 4])], 0.0)
