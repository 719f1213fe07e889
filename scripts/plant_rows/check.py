"""One row of the table, the robots that the rows are about, and how they are driven open loop."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from bench.config import Robot, Wheel, load_robot
from bench.messages import BodyTwist
from bench.plant import STEP_S, Plant
from plant_rows.algebra import Vector

FORWARDS, SPIN = (1.0, 0.0, -1.0), (1.0, 1.0, 1.0)
SIN75, COS75 = math.sin(math.radians(75.0)), math.cos(math.radians(75.0))
G = 9.81
NO_LOSSES = {"motor_coulomb_nm": 0.0, "motor_viscous_nms": 0.0, "ground_rolling": 0.0}
FLAT = {"body_cog_height_m": 0.0}


@dataclass(frozen=True, slots=True)
class Check:
    """One row: what `measure` gives, off by no more than `allowed` from what is expected."""

    name: str
    section: str
    expected: float
    allowed: float
    measure: Callable[[], float]


def robot_with(wheels: Sequence[Wheel] = (), /, **changes: float) -> Robot:
    """The default robot without current lag, on these wheels; changes are named `table_key`."""
    robot = load_robot("m2006")
    for name, value in {"motor_current_lag_ms": 0.0, **changes}.items():
        table, key = name.split("_", 1)
        robot = replace(robot, **{table: replace(getattr(robot, table), **{key: value})})
    return replace(robot, wheels=tuple(wheels)) if wheels else robot


def tangential(*bearings_deg: float) -> list[Wheel]:
    """Omni wheels on the default robot's circle."""
    wheels = []
    for deg in bearings_deg:
        bearing = math.radians(deg)
        x_m, y_m = 0.061 * math.cos(bearing), 0.061 * math.sin(bearing)
        wheels.append(Wheel(f"at {deg}", x_m, y_m, bearing + math.pi / 2.0, 0.027, can_id=1))
    return wheels


def mecanum() -> list[Wheel]:
    """Rollers at 45 degrees."""
    corners = ((0.10, 0.12, -45.0), (0.10, -0.12, 45.0), (-0.10, 0.12, 45.0), (-0.10, -0.12, -45.0))
    return [Wheel("mecanum", x, y, 0.0, 0.03, can_id=1, roller_rad=math.radians(deg)) for x, y, deg in corners]


LAYOUTS: dict[str, list[Wheel]] = {
    "004": [],
    "omni 60/180/300": tangential(60.0, 180.0, 300.0),
    "omni 60/135/225/300": tangential(60.0, 135.0, 225.0, 300.0),
    "mecanum 45": mecanum(),
}


def rest_loads() -> tuple[float, float]:
    """Of a front wheel and the rear one: moments about the rear contact, and all of the weight."""
    n1 = 1.6 * G / (2.0 * (1.0 + COS75))
    return n1, 1.6 * G - 2.0 * n1


def run(plant: Plant, currents_a: Sequence[float], steps: int) -> Plant:
    """Steps with these currents."""
    for _ in range(steps):
        plant.step(currents_a)
    return plant


def times(signs: Sequence[float], current_a: float) -> list[float]:
    """A pattern of currents."""
    return [sign * current_a for sign in signs]


def driven(robot: Robot, currents_a: Sequence[float], steps: int) -> BodyTwist:
    """The twist after so many steps on an open floor."""
    return run(Plant(robot, None), currents_a, steps).twist


def first_step(robot: Robot, currents_a: Sequence[float]) -> Vector:
    """The acceleration of the first step from rest."""
    vx, vy, omega = driven(robot, currents_a, 1)
    return vx / STEP_S, vy / STEP_S, omega / STEP_S
