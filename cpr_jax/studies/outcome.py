"""What comes out of a Monte Carlo study."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from ..analysis.ellipsoid import Ellipsoid
from ..analysis.sensitivity import Sensitivity
from ..rods.solver import Scheme
from ..summary import in_notebook, summary


class MonteCarlo(NamedTuple):
    """Outcome of a Monte Carlo study with the motors held.

    **Attributes** (SI units; `kept` samples of all `samples`, the first ones):

    - `rho`: parameters, shape `(kept, n_ρ)`.
    - `q_p`: platform coordinates, NaN where not solved, shape `(kept, n_p)`.
    - `status`: `Status` codes, shape `(kept,)`.
    - `inside`: whether the platform is inside the ellipsoid, of a flat one by the directions in
        which it extends, see `Ellipsoid.covers`, shape `(kept,)`.
    - `samples`, `solved`, `lost`, `failed`: how many in all; solved; without an equilibrium on
        the branch (beyond a Type 2 singularity); without an answer, or with a rod that is drawn in
        to nothing. Their sum is `samples`.
    - `coverage`: share of all samples inside the ellipsoid; lost samples are not inside.
    - `coverage_interval`: its exact 95 % confidence interval (Clopper–Pearson).
    - `mean`, `covariance`: of the solved positions; NaN where there are too few.
    - `followed`: samples whose branch was followed step by step to be sure of it.
    - `scheme`, `error`: the integration steps along each rod and their order, and the estimated
        error of its tip that they leave where the parameters are at the ends of their ranges, in
        rod lengths.
    - `sensitivity`, `ellipsoid`: the linear theory they are compared with.
    """

    rho: Float[np.ndarray, "kept n_rho"]
    q_p: Float[np.ndarray, "kept n_p"]
    status: np.ndarray
    inside: np.ndarray
    samples: int
    solved: int
    lost: int
    failed: int
    coverage: float
    coverage_interval: tuple[float, float]
    mean: Float[np.ndarray, " d"]
    covariance: Float[np.ndarray, "d d"]
    followed: int
    scheme: Scheme
    error: float
    sensitivity: Sensitivity
    ellipsoid: Ellipsoid

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        in_notebook(self, printer, cycle)

    def __str__(self) -> str:
        return summary(
            self,
            f"Monte Carlo study of {self.samples} samples: {self.solved} solved, {self.lost} lost, "
            f"{self.failed} failed",
            coverage=self.coverage,
            coverage_interval=self.coverage_interval,
            mean=self.mean,
            deviation=np.sqrt(np.diag(self.covariance)),
            semi_axes=self.ellipsoid.semi_axes,
            followed=self.followed,
            error=self.error,
        )


def clopper_pearson(hits: int, trials: int) -> tuple[float, float]:
    """Exact 95 % confidence interval of a probability (Clopper and Pearson, 1934)."""
    # Imported late, as in `linear_coverage`.
    from scipy.special import betaincinv

    misses = trials - hits
    low = betaincinv(hits, misses + 1, 0.025) if hits else 0.0
    high = betaincinv(hits + 1, misses, 0.975) if misses else 1.0
    return float(low), float(high)
