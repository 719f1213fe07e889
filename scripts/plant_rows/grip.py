"""Grip: how hard wheels can push that slip, and when they begin to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import combinations
from random import Random

from bench.config import Robot, Wheel
from bench.ground.loads import load_rows
from bench.kinematics import Kinematics
from bench.plant import STEP_S, Plant
from plant_rows.algebra import Vector, determinant, dot, solved
from plant_rows.check import (
    FLAT,
    FORWARDS,
    LAYOUTS,
    NO_LOSSES,
    SPIN,
    Check,
    driven,
    first_step,
    mecanum,
    robot_with,
    run,
    times,
)

DIRECTIONS_DEG = (0.0, 30.0, 45.0, 60.0, 90.0)
SLICK = {"ground_grip": 0.15, "ground_rolling": 0.0, **FLAT}
GRIP_TABLE = {
    "004": (5.269, 3.555, 2.514, 2.052, 1.777),
    "omni 60/135/225/300": (5.495, 3.621, 3.374, 3.374, 3.434),
    "mecanum 45": (4.856, 3.555, 3.434, 3.555, 4.856),
}


def grip_limit(robot: Robot, direction_deg: float) -> tuple[float, Vector]:
    """The largest acceleration along a direction without yaw, and the multipliers that prove it.

    Linear programme: largest F with sum f_i w_i = F (u, 0), |f_i| <= mu N_i, w_i = (axis, moment). Its dual has a
    vertex y for every pair of wheels (y w_i = y w_j = 0, y (u, 0) = 1); the least sum of mu N_i |y w_i| over them is F.
    """
    ux, uy = math.cos(math.radians(direction_deg)), math.sin(math.radians(direction_deg))
    rows = Kinematics(robot.wheels).axes
    loads = [rest for rest, _, _ in load_rows(robot.wheels, robot.body.mass_kg, 0.0)]
    best = math.inf
    proof = (0.0, 0.0, 0.0)
    for one, other in combinations(rows, 2):
        matrix = [[ux, uy, 0.0], list(one), list(other)]
        if abs(determinant(matrix)) < 1e-12:
            continue
        y = solved(matrix, [1.0, 0.0, 0.0])
        force = math.fsum(robot.ground.grip * n * abs(dot(y, row)) for n, row in zip(loads, rows, strict=True))
        if force < best:
            best, proof = force, y
    return best / robot.body.mass_kg, proof


def grip_reached(wheels: Sequence[Wheel], direction_deg: float) -> float:
    """All wheels spin the way that the bound's multipliers want: what the plant then does along them."""
    robot = robot_with(wheels, **NO_LOSSES, **FLAT)
    _, y = grip_limit(robot, direction_deg)
    signs = [
        0.0 if abs(dot(y, row)) < 1e-9 else math.copysign(1.0, dot(y, row)) for row in Kinematics(robot.wheels).axes
    ]
    ax, ay, alpha = first_step(robot, times(signs, 10.0))
    return y[0] * ax + y[1] * ay + y[2] * robot.body.inertia_kgm2 * alpha / robot.body.mass_kg


def beyond_the_grip(wheels: Sequence[Wheel]) -> float:
    """By how much random currents exceed the bound, in any direction of the table."""
    return max(0.0, *(most_of_many(wheels, deg) for deg in DIRECTIONS_DEG))


def most_of_many(wheels: Sequence[Wheel], direction_deg: float) -> float:
    """Of a hundred random currents, the most along the bound, less the bound."""
    robot = robot_with(wheels, **NO_LOSSES, **FLAT)
    limit, y = grip_limit(robot, direction_deg)
    random = Random(round(direction_deg))
    most = 0.0
    for _ in range(100):
        ax, ay, alpha = first_step(robot, [random.uniform(-10.0, 10.0) for _ in robot.wheels])
        most = max(most, y[0] * ax + y[1] * ay + y[2] * robot.body.inertia_kgm2 * alpha / robot.body.mass_kg)
    return most - limit


def slip_onset() -> float:
    """The current between 1.9 and 2.2 A from which a front wheel slips in the first step from rest."""
    low, high = 1.9, 2.2
    for _ in range(30):
        middle = (low + high) / 2.0
        plant = run(Plant(robot_with(ground_rolling=0.0, **FLAT), None), times(FORWARDS, middle), 1)
        low, high = (low, middle) if abs(plant.slip_mps[0]) > 1e-9 else (middle, high)
    return low


def forward_grip() -> float:
    """The most that the front wheels get onto the floor, load transfer included."""
    plant = run(Plant(robot_with(ground_rolling=0.0), None), times(FORWARDS, 5.0), 60)
    before = plant.twist.vx_mps
    return (run(plant, times(FORWARDS, 5.0), 1).twist.vx_mps - before) / STEP_S


def tipping(forwards: bool) -> float:
    """Acceleration at which a wheel's load is gone: the front ones forwards, the rear one braking."""
    rest, per_ax, _ = load_rows(robot_with().wheels, 1.6, 0.035)[0 if forwards else 1]
    return -rest / per_ax


def rows() -> list[Check]:
    """In the order of the page."""
    return [
        Check(
            "turning, all wheels spinning, mu 0.7, rad/s2", "2", 119.7, 0.05,
            lambda: first_step(robot_with(ground_rolling=0.0, **FLAT), times(SPIN, 10.0))[2],
        ),
        Check(
            "forward, wheels spinning, mu 0.15, m/s2", "4.1", 1.1291, 5e-5,
            lambda: driven(robot_with(**SLICK), times(FORWARDS, 3.0), 100)[0] / 0.1,
        ),
        Check(
            "turning, wheels spinning, mu 0.15, rad/s2", "4.1", 25.6461, 5e-5,
            lambda: driven(robot_with(**SLICK), times(SPIN, 3.0), 100)[2] / 0.1,
        ),
        Check(
            "mecanum forward, spinning, mu 0.15, m/s2", "4.1", 1.0405, 5e-5,
            lambda: driven(robot_with(mecanum(), **SLICK), (3.0, 3.0, 3.0, 3.0), 100)[0] / 0.1,
        ),
        Check(
            "mecanum sideways, spinning, mu 0.15, m/s2", "4.1", 1.0405, 5e-5,
            lambda: driven(robot_with(mecanum(), **SLICK), (-3.0, 3.0, 3.0, -3.0), 100)[1] / 0.1,
        ),
        *(
            Check(
                f"grip limit {name} at {deg:g} deg, m/s2", "2", limit, 6e-4, partial(grip_reached, LAYOUTS[name], deg),
            )
            for name, limits in GRIP_TABLE.items()
            for deg, limit in zip(DIRECTIONS_DEG, limits, strict=True)
        ),
        *(
            Check(f"beyond it with any currents, {name}, m/s2", "2", 0.0, 1e-9, partial(beyond_the_grip, LAYOUTS[name]))
            for name in GRIP_TABLE
        ),
        Check("rear wheel lifts at, m/s2", "2", -4.42, 6e-3, partial(tipping, False)),
        Check("front wheels lift at, m/s2", "2", 17.1, 0.05, partial(tipping, True)),
        Check("forward grip with load transfer, m/s2", "4.1", 4.02788, 2e-5, forward_grip),
        Check("onset of slip from rest, A", "2", 2.02, 8e-3, slip_onset),
    ]  # fmt: skip
