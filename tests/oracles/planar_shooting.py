"""The RFRFR robot of the paper by plain shooting: angles, scipy's integrator and root finder.

The state of a rod is `(y, z, θ, n_y, n_z, m)` as in (14), the residual is (15) with the moment
taken at the pivot or, as printed, at the tip of the rod.
"""

import dataclasses
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root


@dataclasses.dataclass(frozen=True)
class PlanarRobot:
    """The numbers of an RFRFR robot, SI units; pairs hold one value a leg.

    **Attributes:**

    - `l`, `a`, `b`, `d`: rods, rigid segments along the tangents, distance of the motors.
    - `k_b`, `curvature`: bending stiffness and curvature at rest `1 / r_c`.
    - `f_P`: force on the platform.
    - `load`: distributed `(f_y, f_z, l_x)` on either rod.
    - `printed`: take the moment at the tip of the rod.
    """

    l: tuple[float, float] = (0.25, 0.25)  # noqa: E741
    a: tuple[float, float] = (0.045, 0.045)
    b: tuple[float, float] = (0.035, 0.035)
    d: float = 0.2
    k_b: tuple[float, float] = (0.0183, 0.0183)
    curvature: tuple[float, float] = (-1.0, 1.0)
    f_P: tuple[float, float] = (0.0, 1.0)
    load: tuple[float, float, float] = (0.0, 0.0, 0.0)
    printed: bool = False


class Tip(NamedTuple):
    """End of a leg: the pivot, the moment that must vanish, the force, the tangent's angle."""

    pivot: np.ndarray
    moment: float
    force: np.ndarray
    angle: float


def integrate(robot: PlanarRobot, leg: int, q: float, mu: np.ndarray, **options):
    """Solution of (14) along one rod from its motor angle and base wrench `(n_y, n_z, m)`."""
    f_y, f_z, l_x = robot.load

    def field(s, x):
        _, _, angle, n_y, n_z, m = x
        c, sine = np.cos(angle), np.sin(angle)
        bend = m / robot.k_b[leg] + robot.curvature[leg]
        return [c, sine, bend, -f_y, -f_z, n_y * sine - n_z * c - l_x]

    motor = (-0.5 if leg == 0 else 0.5) * robot.d
    start = [motor + robot.a[leg] * np.cos(q), robot.a[leg] * np.sin(q), q, *mu]
    return solve_ivp(
        field, (0.0, robot.l[leg]), start, method="DOP853", rtol=1e-12, atol=1e-14, **options
    )


def leg_tip(robot: PlanarRobot, leg: int, q: float, mu: np.ndarray) -> Tip:
    """Where a leg ends and what it transmits."""
    y, z, angle, n_y, n_z, m = integrate(robot, leg, q, mu).y[:, -1]
    b_y, b_z = robot.b[leg] * np.cos(angle), robot.b[leg] * np.sin(angle)
    lever = 0.0 if robot.printed else b_y * n_z - b_z * n_y
    return Tip(np.array([y + b_y, z + b_z]), m - lever, np.array([n_y, n_z]), angle)


def residual(robot: PlanarRobot, y: np.ndarray) -> np.ndarray:
    """The eight rows of (15) without the imposed ones, at `y = (q, p_P, μ_1, μ_2)`, SI units."""
    tips = [leg_tip(robot, i, y[i], y[4 + 3 * i : 7 + 3 * i]) for i in range(2)]
    return np.concatenate(
        [
            np.asarray(robot.f_P) - tips[0].force - tips[1].force,
            [tips[0].moment, tips[1].moment],
            y[2:4] - tips[0].pivot,
            y[2:4] - tips[1].pivot,
        ]
    )


def _solve(robot, guess, imposed, value):
    length = np.mean(robot.l)
    force = np.mean(robot.k_b) / length**2
    wrench = [force, force, force * length]
    units = np.array([1.0, 1.0, length, length, *wrench, *wrench])
    rows = np.array([force, force, force * length, force * length, *[length] * 4])

    def equations(x):
        y = x * units
        gap = (y[imposed] - value) / units[imposed]
        return np.concatenate([residual(robot, y) / rows, gap])

    found = root(equations, np.asarray(guess) / units, method="hybr", options={"xtol": 1e-13})
    if np.max(np.abs(equations(found.x))) > 1e-10:
        raise RuntimeError(f"The oracle found no equilibrium: {found.message}")
    return found.x * units


def inverse(robot: PlanarRobot, point, guess: np.ndarray) -> np.ndarray:
    """`y` with the platform at a point, from a guess of `y`."""
    return _solve(robot, guess, slice(2, 4), np.asarray(point, float))


def forward(robot: PlanarRobot, q, guess: np.ndarray) -> np.ndarray:
    """`y` with the motors at the angles `q`, from a guess of `y`."""
    return _solve(robot, guess, slice(0, 2), np.asarray(q, float))


def energy(robot: PlanarRobot, y: np.ndarray) -> float:
    """Elastic energy of the rods less the work of the force on the platform (Gauss–Legendre)."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total = -np.dot(robot.f_P, y[2:4])
    for leg in range(2):
        s = 0.5 * robot.l[leg] * (nodes + 1.0)
        moments = integrate(robot, leg, y[leg], y[4 + 3 * leg : 7 + 3 * leg], t_eval=s).y[5]
        total += 0.25 * robot.l[leg] * weights @ moments**2 / robot.k_b[leg]
    return total
