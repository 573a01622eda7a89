"""Closed-form elastica: a straight cantilever under a dead transverse load at its tip.

With `a² = P L² / EI`, the modulus `k² = (1 + sin θ) / 2` of the tip angle θ and
`sin φ = 1 / (k √2)`, the length condition is `a = K(k) - F(φ, k)`, and the tip follows from the
elliptic integrals of the second kind.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc


class Cantilever(NamedTuple):
    """Tip of the cantilever in units of its length, and the moment at its clamp in units of EI/L.

    **Attributes:**

    - `along`: position of the tip along the undeformed axis.
    - `across`: deflection in the direction of the load.
    - `angle`: slope of the tip, rad.
    - `moment`: at the clamp.
    """

    along: float
    across: float
    angle: float
    moment: float


def cantilever(load: float) -> Cantilever:
    """The cantilever under the load `P L² / EI`, 0.01 to 1,000."""
    root = np.sqrt(load)

    def length_error(angle):
        m, phi = _modulus(angle)
        return ellipk(m) - ellipkinc(phi, m) - root

    angle = brentq(length_error, 1e-6, np.pi / 2.0 - 1e-13, xtol=1e-15, rtol=1e-15)
    m, phi = _modulus(angle)
    along = np.sqrt(2.0 * np.sin(angle)) / root
    across = 1.0 - 2.0 / root * (ellipe(m) - ellipeinc(phi, m))
    return Cantilever(along, across, angle, load * along)


def _modulus(angle):
    m = 0.5 * (1.0 + np.sin(angle))
    return m, np.arcsin(np.sqrt(0.5 / m))
