"""Planar robots of any number of legs as chains of rigid links and springs: stability.

A rod becomes N links of length h that point along the mean of the angles at their ends. With the
motors held the potential energy `Σ k_b h / 2 ((θ_{j+1} - θ_j) / h - κ)²`, less the work of the
loads, is stationary under the constraint that each leg ends where the platform holds it. Its
second variation under that constraint counts the unstable directions; everything converges like
h². The Hessian of a chain is tridiagonal, and bordered by its constraints it has one negative
eigenvalue for each of them beside those of the Hessian on their null space. Vectors of the plane
are complex numbers here.
"""

from typing import NamedTuple

import numpy as np


class Chains(NamedTuple):
    """The numbers of a planar robot with revolute motors, SI units; one value a leg.

    **Attributes:**

    - `base`, `heading`: of the motors; their angles count from the headings.
    - `a`, `b`: rigid segments before and after the rods, in the axes of the rods' ends.
    - `length`: of the rods.
    - `k_b`, `curvature`, `weight`: of the rods, their stiffness, curvature at rest and dead load
        per length, `(n, parts)`: of as many equally long parts as there are columns.
    - `attachment`: where the legs hold the platform, in its axes.
    - `clamped`, `tilt`: whether they are clamped to it, and at which angle.
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
    clamped: np.ndarray
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
    - `doubtful`: whether an eigenvalue of the second variation, of the robot or of one of its legs,
        is nearer to zero than the given `margin`, in units of k_b / l. Motions are measured by
        `∫ δθ² ds / l` summed over the rods, `|δp|² / l²` and `δφ²`.
    - `moved`: largest change of an angle from the start to the equilibrium of the chains;
        infinite where Newton's method found none.
    """

    index: np.ndarray
    leg_indices: np.ndarray
    stiffness: np.ndarray
    doubtful: np.ndarray
    moved: np.ndarray


def read(robot) -> Chains:
    """The numbers of one of the package's robots; segments meet at multiples of a 12th of a rod."""
    legs, rod = robot.legs, robot.legs.rod

    def plane(vectors):
        return np.asarray(vectors) @ np.array([1.0, 1.0j])

    def along(name, scale=np.ravel):
        first = getattr(rod, name)
        if first is None:
            return np.zeros((robot.n, 1))
        if rod.further is None:
            return np.stack([[scale(value)] for value in first]).reshape(robot.n, 1)
        every = np.concatenate([first[:, None], getattr(rod.further, name)], axis=1)
        rows = []
        for leg in range(robot.n):
            ends = np.cumsum(rod.further.length[leg][::-1])[::-1] / rod.length[leg]
            junctions = 12.0 * (1.0 - ends)
            np.testing.assert_allclose(junctions, np.round(junctions), atol=1e-9)
            segments = np.searchsorted(junctions, np.arange(12) + 0.5)
            rows.append([scale(every[leg, k]) for k in segments])
        return np.array(rows).reshape(robot.n, 12)

    free = np.asarray(legs.joint.free)
    return Chains(
        base=plane(legs.base_position),
        heading=np.asarray(legs.base_rotation)[:, 0],
        a=plane(legs.a),
        b=plane(legs.b),
        length=np.asarray(rod.length),
        k_b=1.0 / along("curvature_compliance"),
        curvature=along("precurvature"),
        weight=along("force", plane),
        attachment=plane(legs.attachment_position),
        clamped=free[:, 2] < 0.5,
        tilt=np.asarray(legs.attachment_rotation)[:, 0],
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
    n_0 = n_y + 1j * n_z
    k_b, curvature, weight = _per_link(chains, links)

    def rates(link, s, angle, m):
        n = n_0 - s * weight[:, link]
        return m / k_b[:, link] + curvature[:, link], -_cross(np.exp(1j * angle), n)

    angle = q + chains.heading
    nodes = [angle]
    for link in range(links):
        for k in range(substeps):
            s = k * h
            r1, f1 = rates(link, s, angle, m)
            r2, f2 = rates(link, s + 0.5 * h, angle + 0.5 * h * r1, m + 0.5 * h * f1)
            r3, f3 = rates(link, s + 0.5 * h, angle + 0.5 * h * r2, m + 0.5 * h * f2)
            r4, f4 = rates(link, s + h, angle + h * r3, m + h * f3)
            angle = angle + h / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + r4)
            m = m + h / 6.0 * (f1 + 2.0 * f2 + 2.0 * f3 + f4)
        nodes.append(angle)
        n_0 = n_0 - chains.length / links * weight[:, link]
    return np.stack(nodes, axis=-1)


