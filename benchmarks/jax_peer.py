"""The paper's robot as one would compose it from diffrax and optimistix, with a plain `vmap`."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx

from . import scipy_peer


def make(nominal: np.ndarray, slope: np.ndarray, tolerance: float):
    """Returns `solve(rho)` for `p_P`, m: adaptive Dopri8, Newton's method, all samples at once."""
    peer = scipy_peer
    units, rows = jnp.asarray(peer._UNITS[2:]), jnp.asarray(peer._ROWS)
    q, start, tangent = (jnp.asarray(part) for part in (nominal[:2], nominal[2:], slope[2:]))

    def leg(q, motor, mu, k_b, r_c):
        def field(s, x, args):
            c, sine = jnp.cos(x[2]), jnp.sin(x[2])
            return jnp.stack([c, sine, x[3] / k_b + 1.0 / r_c, mu[0] * sine - mu[1] * c])

        base = [motor + peer.BEFORE * jnp.cos(q), peer.BEFORE * jnp.sin(q), q, mu[2]]
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(field),
            diffrax.Dopri8(),
            0.0,
            peer.LENGTH,
            peer.LENGTH / 8.0,
            jnp.stack(base),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=0.01 * tolerance),
            adjoint=diffrax.ForwardMode(),
        )
        y, z, angle, m = solution.ys[-1]
        b_y, b_z = peer.AFTER * jnp.cos(angle), peer.AFTER * jnp.sin(angle)
        return jnp.stack([y + b_y, z + b_z]), m - (b_y * mu[1] - b_z * mu[0])

    def residual(scaled, rho):
        y = scaled * units
        end, first, second = y[:2], y[2:5], y[5:]
        pivot_1, moment_1 = leg(q[0], -0.5 * peer.DISTANCE, first, rho[0], rho[1])
        pivot_2, moment_2 = leg(q[1], 0.5 * peer.DISTANCE, second, rho[2], rho[3])
        balance = jnp.asarray(peer.F_P) - first[:2] - second[:2]
        moments = jnp.stack([moment_1, moment_2])
        return jnp.concatenate([balance, moments, end - pivot_1, end - pivot_2]) / rows

    def one(rho):
        guess = (start + tangent @ (rho - jnp.asarray(peer.RHO))) / units
        newton = optx.Newton(rtol=tolerance, atol=tolerance)
        return (optx.root_find(residual, newton, guess, args=rho).value * units)[:2]

    batched = jax.jit(jax.vmap(one))
    return lambda rho: np.asarray(batched(jnp.asarray(rho)))
