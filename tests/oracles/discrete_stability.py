"""Planar robots of any number of legs as chains of rigid links and springs: stability.

A rod becomes N links of length h that point along the mean of the angles at their ends. With the
motors held the potential energy `Σ k_b h / 2 ((θ_{j+1} - θ_j) / h - κ)²`, less the work of the
loads, is stationary under the constraint that each leg ends where the platform holds it. Its
second variation under that constraint counts the unstable directions; everything converges like
h². Vectors of the plane are complex numbers here.
"""

from typing import NamedTuple

import numpy as np


class Chains(NamedTuple):
    """The numbers of a planar robot with revolute motors, SI units; one value a leg.

    **Attributes:**

    - `base`, `heading`: of the motors; their angles count from the headings.
    - `a`, `b`: rigid segments before and after the rods, in the axes of the rods' ends.
    - `length`, `k_b`, `curvature`: of the rods, the curvature at rest.
    - `weight`: dead load per length of the rods.
    - `attachment`: where the legs hold the platform, in its axes.
    - `tilt`: angle at which they are clamped to it; NaN for pivots.
    - `force`, `moment`: dead load on the platform.
    - `oriented`: a body, otherwise a mere point.
    """

    base: np.ndarray
    heading: np.ndarray
    a: np.ndarray
    b: np.ndarray
    length: np.ndarray
    k_b: np.ndarray
    curvature: np.ndarray
    weight: np.ndarray
    attachment: np.ndarray
    tilt: np.ndarray
    force: complex
    moment: float
    oriented: bool


class Verdict(NamedTuple):
    """What the chains say about equilibria; each array has one entry per equilibrium.

    **Attributes:**

    - `index`: negative directions of the energy among the motions that the joints allow.
    - `leg_indices`: the same with the platform held, of each leg, `(…, n)`.
    - `stiffness`: of the platform, all else at equilibrium, `(…, n_p, n_p)`.
    - `smallest`: least magnitude of an eigenvalue of the second variation, of the robot or of one
        of its legs, in units of k_b / l, for motions measured by `∫ δθ² ds / l` summed over the
        rods, `|δp|² / l²` and `δφ²`.
    - `moved`: largest change of an angle from the start to the equilibrium of the chains;
        infinite where Newton's method found none.
    """

    index: np.ndarray
    leg_indices: np.ndarray
    stiffness: np.ndarray
    smallest: np.ndarray
    moved: np.ndarray


def read(robot) -> Chains:
    """The numbers of one of the package's robots."""
    legs, rod = robot.legs, robot.legs.rod

    def plane(vectors):
        return np.asarray(vectors) @ np.array([1.0, 1.0j])

    free = np.asarray(legs.joint.free)
    return Chains(
        base=plane(legs.base_position),
        heading=np.asarray(legs.base_rotation)[:, 0],
        a=plane(legs.a),
        b=plane(legs.b),
        length=np.asarray(rod.length),
        k_b=1.0 / np.asarray(rod.curvature_compliance)[:, 0],
        curvature=np.asarray(rod.precurvature)[:, 0],
        weight=np.zeros(robot.n) if rod.force is None else plane(rod.force),
        attachment=plane(legs.attachment_position),
        tilt=np.where(free[:, 2] > 0.5, np.nan, np.asarray(legs.attachment_rotation)[:, 0]),
        force=complex(plane(robot.f_P)),
        moment=float(robot.m_P[0]),
        oriented=robot.oriented,
    )


def angles_along(chains: Chains, q: np.ndarray, mu: np.ndarray, links: int, substeps: int = 4):
    """Angles at the nodes of the rods by Runge-Kutta steps of order 4, `(…, n, links + 1)`.

    **Arguments:**

    - `q`: motor angles, `(…, n)`.
    - `mu`: forces and moments `(n_y, n_z, m)` at the bases of the rods, `(…, n, 3)`.
    """
    h = chains.length / (links * substeps)
    n_y, n_z, m = np.moveaxis(np.asarray(mu), -1, 0)

    def rates(s, angle, m):
        n = n_y + 1j * n_z - s * chains.weight
        return m / chains.k_b + chains.curvature, -_cross(np.exp(1j * angle), n)

    angle = q + chains.heading
    nodes = [angle]
    for link in range(links):
        for k in range(substeps):
            s = (link * substeps + k) * h
            r1, f1 = rates(s, angle, m)
            r2, f2 = rates(s + 0.5 * h, angle + 0.5 * h * r1, m + 0.5 * h * f1)
            r3, f3 = rates(s + 0.5 * h, angle + 0.5 * h * r2, m + 0.5 * h * f2)
            r4, f4 = rates(s + h, angle + h * r3, m + h * f3)
            angle = angle + h / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + r4)
            m = m + h / 6.0 * (f1 + 2.0 * f2 + 2.0 * f3 + f4)
        nodes.append(angle)
    return np.stack(nodes, axis=-1)


