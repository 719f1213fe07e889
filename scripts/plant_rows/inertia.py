"""Inertia: what each torque accelerates, wheels reflected into the body (reference plant model, section 2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from random import Random

from bench.config import Robot, Wheel
from bench.kinematics import Kinematics
from plant_rows.algebra import Vector, dot, solved
from plant_rows.check import FLAT, LAYOUTS, NO_LOSSES, Check, first_step, robot_with


def acceleration_under(robot: Robot, torques_nm: Sequence[float]) -> Vector:
    """M a = H' tau with M = diag(m, m, Jz) + J H' H, by Cramer's rule."""
    rows = Kinematics(robot.wheels).inverse_rows
    body = robot.body
    matrix = [[0.0] * 3 for _ in range(3)]
    for i, mass in enumerate((body.mass_kg, body.mass_kg, body.inertia_kgm2)):
        matrix[i][i] = mass
        for k in range(3):
            matrix[i][k] += robot.motor.inertia_kgm2 * math.fsum(row[i] * row[k] for row in rows)
    push = [math.fsum(row[i] * torque for row, torque in zip(rows, torques_nm, strict=True)) for i in range(3)]
    return solved(matrix, push)


def worst_inertia(wheels: Sequence[Wheel]) -> float:
    """Every wheel alone and four mixtures: the largest difference from M^-1 H' tau, as a share of the largest part."""
    robot = robot_with(wheels, **NO_LOSSES, **FLAT)
    count = len(robot.wheels)
    random = Random(3)
    patterns = [[0.02 if i == k else 0.0 for i in range(count)] for k in range(count)]
    patterns += [[random.uniform(-0.02, 0.02) for _ in range(count)] for _ in range(4)]
    worst = 0.0
    for torques in patterns:
        wanted = acceleration_under(robot, torques)
        got = first_step(robot, [torque / 0.18 for torque in torques])
        largest = max(map(abs, wanted))
        worst = max(worst, *(abs(a - b) / largest for a, b in zip(got, wanted, strict=True)))
    return worst


def effective(axis: int) -> float:
    """Force over acceleration along one axis, with torques that move the default robot along it alone."""
    robot = robot_with(**NO_LOSSES, **FLAT)
    rows = Kinematics(robot.wheels).inverse_rows
    # tau = (H^+)' (M e_axis): the torques whose generalised force is M times a unit acceleration along the axis.
    unit = 0.3 if axis < 2 else 3.0
    matrix = [[math.fsum(row[i] * row[k] for row in rows) for k in range(3)] for i in range(3)]
    mass = acceleration_inverse(robot, axis)
    weights = solved(matrix, [unit * part for part in mass])
    torques = [dot(row, weights) for row in rows]
    got = first_step(robot, [torque / 0.18 for torque in torques])
    return unit * mass[axis] / got[axis]


def acceleration_inverse(robot: Robot, axis: int) -> Vector:
    """A column of M."""
    rows = Kinematics(robot.wheels).inverse_rows
    body = (robot.body.mass_kg, robot.body.mass_kg, robot.body.inertia_kgm2)
    column = [robot.motor.inertia_kgm2 * math.fsum(row[i] * row[axis] for row in rows) for i in range(3)]
    column[axis] += body[axis]
    return column[0], column[1], column[2]


def rows() -> list[Check]:
    """In the order of the page."""
    return [
        *(
            Check(
                f"reflected inertia, {name}: worst of all torques, share", "2", 0.0, 1e-9,
                partial(worst_inertia, wheels),
            )
            for name, wheels in LAYOUTS.items()
        ),
        Check("effective mass forward, kg", "2", 4.672, 5e-4, partial(effective, 0)),
        Check("effective mass sideways, kg", "2", 3.47, 5e-3, partial(effective, 1)),
        Check("effective yaw inertia, kg m2", "2", 0.0240, 5e-5, partial(effective, 2)),
        Check(
            "torques (0.04, -0.08, 0.04) N m yaw at, rad/s2", "2", 2.23, 1.1e-2,
            lambda: first_step(robot_with(**NO_LOSSES), [t / 0.18 for t in (0.04, -0.08, 0.04)])[2],
        ),
        Check(
            "torques of 0.05 N m each push sideways at, m/s2", "2", -0.062, 5e-4,
            lambda: first_step(robot_with(**NO_LOSSES), [0.05 / 0.18] * 3)[1],
        ),
    ]  # fmt: skip