def _per_link(chains: Chains, links: int) -> list[np.ndarray]:
    """Stiffness, curvature at rest and weight of each link, `(n, links)`."""
    values = chains.k_b, chains.curvature, chains.weight
    return [np.repeat(v, links // v.shape[1], axis=1) for v in values]


def judge(chains: Chains, q, q_p, mu, links: int = 240, margin: float = 0.02) -> Verdict:
    """Stability of equilibria with motor angles `q`, platforms `q_p` and base wrenches `mu`.

    Newton's method takes them to the equilibria of the chains next to them, motors held.
    """
    start = angles_along(chains, q, mu, links)
    held, angles, pose = start[:, :, :1], start[:, :, 1:].copy(), np.array(q_p)
    # Against the forces and moments that the platform exerts on the tips.
    tips = mu[:, :, :2] @ np.array([1.0, 1.0j]) - chains.length * np.mean(chains.weight, axis=1)
    bend = start[:, :, -3:] @ np.array([0.5, -2.0, 1.5]) * links / chains.length
    moment = chains.k_b[:, -1] * (bend - chains.curvature[:, -1])
    moment = _cross(np.exp(1j * start[:, :, -1]) * chains.b, tips) - moment
    multiplier = np.stack([-tips.real, -tips.imag, chains.clamped * moment], axis=-1)

    going = np.ones(len(start), bool)
    largest = np.full(len(start), np.inf)
    for _ in range(12):
        system = _expand(chains, held[going], angles[going], pose[going], multiplier[going])
        steps = _newton_step(system)
        largest[going] = np.max(np.abs(steps[0]), axis=(1, 2))
        for values, step in zip((angles, pose, multiplier), steps, strict=True):
            values[going] += step
        # Those that run away are lost.
        going &= (largest > 1e-10) & (largest < 10.0)
        if not np.any(going):
            break
    found = largest < 1e-8
    moved = np.max(np.abs(angles - start[:, :, 1:]), axis=(1, 2))
    angles[~found], pose[~found] = start[~found, :, 1:], np.array(q_p)[~found]

    system = _expand(chains, held, angles, pose, multiplier)
    unit = np.mean(chains.k_b) / np.mean(chains.length)
    (low, legs_low), (index, leg_indices), (high, legs_high) = (
        _count(chains, system, shift * unit) for shift in (-margin, 0.0, margin)
    )
    return Verdict(
        index=index,
        leg_indices=leg_indices,
        stiffness=_stiffness(system),
        doubtful=(low != high) | np.any(legs_low != legs_high, axis=1),
        moved=np.where(found, moved, np.inf),
    )


class _System(NamedTuple):
    """Gaps, gradient and second derivatives of the Lagrangian; the first axes are `(…, n)`.

    **Attributes:**

    - `diagonal`, `beside`: of the Hessian in the angles of a leg.
    - `columns`: derivatives of the gaps of a joint in the angles, `(…, n, links, 3)`; the last
        one is that of the angle, zero for a pivot.
    - `idle`: 1 for what is no constraint, `(n, 3)`.
    - `follow`: derivatives of the gaps in the pose of the platform, `(…, n, 3, n_p)`.
    - `curved`: Hessian in the pose, `(…, n_p, n_p)`.
    - `gaps`, `slope`, `force`: what must vanish: gaps, gradients in the angles and in the pose.
    """

    diagonal: np.ndarray
    beside: np.ndarray
    columns: np.ndarray
    idle: np.ndarray
    follow: np.ndarray
    curved: np.ndarray
    gaps: np.ndarray
    slope: np.ndarray
    force: np.ndarray


def _newton_step(system):
    """Steps of the angles, of the pose and of the multipliers."""
    right = np.concatenate([system.columns, system.slope[..., None]], axis=-1)
    solved, _ = _tridiagonal(system.diagonal, system.beside, right)
    by_multiplier, by_slope = solved[..., :3], solved[..., 3]
    seen = np.einsum("...jk,...j->...k", system.columns, by_slope)
    legs, size = system.gaps.shape[1] * 3, system.force.shape[1]
    bordered = _bordered(system, by_multiplier)
    right = np.concatenate([(seen - system.gaps).reshape(-1, legs), -system.force], axis=1)
    step = np.linalg.solve(bordered, right[..., None])[..., 0]
    multiplier = step[:, :legs].reshape(system.gaps.shape)
    angles = -by_slope - np.einsum("...jk,...k->...j", by_multiplier, multiplier)
    return angles, step[:, legs : legs + size], multiplier


def _count(chains, system, shift):
    """Eigenvalues below a shift: of the robot, and of each leg with the platform held."""
    links, length = system.diagonal.shape[-1], np.mean(chains.length)
    diagonal = system.diagonal - shift / links
    solved, negative = _tridiagonal(diagonal, system.beside, system.columns)
    size = system.force.shape[1]
    mass = np.diag([length**-2, length**-2, 1.0][:size])
    bordered = _bordered(system._replace(curved=system.curved - shift * mass), solved)
    constraints = np.sum(system.idle == 0.0, axis=1)
    whole = np.sum(negative, axis=1) + _negative(bordered) - np.sum(constraints)
    return whole, negative + _negative(_joints(system, solved)) - constraints


def _stiffness(system):
    """Of the platform, the angles and the multipliers eliminated."""
    solved, _ = _tridiagonal(system.diagonal, system.beside, system.columns)
    held = np.linalg.solve(_joints(system, solved), system.follow)
    return system.curved - np.einsum("...lki,...lkj->...ij", system.follow, held)


def _joints(system, solved):
    """What is left for the multipliers of a leg without its angles, `(…, n, 3, 3)`."""
    idle = system.idle[:, :, None] * np.eye(3)
    return idle - np.swapaxes(system.columns, -1, -2) @ solved


def _bordered(system, solved):
    """What is left for the multipliers and the pose without the angles."""
    joints = _joints(system, solved)
    count, legs = joints.shape[:2]
    size = 3 * legs + system.force.shape[1]
    matrix = np.zeros((count, size, size))
    for leg in range(legs):
        own = slice(3 * leg, 3 * leg + 3)
        matrix[:, own, own] = joints[:, leg]
        matrix[:, own, 3 * legs :] = system.follow[:, leg]
        matrix[:, 3 * legs :, own] = np.swapaxes(system.follow[:, leg], 1, 2)
    matrix[:, 3 * legs :, 3 * legs :] = system.curved
    return matrix


def _negative(matrices):
    return np.sum(np.linalg.eigvalsh(matrices) < 0.0, axis=-1)


def _tridiagonal(diagonal, beside, right):
    """Solution of symmetric tridiagonal systems, and how many of their pivots are negative."""
    count = diagonal.shape[-1]
    pivots, solution = diagonal.copy(), right.copy()
    for j in range(1, count):
        factor = beside[..., j - 1] / pivots[..., j - 1]
        pivots[..., j] -= factor * beside[..., j - 1]
        solution[..., j, :] -= factor[..., None] * solution[..., j - 1, :]
    solution /= pivots[..., None]
    for j in range(count - 2, -1, -1):
        factor = beside[..., j] / pivots[..., j]
        solution[..., j, :] -= factor[..., None] * solution[..., j + 1, :]
    return solution, np.sum(pivots < 0.0, axis=-1)


def _cross(arm, force):
    return np.imag(np.conj(arm) * force)


def _dot(a, b):
    return np.real(np.conj(a) * b)


def _pair(vectors):
    return np.stack([vectors.real, vectors.imag], axis=-1)


def _expand(chains, held, angles, pose, multiplier) -> _System:
    """Derivatives at angles `(…, n, links)`, a pose and multipliers `(…, n, 3)`."""
    count, legs, links = angles.shape
    clamped = chains.clamped.astype(float)
    point = pose[:, 0] + 1j * pose[:, 1]
    turn = pose[:, 2] if chains.oriented else np.zeros(count)

    h = (chains.length / links)[:, None]
    k_b, curvature, weight = _per_link(chains, links)
    spring = k_b / h
    nodes = np.concatenate([held, angles], axis=2)
    link = h * np.exp(0.5j * (nodes[:, :, 1:] + nodes[:, :, :-1]))
    first = np.exp(1j * nodes[:, :, 0]) * chains.a
    last = np.exp(1j * nodes[:, :, -1]) * chains.b
    arm = np.exp(1j * turn)[:, None] * chains.attachment

    # Rods may end any number of turns further on.
    error = angles[:, :, -1] - chains.tilt - turn[:, None]
    error = np.remainder(error + np.pi, 2.0 * np.pi) - np.pi
    gap = chains.base + first + link.sum(axis=2) + last - point[:, None] - arm
    gaps = np.concatenate([_pair(gap), (clamped * error)[:, :, None]], axis=2)

    # An angle turns half of the links on its two sides, the last one the rigid segment too.
    turned = 0.5j * link
    turned[:, :, :-1] += 0.5j * link[:, :, 1:]
    turned[:, :, -1] += 1j * last
    columns = np.concatenate([_pair(turned), np.zeros((count, legs, links, 1))], axis=3)
    columns[:, :, -1, 2] = clamped
    follow = np.zeros((count, legs, 3, 3))
    follow[..., 0, 0] = follow[..., 1, 1] = -1.0
    follow[..., :2, 2] = -_pair(1j * arm)
    follow[..., 2, 2] = -clamped

    # What turns a link: the multiplier and the weight of all that it carries.
    pull = multiplier[:, :, 0] + 1j * multiplier[:, :, 1]
    carried = h * weight
    hung = -(np.cumsum(carried[:, ::-1], axis=1)[:, ::-1] - 0.5 * carried)
    strain = np.diff(nodes, axis=2) - h * curvature
    slope = spring * strain + 0.5 * _dot(hung, 1j * link)
    after = -spring * strain + 0.5 * _dot(hung, 1j * link)
    slope[:, :, :-1] += after[:, :, 1:]
    slope += np.einsum("klja,kla->klj", columns, multiplier)
    load = np.array([chains.force.real, chains.force.imag, chains.moment])
    force = np.einsum("klai,kla->ki", follow, multiplier) - load

    # The second derivative of a vector that turns is its opposite.
    bent = -0.25 * _dot(pull[:, :, None] + hung, link)
    diagonal = bent + spring
    diagonal[:, :, :-1] += (bent + spring)[:, :, 1:]
    diagonal[:, :, -1] -= _dot(pull, last)
    curved = np.zeros((count, 3, 3))
    curved[:, 2, 2] = np.sum(_dot(pull, arm), axis=1)

    size = pose.shape[1]
    return _System(
        diagonal=diagonal,
        beside=(bent - spring)[:, :, 1:],
        columns=columns,
        idle=np.stack([0.0 * clamped, 0.0 * clamped, 1.0 - clamped], axis=1),
        follow=follow[..., :size],
        curved=curved[:, :size, :size],
        gaps=gaps,
        slope=slope,
        force=force[:, :size],
    )
