"""The length-fed six-leg robot by scipy, after Till's MATLAB program.

J. Till, *ContinuumRobotExamples*, 01_Statics/02_CSG_Inverse_Kinematics, in its own variables: the
third axis of a cross-section is its tangent. Its program compares the orientations of a rod's tip
and of the platform by the skew part of `RᵀR_E - R R_Eᵀ`, of which the second term is not the
transpose of the first one. For a tilted platform and a rod with a twist this is no joint: the work
of its moments vanishes along none of its motions. `printed` solves that; otherwise `R_EᵀR` takes
the place of the second term, and the tip is clamped but for a free twist.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

E, G, RADIUS, DENSITY = 200e9, 80e9, 0.001, 8000.0
AREA, SECOND = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4.0
STRETCH = np.array([G * AREA, G * AREA, E * AREA])
BEND = np.array([E * SECOND, E * SECOND, 2.0 * G * SECOND])
GRAVITY = np.array([0.0, 0.0, -9.81])
MASS = 0.1


def _circle(angles, radius=0.087):
    turn = np.deg2rad(angles)
    return radius * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)


BASES = _circle([-10, 10, 110, 130, 230, 250])
HOLES = _circle([-50, 50, 70, 170, 190, 290])


def _rates(s, state):
    R = state[3:12].reshape(3, 3)
    force, moment = state[12:15], state[15:18]
    x, y, z = R.T @ moment / BEND
    rate = R @ (R.T @ force / STRETCH + [0.0, 0.0, 1.0])
    turn = R @ np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    weight = -DENSITY * AREA * GRAVITY
    return np.concatenate([rate, turn.ravel(), weight, -np.cross(rate, force)])


def _tip(base, force, moment, length):
    start = np.concatenate([base, np.eye(3).ravel(), force, moment])
    ends = solve_ivp(_rates, (0.0, length), start, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    return ends[:3], ends[3:12].reshape(3, 3), ends[12:15], ends[15:18]


def inverse(position, orientation, printed=False):
    """Lengths of the legs, `(6,)`, m, and base wrenches `(n, m)`, `(6, 6)`, of a pose.

    **Arguments:**

    - `orientation`: rotation matrix of the platform.
    - `printed`: with the orientation row of the published program.
    """

    def rows(unknowns):
        legs, lengths = unknowns[:30].reshape(6, 5), unknowns[30:]
        force, moment, out = MASS * GRAVITY, np.zeros(3), []
        for leg, length, base, hole in zip(legs, lengths, BASES, HOLES, strict=True):
            arm = orientation @ hole
            p, R, n, m = _tip(base, leg[:3], np.append(leg[3:], 0.0), length)
            other = R @ orientation.T if printed else orientation.T @ R
            skew = R.T @ orientation - other
            out += [*(10.0 * (p - position - arm)), skew[2, 1], skew[0, 2]]
            force, moment = force - n, moment - m - np.cross(arm, n)
        return np.concatenate([out, force, 10.0 * moment])

    guess = np.append(np.zeros(30), np.full(6, position[2]))
    solution = root(rows, guess, tol=1e-12)
    assert np.max(np.abs(solution.fun)) < 1e-10
    wrenches = np.pad(solution.x[:30].reshape(6, 5), ((0, 0), (0, 1)))
    return solution.x[30:], wrenches
