"""The root find: a damped Newton method for lanes, and its implicit derivative."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Bool, Float

from .linear import inverse, solve_with_sign


class _NewtonState(eqx.Module):
    base: Float[Array, " n"]
    direction: Float[Array, " n"]
    damping: Float[Array, ""]
    norm: Float[Array, ""]
    sign: Float[Array, ""]
    converged: Bool[Array, ""]
    stuck: Bool[Array, ""]
    seen: Bool[Array, ""]
    jacobian: Float[Array, "n n"] | None


class LaneNewton(optx.AbstractRootFinder):
    """Newton's method on a dimensionless system, damped until the residual falls.

    Each iteration evaluates the residual and its Jacobian once. A step that does not reduce the
    largest entry of the residual is halved; one that is longer than `max_step` is cut. Once the
    residual is below `atol`, the Newton step at hand is added, which squares the error.

    Written for batches: no lane raises, and every lane keeps its own damping.

    **Attributes:**

    - `atol`: on the largest entry of the residual; `rtol` is not used, a root has no scale.
    - `max_step`: largest change of an unknown in one iteration.
    - `look`: evaluate once more at the root, and keep the Jacobian there. What follows a solve
        and needs it is spared a second copy of it in the compiled program.
    - `linearise`: values and Jacobian of a function at `(y, args)`, where there is a faster way to
        them than `jax.jacfwd`.
    """

    rtol: float = 0.0
    atol: float = 1e-9
    max_step: float = 1.0
    look: bool = False
    linearise: Callable[..., Any] | None = eqx.field(default=None, static=True)
    norm: Any = optx.max_norm

    def init(self, fn, y, args, options, f_struct, aux_struct, tags):
        one = jnp.ones((), y.dtype)
        return _NewtonState(
            base=y,
            direction=jnp.zeros_like(y),
            damping=one,
            norm=one * jnp.inf,
            sign=one,
            converged=jnp.array(False),
            stuck=jnp.array(False),
            seen=jnp.array(not self.look),
            jacobian=jnp.zeros((y.size, y.size), y.dtype) if self.look else None,
        )

    def step(self, fn, y, args, options, state, tags):
        f, jacobian, aux = self._linearised(fn, y, args)
        norm = self.norm(f)
        before = state
        better = norm < (1.0 - 1e-4 * state.damping) * state.norm
        direction, sign = solve_with_sign(jacobian, -f)

        base = jnp.where(better, y, state.base)
        direction = jnp.where(better, direction, state.direction)
        converged = better & (norm < self.atol)
        cut = jnp.minimum(1.0, self.max_step / self.norm(direction))
        damping = jnp.where(better, jnp.minimum(1.0, 4.0 * state.damping), 0.5 * state.damping)
        factor = jnp.where(converged, 1.0, jnp.minimum(damping, cut))
        state = _NewtonState(
            base=base,
            direction=direction,
            damping=damping,
            norm=jnp.where(better, norm, state.norm),
            sign=jnp.where(better, sign, state.sign),
            converged=converged,
            stuck=(damping < 1e-4) | ~jnp.all(jnp.isfinite(direction)),
            seen=before.seen,
            jacobian=None if before.jacobian is None else jacobian,
        )
        new = base + factor * direction
        if self.look:
            # A lane that has converged stays where it is.
            new = jnp.where(before.converged, y, new)
            kept = eqx.tree_at(
                lambda s: (s.norm, s.seen, s.jacobian),
                before,
                (norm, jnp.array(True), jacobian),
            )
            state = jax.tree.map(lambda a, b: jnp.where(before.converged, a, b), kept, state)
        return new, state, aux

    def _linearised(self, fn, y, args):
        if self.linearise is not None:
            return *self.linearise(y, args), None

        def evaluate(y):
            f, aux = fn(y, args)
            return f, (f, aux)

        jacobian, (f, aux) = jax.jacfwd(evaluate, has_aux=True)(y)
        return f, jacobian, aux

    def terminate(self, fn, y, args, options, state, tags):
        result = optx.RESULTS.where(
            state.stuck & ~state.converged,
            optx.RESULTS.nonlinear_divergence,
            optx.RESULTS.successful,
        )
        return state.converged & state.seen, result

    def postprocess(self, fn, y, aux, args, options, state, tags, result):
        return y, aux, {"sign": state.sign, "norm": state.norm, "jacobian": state.jacobian}


class LaneAdjoint(optx.AbstractAdjoint):
    """The implicit function theorem, lane by lane: `∂y/∂ρ = -(∂R/∂y)⁻¹ ∂R/∂ρ` (10).

    Beside `optimistix.ImplicitAdjoint`, it differentiates to any order in both modes, and it
    isolates lanes: where the solve failed, a lane's derivatives are zero and nothing raises.
    """

    def apply(self, primal_fn, rewrite_fn, inputs, tags):
        while_loop = eqx.internal.while_loop
        # Whatever may be traced is an argument: the rule outlives the trace around it.
        moving, fixed = eqx.partition(inputs, eqx.is_array)

        def lax_loop(cond, body, init, *, max_steps):
            return while_loop(cond, body, init, max_steps=max_steps, kind="lax")

        def primal(moving):
            frozen = jax.lax.stop_gradient(moving)
            return primal_fn((*eqx.combine(frozen, fixed), lax_loop))

        @eqx.filter_custom_jvp
        def solve(moving):
            return primal(moving)

        def rule(primals, tangents):
            (moving,), (tangent,) = primals, tangents
            out = solve(moving)
            root, rest = out
            succeeded = (rest[1] == optx.RESULTS.successful) & jnp.all(jnp.isfinite(root))

            def safe(leaf, value):
                return jnp.where(succeeded, leaf, value) if eqx.is_inexact_array(leaf) else leaf

            # In a failed lane any regular system will do; its derivative is masked below.
            moving = jax.tree.map(lambda leaf: safe(leaf, 1.0), moving)
            root = safe(root, 0.0)

            def equation(root, moving):
                return rewrite_fn(root, None, eqx.combine(moving, fixed))

            matrix = jax.jacfwd(equation)(root, moving)
            matrix = jnp.where(succeeded, matrix, jnp.eye(root.size))
            # Zero times NaN is NaN: nothing comes back to what other lanes share, too.
            tangent = jax.tree.map(lambda t: jnp.where(succeeded, t, 0.0), tangent)
            # Only what is perturbed costs a tangent of the integration.
            perturbed = jax.tree.map(
                lambda leaf, t: None if t is None else leaf, moving, tangent, is_leaf=_is_none
            )
            still = jax.tree.map(
                lambda leaf, t: leaf if t is None else None, moving, tangent, is_leaf=_is_none
            )
            _, shift = jax.jvp(
                lambda perturbed: equation(root, eqx.combine(perturbed, still)),
                (perturbed,),
                (tangent,),
            )
            slope = jnp.where(succeeded, -inverse(matrix) @ shift, 0.0)
            zeros = jax.tree.map(
                lambda leaf: jnp.zeros_like(leaf) if eqx.is_inexact_array(leaf) else None, rest
            )
            return out, (slope, zeros)

        solve.def_jvp(rule)
        return solve(moving)


def _is_none(leaf):
    return leaf is None
