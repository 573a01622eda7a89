"""What an equilibrium of any robot leaves unbalanced, by scipy and rotation matrices.

Written from the description of a leg and of its joints, for one configuration; a planar robot is
that of a space whose third axis is the normal of its plane.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from tests.oracles.cosserat import SpatialRod, integrate_segments


def _vector(values):
    """A vector of the plane or of space in space."""
    values = np.asarray(values, float)
    return np.pad(values, (0, 3 - values.size))


def _turn(values):
    """A rotation vector or a moment in space; in the plane it is about the third axis."""
    values = np.asarray(values, float)
    return np.pad(values, (3 - values.size, 0))


def _matrix(values):
    return Rotation.from_rotvec(_turn(values)).as_matrix()


def _free(robot, flags):
    d = robot.geometry.d
    return _vector(flags[:d]) > 0.5, _turn(flags[d:]) > 0.5


def _base(robot, i, q, mu):
    """Position and rotation of a rod's base, and `n(0)`, `m(0)` there, world axes."""
    legs, d = robot.legs, robot.geometry.d
    mounted = _matrix(legs.base_rotation[i])
    carrier = mounted @ _matrix(np.asarray(legs.screw[i, d:]) * q)
    place = _vector(legs.base_position[i]) + mounted @ _vector(np.asarray(legs.screw[i, :d]) * q)
    a = np.asarray(legs.a[i]) + (0.0 if legs.stroke is None else np.asarray(legs.stroke[i]) * q)
    linear, angular = _vector(mu[:d]), _turn(mu[d:])
    if legs.base_joint is None:
        return place + carrier @ _vector(a), carrier, linear, angular
    joint = legs.base_joint
    slides, turns = _free(robot, np.asarray(joint.free[i]))
    outer = carrier @ _matrix(joint.rotation[i])
    place = place + carrier @ _vector(joint.position[i]) + outer @ np.where(slides, linear, 0.0)
    eta = np.where(turns, angular, 0.0)
    if np.sum(turns) == 2:
        # One after the other; the moment is about the normal of both axes.
        first, second = np.flatnonzero(turns)
        between = outer @ Rotation.from_rotvec(np.eye(3)[first] * eta[first]).as_matrix()
        leg = between @ Rotation.from_rotvec(np.eye(3)[second] * eta[second]).as_matrix()
    else:
        between, leg = outer, outer @ Rotation.from_rotvec(eta).as_matrix()
    force = outer @ np.where(slides, 0.0, linear)
    moment = between @ np.where(turns, 0.0, angular)
    arm = leg @ _vector(a)
    return place + arm, leg, force, moment - np.cross(arm, force)


def _joint_rows(robot, i, frame, gap, tip, force, moment):
    """Errors of the locked motions, m and rad, and wrenches of the free ones, N and N·m."""
    slides, turns = _free(robot, np.asarray(robot.legs.joint.free[i]))
    errors = list((frame.T @ gap)[~slides])
    wrenches = list((frame.T @ force)[slides])
    axes = [frame[:, k] for k in range(3)]
    if np.sum(turns) == 2:
        first, second = np.flatnonzero(turns)
        axes[second] = tip[:, second]
        errors.append(axes[first] @ axes[second])
    else:
        errors += list(Rotation.from_matrix(tip.T @ frame).as_rotvec()[~turns])
    wrenches += [axis @ moment for axis, free in zip(axes, turns, strict=True) if free]
    return errors, wrenches


def _segments(robot, i, fed, base):
    """The segments of a rod, the fed length in the first one, loads in the axes of the base."""
    rod, r = robot.legs.rod, robot.geometry.r
    further = rod.further
    places = [(rod, i)]
    lengths = [float(rod.length[i]) + fed]
    if further is not None:
        places += [(further, (i, j)) for j in range(further.length.shape[1])]
        lengths = [lengths[0] - float(np.sum(further.length[i])), *np.asarray(further.length[i])]
    for (part, place), length in zip(places, lengths, strict=True):
        if length == 0.0:
            continue
        bend = np.asarray(part.curvature_compliance[place])
        stiff = np.zeros(3) if part.strain_compliance is None else part.strain_compliance[place]
        load = np.zeros(3) if part.force is None else part.force[place]
        yield SpatialRod(
            length=length,
            bend=np.pad(bend, (3 - r, 0), constant_values=bend[-1]),
            rest=_turn(part.precurvature[place]),
            stretch=_vector(stiff),
            load=base.T @ _vector(load),
        )


def unbalanced(robot, y, rtol=1e-12) -> float:
    """Largest gap, in rod lengths or rad, or wrench, in units of `k_b / l²`, that is left."""
    d, r, n = robot.geometry.d, robot.geometry.r, robot.n
    y, legs, rod = np.asarray(y), robot.legs, robot.legs.rod
    length = float(np.mean(rod.length))
    unit = 1.0 / (float(np.mean(rod.curvature_compliance[:, -1])) * length**2)
    q_p = y[robot.n_a : robot.n_a + robot.n_p]
    mu = y[robot.n_a + robot.n_p :].reshape(n, d + r)
    q = np.asarray(robot.transmission) @ y[: robot.n_a]
    position = _vector(q_p[:d])
    orientation = _matrix(q_p[d:]) if robot.oriented else np.eye(3)
    force, moment = _vector(robot.f_P), _turn(robot.m_P)
    if robot.loads is not None:
        for place, load in zip(robot.loads.position, robot.loads.force, strict=True):
            force = force + _vector(load)
            moment = moment + np.cross(orientation @ _vector(place), _vector(load))
    left = []
    for i in range(n):
        place, base, n_0, m_0 = _base(robot, i, q[i], mu[i])
        fed = 0.0 if legs.feed is None else float(legs.feed[i]) * q[i]
        segments = list(_segments(robot, i, fed, base))
        p, R, n_l, m_l, *_ = (
            part[-1] for part in integrate_segments(segments, base.T @ n_0, base.T @ m_0, rtol)
        )
        tip = base @ R
        b = tip @ _vector(legs.b[i])
        end, n_l = place + base @ p + b, base @ n_l
        m_l = base @ m_l - np.cross(b, n_l)
        arm = orientation @ _vector(legs.attachment_position[i])
        frame = orientation @ _matrix(legs.attachment_rotation[i])
        gap = position + arm - end
        errors, wrenches = _joint_rows(robot, i, frame, gap, tip, n_l, m_l)
        left += list(np.array(errors) / np.array([length] * (len(errors))) * min(length, 1.0))
        left += list(np.array(wrenches) / (unit * max(length, 1.0)))
        force, moment = force - n_l, moment - m_l - np.cross(end - position, n_l)
    left += list(force / unit)
    left += list(moment / (unit * length)) if robot.oriented else []
    return float(np.max(np.abs(left)))
