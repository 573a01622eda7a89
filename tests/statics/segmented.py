"""Robots whose rods are cut into segments, or replaced by rods of several segments."""

import dataclasses

import numpy as np

from cpr_jax.robots.robot import make_robot
from cpr_jax.rods.segments import segmented_rod


def with_rods(robot, rods):
    """The robot with other rods, one a leg."""
    legs = [dataclasses.replace(robot.leg(i), rod=rod) for i, rod in enumerate(rods)]
    again = make_robot(robot.geometry, legs, oriented=robot.oriented)
    legs = dataclasses.replace(again.legs, turns=robot.legs.turns)
    return dataclasses.replace(robot, legs=legs, uncertainty={})


def cut(robot, shares):
    """The same robot with each rod cut at shares of its length, a list of shares a leg."""
    rods = []
    for i, parts in enumerate(shares):
        rod = robot.leg(i).rod
        pieces = [dataclasses.replace(rod, length=rod.length * part) for part in parts]
        rods.append(segmented_rod(pieces))
    return with_rods(robot, rods)


def stepped(robot, shares, seed=0, spread=0.7, weight=1.0):
    """A robot whose segments differ in stiffness, in curvature at rest and in weight.

    Stiffnesses differ by up to factors of `exp(±spread)`, both between segments and from axis to
    axis. `weight` is the size of the distributed force beside what a rod bears.
    """
    rng = np.random.default_rng(seed)
    d, r = robot.geometry.d, robot.geometry.r
    rods = []
    for i, parts in enumerate(shares):
        rod = robot.leg(i).rod
        pieces = []
        for part in parts:
            factors = np.exp(spread * rng.uniform(-1.0, 1.0, r))
            unit = 1.0 / float(np.mean(rod.curvature_compliance)) / float(rod.length) ** 3
            pieces.append(
                dataclasses.replace(
                    rod,
                    length=rod.length * part,
                    curvature_compliance=rod.curvature_compliance * factors,
                    precurvature=rod.precurvature * rng.uniform(0.3, 1.7, r),
                    force=weight * unit * rng.normal(size=d),
                )
            )
        rods.append(segmented_rod(pieces))
    return with_rods(robot, rods)
