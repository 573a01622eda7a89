"""What the paper says about its equations and its Figure 2, beside what was computed."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from ..analysis.ellipsoid import LINEAR_COVERAGE
from ..analysis.sensitivity import Sensitivity, sensitivity
from ..analysis.slopes import Hold
from ..robots.catalogue import rfrfr
from ..robots.robot import Robot
from ..rods.section import rectangle
from ..statics.equilibrium import Equilibrium
from ..statics.solve import solve_inverse
from .outcome import MonteCarlo
from .paper_map import as_claim

POINTS = {
    "A": (0.0, 0.25),
    "B": (0.06, 0.18),
    "C": (0.11, 0.10),
    "D": (0.05, 0.045),
}
"""End-effector positions in m. The paper shows its points in Figure 2 without coordinates; D is
in the zone of high sensitivity beside the T2 line."""


class CaseStudy(NamedTuple):
    """What the figures and the report are made of.

    **Attributes:**

    - `robot`: the robot of Table 1.
    - `equilibria`, `studies`: by the name of the point.
    - `linear`: Monte Carlo at A with δ/100, where the linear theory holds.
    - `workspace`: the map of half the workspace.
    - `claims`: see `sample_claims` and `map_claims`.
    """

    robot: Robot
    equilibria: dict[str, Equilibrium]
    studies: dict[str, MonteCarlo]
    linear: MonteCarlo
    workspace: xr.Dataset
    claims: list[dict]


def sample_claims(study: CaseStudy) -> list[dict]:
    """What the paper says about its equations and Figure 2, beside what was computed.

    Entries: `claim`, `computed` (a sentence), `agrees`, `numbers`.
    """
    return [
        _coverage(study),
        _exception(study),
        _linear_theory(study),
        _long_axis(study),
        _pinned(study),
        _moment_row(study),
        _unit(study),
    ]


def _coverage(study: CaseStudy) -> dict:
    usual = {name: study.studies[name] for name in "ABC"}
    words = ", ".join(
        f"{name} {s.coverage:.2%} ({s.coverage_interval[0]:.2%} to {s.coverage_interval[1]:.2%})"
        for name, s in usual.items()
    )
    unsolved = sum(s.lost + s.failed for s in usual.values())
    return as_claim(
        "More than 97 % of the perturbed positions lie within the ellipse at A, B and C.",
        f"{words}; {unsolved} samples without an equilibrium.",
        all(s.coverage > 0.97 for s in usual.values()),
        coverage={name: s.coverage for name, s in usual.items()},
        interval={name: s.coverage_interval for name, s in usual.items()},
    )


def _exception(study: CaseStudy) -> dict:
    at_d = study.studies["D"]
    others = [float(np.asarray(study.studies[name].ellipsoid.semi_axes)[0]) for name in "ABC"]
    axis = float(np.asarray(at_d.ellipsoid.semi_axes)[0])
    return as_claim(
        "Point D is the exception; it lies in a zone of high sensitivity.",
        f"{at_d.coverage:.2%} inside, {at_d.lost} of {at_d.samples} samples have no equilibrium "
        f"left on the branch; its longer semi-axis is {1e3 * axis:.1f} mm, those of A to C are "
        f"at most {1e3 * max(others):.1f} mm.",
        at_d.coverage < 0.97 and axis > max(others),
        coverage=at_d.coverage,
        interval=at_d.coverage_interval,
        lost=at_d.lost,
        semi_axis=axis,
    )


def _linear_theory(study: CaseStudy) -> dict:
    low, high = study.linear.coverage_interval
    return as_claim(
        "The ellipse encloses the cloud where the first-order approximation holds "
        f"(exact value for Gaussians with σ = δ/3: 1 - exp(-9/2) = {LINEAR_COVERAGE:.3%}).",
        f"With δ/100 at A, {study.linear.coverage:.3%} of {study.linear.samples} samples "
        f"({low:.3%} to {high:.3%}).",
        low <= LINEAR_COVERAGE <= high,
        coverage=study.linear.coverage,
        interval=study.linear.coverage_interval,
    )


def stiffness_share(result: Sensitivity, direction: np.ndarray) -> float:
    """Share of the variance along a direction of p_P that stems from bending stiffnesses."""
    along = (direction @ np.asarray(result.Pi_p)) * np.asarray(result.delta)
    stiff = np.array([label.startswith("k_b") for label in result.columns])
    return float(np.sum(along[stiff] ** 2) / np.sum(along**2))


def _long_axis(study: CaseStudy) -> dict:
    shares = {
        name: stiffness_share(s.sensitivity, np.asarray(s.ellipsoid.directions)[0])
        for name, s in study.studies.items()
    }
    words = ", ".join(f"{name} {share:.2%}" for name, share in shares.items())
    return as_claim(
        "The long axis is always the one associated with the bending stiffness.",
        f"Share of k_b in the variance along the long axis: {words}.",
        min(shares.values()) > 0.5,
        share=shares,
    )


def _pinned(study: CaseStudy) -> dict:
    held = sensitivity(study.robot, study.equilibria["A"], hold=Hold.PLATFORM)
    largest = float(np.max(np.abs(held.Pi_p)))
    return as_claim(
        "(15) and (10) as printed give the sensitivity of the end-effector.",
        "The last row of (15) pins the platform: differentiated as printed, ∂p_P/∂ρ is "
        f"{largest:.1e}. The ellipses here hold the motors instead; the factors of (10) are in "
        "the order -(∂R/∂y)⁻¹ ∂R/∂ρ.",
        largest > 0.0,
        largest=largest,
    )


def asymmetry(stiffness) -> float:
    """Largest difference between a matrix and its transpose, relative to its largest entry."""
    matrix = np.asarray(stiffness)
    return float(np.max(np.abs(matrix - matrix.T)) / np.max(np.abs(matrix)))


def _moment_row(study: CaseStudy) -> dict:
    printed = rfrfr(printed_moment_row=True)
    pivot_row, printed_row, shift, axes = {}, {}, {}, {}
    for name, equilibrium in study.equilibria.items():
        other = solve_inverse(printed, POINTS[name], throw=False)
        result = sensitivity(printed, other)
        pivot_row[name] = asymmetry(study.studies[name].sensitivity.platform_stiffness)
        printed_row[name] = asymmetry(result.platform_stiffness)
        shift[name] = float(np.rad2deg(np.max(np.abs(np.subtract(other.q_a, equilibrium.q_a)))))
        scaled = np.multiply(result.Pi_p, result.delta)
        axes[name] = float(
            np.linalg.svd(scaled, compute_uv=False)[0]
            / np.asarray(study.studies[name].ellipsoid.semi_axes)[0]
        )
    words = ", ".join(
        f"{name} {printed_row[name]:.1%} ({shift[name]:.1f}° in the motors, long axis × "
        f"{axes[name]:.2f})"
        for name in POINTS
    )
    return as_claim(
        "(15) prints m_x(l_i) = 0 at the rods' tips.",
        "The pivot sits at the far end of b. With its moment zero the platform stiffness is "
        f"symmetric to {max(pivot_row.values()):.0e}; with the printed row it is off by {words}.",
        max(printed_row.values()) < 1e-6,
        pivot_row=pivot_row,
        printed_row=printed_row,
        motor_shift_deg=shift,
        axis_ratio=axes,
    )


def _unit(study: CaseStudy) -> dict:
    second = rectangle(width=0.002, height=0.010).I_3
    k_b = 1.0 / np.ravel(study.robot.legs.rod.curvature_compliance)[0]
    return as_claim(
        "Table 1 prints k_b = 1.83e-2 N·mm².",
        f"For the 10 × 2 mm section that means E = {k_b * 1e-6 / second / 1e3:.1f} kPa; in N·m² "
        f"it means E = {k_b / second / 1e9:.2f} GPa, a common polymer, which is used here.",
        False,
        E_printed=k_b * 1e-6 / second,
        E_used=k_b / second,
    )
