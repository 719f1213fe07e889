"""Robots for tests: the default one and other layouts on the same body and motors, with any parameter changed."""

import math
from dataclasses import replace

from bench.config import Robot, Wheel, load_robot


def m2006(**changes) -> Robot:
    """The default robot without current lag; changes are named `table_key`, such as `ground_grip=0.15`."""
    robot = load_robot("m2006")
    for name, value in {"motor_current_lag_ms": 0.0, **changes}.items():
        table, key = name.split("_", 1)
        robot = replace(robot, **{table: replace(getattr(robot, table), **{key: value})})
    return robot


def tangential(bearing_deg: float, distance_m: float = 0.061, radius_m: float = 0.027) -> Wheel:
    bearing = math.radians(bearing_deg)
    x_m, y_m = distance_m * math.cos(bearing), distance_m * math.sin(bearing)
    return Wheel(f"at {bearing_deg}", x_m, y_m, bearing + math.pi / 2, radius_m, can_id=1)


def omni3(**changes) -> Robot:
    """Three wheels, 120 degrees apart."""
    return replace(m2006(**changes), wheels=tuple(map(tangential, (60.0, 180.0, 300.0))))


def omni4(**changes) -> Robot:
    """Four wheels at 60, 135, 225 and 300 degrees."""
    return replace(m2006(**changes), wheels=tuple(map(tangential, (60.0, 135.0, 225.0, 300.0))))


def mecanum(**changes) -> Robot:
    """Four wheels that push forward, rollers at 45 degrees: front left, front right, rear left, rear right."""
    corners = ((0.10, 0.12, -45.0), (0.10, -0.12, 45.0), (-0.10, 0.12, 45.0), (-0.10, -0.12, -45.0))
    wheels = tuple(Wheel("mecanum", x, y, 0.0, 0.03, can_id=1, roller_rad=math.radians(g)) for x, y, g in corners)
    return replace(m2006(**changes), wheels=wheels)


def dead_wheels(*bearings_deg: float, distance_m: float = 0.1, first_can_id: int = 4) -> tuple[Wheel, ...]:
    """Passive wheels as document 002 has them, counted at the axle."""
    wheels = (tangential(bearing, distance_m, 0.025) for bearing in bearings_deg or (0.0, 120.0, 240.0))
    return tuple(
        replace(wheel, name=f"dead {number}", can_id=number, gear=1.0)
        for number, wheel in enumerate(wheels, first_can_id)
    )