def judge(chains: Chains, q, q_p, mu, links: int = 60, batch: int = 50) -> Verdict:
    """Stability of equilibria with motor angles `q`, platforms `q_p` and base wrenches `mu`.

    Newton's method takes them to the equilibria of the chains next to them, motors held.
    """
    parts = [
        _judge(chains, *(np.asarray(x)[k : k + batch] for x in (q, q_p, mu)), links)
        for k in range(0, len(q), batch)
    ]
    return Verdict(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _judge(chains, q, q_p, mu, links):
    start = angles_along(chains, q, mu, links)
    count, legs = len(q), len(chains.length)
    clamped = _clamped(chains)
    nodes = legs * links
    size, rows = nodes + q_p.shape[1], 2 * legs + len(clamped)
    x = np.concatenate([start[:, :, 1:].reshape(count, nodes), q_p], axis=1)
    # Against the forces and moments that the platform exerts on the tips.
    tips = mu[:, :, :2] @ np.array([1.0, 1.0j]) - chains.length * chains.weight
    multiplier = np.zeros((count, rows))
    multiplier[:, : 2 * legs] = -tips.view(float)
    bend = start[:, clamped, -3:] @ np.array([0.5, -2.0, 1.5]) * links / chains.length[clamped]
    lever = _cross(np.exp(1j * start[:, clamped, -1]) * chains.b[clamped], tips[:, clamped])
    multiplier[:, 2 * legs :] = lever - chains.k_b[clamped] * (bend - chains.curvature[clamped])

    for _ in range(12):
        gap, slope, matrix = _expand(chains, start[:, :, 0], x, multiplier, links)
        right = -np.concatenate([slope, gap], axis=1)
        step = np.linalg.solve(matrix, right[..., None])[..., 0]
        x, multiplier = x + step[:, :size], multiplier + step[:, size:]
        if np.max(np.abs(step[:, :size])) < 1e-10:
            break
    found = np.max(np.abs(step[:, :size]), axis=1) < 1e-8
    moved = np.max(np.abs(x[:, :nodes] - start[:, :, 1:].reshape(count, nodes)), axis=1)

    length = np.mean(chains.length)
    unit = np.full(size, np.sqrt(links))
    unit[nodes:] = [length, length, 1.0][: size - nodes]
    hessian = unit[:, None] * matrix[:, :size, :size] * unit
    constraints = matrix[:, size:, :size] * unit
    spectra = [_on_null_space(hessian, constraints)]
    for leg in range(legs):
        own = slice(leg * links, (leg + 1) * links)
        held = [2 * leg, 2 * leg + 1, *(2 * legs + np.flatnonzero(clamped == leg))]
        spectra.append(_on_null_space(hessian[:, own, own], constraints[:, held, own]))
    index, *leg_indices = (np.sum(spectrum < 0.0, axis=1) for spectrum in spectra)
    smallest = np.min(np.abs(np.concatenate(spectra, axis=1)), axis=1)

    rest = np.r_[:nodes, size : size + rows]
    pulled = matrix[:, rest, nodes:size]
    follow = np.linalg.solve(matrix[:, rest[:, None], rest], pulled)
    return Verdict(
        index=index,
        leg_indices=np.stack(leg_indices, axis=1),
        stiffness=matrix[:, nodes:size, nodes:size] - np.swapaxes(pulled, 1, 2) @ follow,
        smallest=smallest * length / np.mean(chains.k_b),
        moved=np.where(found, moved, np.inf),
    )


def _on_null_space(hessian, constraints):
    """Eigenvalues of a quadratic form on what constraints leave free."""
    full = np.linalg.qr(np.swapaxes(constraints, 1, 2), mode="complete")[0]
    tangents = full[:, :, constraints.shape[1] :]
    return np.linalg.eigvalsh(np.swapaxes(tangents, 1, 2) @ hessian @ tangents)


def _clamped(chains):
    return np.flatnonzero(~np.isnan(chains.tilt))


def _cross(arm, force):
    return np.imag(np.conj(arm) * force)


def _dot(a, b):
    return np.real(np.conj(a) * b)


def _expand(chains, held, x, multiplier, links):
    """Gaps of the joints, gradient of the Lagrangian, and the matrix of Newton's method."""
    count, legs = len(x), len(chains.length)
    clamped = _clamped(chains)
    size, rows, nodes = x.shape[1], multiplier.shape[1], legs * links
    angles = x[:, :nodes].reshape(count, legs, links)
    angles = np.concatenate([held[:, :, None], angles], axis=2)
    point = x[:, nodes] + 1j * x[:, nodes + 1]
    turn = x[:, -1] if chains.oriented else np.zeros(count)

    h = (chains.length / links)[:, None]
    spring = chains.k_b[:, None] / h
    link = h * np.exp(0.5j * (angles[:, :, 1:] + angles[:, :, :-1]))
    first = np.exp(1j * angles[:, :, 0]) * chains.a
    last = np.exp(1j * angles[:, :, -1]) * chains.b
    arm = np.exp(1j * turn)[:, None] * chains.attachment

    gap = np.zeros((count, rows))
    ends = chains.base + first + link.sum(axis=2) + last
    gap[:, : 2 * legs] = (ends - point[:, None] - arm).view(float)
    # Rods may end any number of turns further on.
    error = angles[:, clamped, -1] - chains.tilt[clamped] - turn[:, None]
    gap[:, 2 * legs :] = np.remainder(error + np.pi, 2.0 * np.pi) - np.pi

    # An angle turns half of the links on its two sides, the last one the rigid segment too.
    turned = 0.5j * link
    turned[:, :, :-1] += 0.5j * link[:, :, 1:]
    turned[:, :, -1] += 1j * last
    constraints = np.zeros((count, rows, size))
    for leg in range(legs):
        y, z = 2 * leg, 2 * leg + 1
        own = slice(leg * links, (leg + 1) * links)
        constraints[:, y, own], constraints[:, z, own] = turned[:, leg].real, turned[:, leg].imag
        constraints[:, y, nodes] = constraints[:, z, nodes + 1] = -1.0
        if chains.oriented:
            constraints[:, y, -1], constraints[:, z, -1] = arm[:, leg].imag, -arm[:, leg].real
    for row, leg in enumerate(clamped, start=2 * legs):
        constraints[:, row, (leg + 1) * links - 1] = 1.0
        constraints[:, row, -1] = -1.0

    # What turns a link: the multiplier and the weight of all that it carries.
    pull = multiplier[:, : 2 * legs].reshape(count, legs, 2) @ np.array([1.0, 1.0j])
    beyond = 1.0 - (np.arange(links) + 0.5) / links
    hung = -(chains.length * chains.weight)[:, None] * beyond
    strain = np.diff(angles, axis=2) - h * chains.curvature[:, None]
    before = spring * strain + 0.5 * _dot(hung, 1j * link)
    after = -spring * strain + 0.5 * _dot(hung, 1j * link)
    before[:, :, :-1] += after[:, :, 1:]
    slope = np.einsum("kr,krs->ks", multiplier, constraints)
    slope[:, :nodes] += before.reshape(count, nodes)
    load = [chains.force.real, chains.force.imag, chains.moment]
    slope[:, nodes:] -= load[: size - nodes]

    # The second derivative of a vector that turns is its opposite.
    bent = -0.25 * _dot(pull[:, :, None] + hung, link)
    diagonal = bent + spring
    diagonal[:, :, :-1] += bent[:, :, 1:] + spring
    diagonal[:, :, -1] -= _dot(pull, last)
    matrix = np.zeros((count, size + rows, size + rows))
    place = np.arange(nodes).reshape(legs, links)
    matrix[:, place, place] = diagonal
    inner, outer = place[:, :-1], place[:, 1:]
    matrix[:, inner, outer] = matrix[:, outer, inner] = (bent - spring)[:, :, 1:]
    if chains.oriented:
        matrix[:, size - 1, size - 1] = np.sum(_dot(pull, arm), axis=1)
    matrix[:, size:, :size] = constraints
    matrix[:, :size, size:] = np.swapaxes(constraints, 1, 2)
    return gap, slope, matrix
