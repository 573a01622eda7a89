"""Uncertainty ellipsoids (11)–(13), (17)."""

from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..errors import InputError
from ..geometry import floats, namespace
from ..programs import brief_program
from ..statics.linear import row_axes
from ..summary import in_notebook, summary
from .sensitivity import Sensitivity

LINEAR_COVERAGE = 0.9888910034617577
"""`1 - exp(-9/2)`: share of a planar Gaussian, σ = δ/3, inside its ellipse in linear theory."""


def linear_coverage(dimensions: int) -> float:
    """Share of Gaussian samples, σ = δ/3, inside an ellipsoid in linear theory (chi-square)."""
    # To import it takes a tenth of the time in which a fresh process has solved a robot.
    from scipy.special import gammainc

    return float(gammainc(dimensions / 2.0, 4.5))


class Ellipsoid(eqx.Module):
    """The set `(x - c)ᵀ K⁻¹ (x - c) ≤ 1`.

    **Attributes:**

    - `center`: shape `(k,)`.
    - `kernel`: `K`, shape `(k, k)`.
    - `semi_axes`: lengths, largest first, shape `(k,)`.
    - `directions`: unit vectors of the semi-axes, a row each, shape `(k, k)`.
    - `labels`: of the coordinates.
    """

    center: Float[Array, " k"]
    kernel: Float[Array, "k k"]
    semi_axes: Float[Array, " k"]
    directions: Float[Array, "k k"]
    labels: tuple[str, ...] = eqx.field(static=True)

    _repr_pretty_ = in_notebook

    def __str__(self) -> str:
        return summary(
            self,
            f"Ellipsoid of {', '.join(self.labels)}",
            center=self.center,
            semi_axes=self.semi_axes,
            directions=self.directions,
        )

    def level(self, points: Float[Array, "*n k"]) -> Float[Array, "*n"]:
        """`(x - c)ᵀ K⁻¹ (x - c)` of each point; at most 1 inside. Infinite off a flat one."""
        along, flat = (points - self.center) @ self.directions.T, self._flat
        off = jnp.abs(along) > 1e-9 * self.semi_axes[0]
        beside = jnp.any(flat & off, axis=-1)
        return jnp.where(beside, jnp.inf, self._level_along(along))

    def contains(self, points: Float[Array, "*n k"]) -> Bool[Array, "*n"]:
        """Whether each point is inside. NaN is not."""
        return self.level(points) <= 1.0

    def covers(self, points: Float[Array, "*n k"]) -> Bool[Array, "*n"]:
        """As `contains`, but of a flat one only along the directions in which it extends.

        Fewer parameters than coordinates make it flat. What they move then lies on a curve or a
        surface that leaves it at once, whereas the linear theory speaks of these directions alone.
        """
        return self._level_along((points - self.center) @ self.directions.T) <= 1.0

    @property
    def _flat(self) -> Bool[Array, " k"]:
        return self.semi_axes <= 1e-12 * self.semi_axes[0]

    def _level_along(self, along: Float[Array, "*n k"]) -> Float[Array, "*n"]:
        """The level by the directions in which it extends; NaN where a coordinate is."""
        ratios = along / jnp.where(self._flat, 1.0, self.semi_axes)
        return jnp.sum(jnp.where(self._flat, 0.0 * along, ratios) ** 2, axis=-1)

    def boundary(self, count: int = 200) -> Float[Array, "count k"]:
        """Points on the boundary of a planar ellipse, closed.

        **Raises:** `InputError` for an ellipsoid of another number of rows.
        """
        if len(self.labels) != 2:
            raise InputError(
                f"Argument `rows` must name two states for an ellipse to have a boundary, but this "
                f"one has {len(self.labels)}: {', '.join(self.labels)}."
            )
        xp = namespace(self.center, self.semi_axes, self.directions)
        center, semi_axes, directions = map(
            xp.asarray, (self.center, self.semi_axes, self.directions)
        )
        angle = np.linspace(0.0, 2.0 * np.pi, count)
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return floats(center + (circle * semi_axes) @ directions)


def ellipsoid(sensitivity: Sensitivity, rows: str | Sequence[str] = "p_P") -> Ellipsoid:
    """The uncertainty ellipsoid of a reduced state (17), by default of the position `p_P`.

    **Arguments:**

    - `rows`: labels of the states, see `Sensitivity.rows`; `"p_P"` stands for all its axes, and
        `"turn_P"` for the orientation of a body, as small rotations about the world axes, rad.
    """
    if isinstance(rows, str) and rows == "turn_P":
        turns = sensitivity.Pi_turn
        if len(turns) == 0:
            raise InputError(
                "Argument `rows` must not be 'turn_P' for a platform without an orientation."
            )
        names = tuple(f"turn_P_{axis}" for axis in ("x", "y", "z")[: len(turns)])
        return _ellipsoid(
            floats(np.zeros(len(turns))),
            turns,
            sensitivity.delta,
            tuple(range(len(turns))),
            names,
        )
    indices = tuple(sensitivity.indices(rows))
    if not indices:
        raise InputError("Argument `rows` must name at least one state, but it is empty.")
    labels = tuple(sensitivity.rows[i] for i in indices)
    return _ellipsoid(sensitivity.y, sensitivity.Pi_y, sensitivity.delta, indices, labels)


@brief_program
def _ellipsoid(y, Pi_y, delta, indices, labels) -> Ellipsoid:
    scaled = Pi_y[jnp.array(indices)] * delta
    # The singular values of Π δρ are the semi-axes; those of K would lose half the digits.
    semi_axes, directions = row_axes(scaled)
    return Ellipsoid(y[jnp.array(indices)], scaled @ scaled.T, semi_axes, directions, labels)
