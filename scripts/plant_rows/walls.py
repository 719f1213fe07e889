"""Walls: how hard a stalled robot pushes, and what is left of its motion after an impact."""

from __future__ import annotations

from bench.arena import Arena
from bench.messages import BodyTwist, Pose
from bench.plant import Plant
from plant_rows.check import FLAT, FORWARDS, SIN75, Check, robot_with, run, times

ROOM = Arena(1.0, 0.8)


def stall(current_a: float, **changes: float) -> Plant:
    """The robot after 0.6 s against a wall."""
    plant = Plant(robot_with(ground_rolling=0.0, **changes), ROOM, Pose(0.415, 0.0, 0.0))
    return run(plant, times(FORWARDS, current_a), 600)


def beyond_the_band() -> float:
    """How far the stall force at 1 A lies outside of 2 sin 75/r (Kt i -+ tau_c)."""
    force = -stall(1.0, ground_grip=2.0, **FLAT).wall_force_n[0]
    least, most = (2.0 * SIN75 / 0.027 * (0.18 + sign * 0.020) for sign in (-1.0, 1.0))
    return max(0.0, least - force, force - most)


def creep() -> float:
    """The fastest wheel of a robot stalled below its grip."""
    return max(map(abs, stall(1.0, ground_grip=2.0).wheel_speeds_radps))


def impact(restitution: float, steps: int) -> Plant:
    """The robot so many steps after it stood 0.43 mm before a wall at 0.83 m/s."""
    start, speed = Pose(0.41957, 0.0, 0.0), BodyTwist(0.83, 0.0, 0.0)
    return run(
        Plant(robot_with(**FLAT), Arena(1.0, 0.8, restitution=restitution), start, speed), (0.0, 0.0, 0.0), steps
    )


def rows() -> list[Check]:
    """In the order of the page."""
    return [
        Check("stall at 1 A outside of 11.45 to 14.31 N, N", "3.3", 0.0, 1e-9, beyond_the_band),
        Check("stall above the grip, N", "2", 8.43, 5e-3, lambda: -stall(1.0, **FLAT).wall_force_n[0]),
        Check("stalled below the grip, wheel speed, rad/s", "3.3", 0.0, 0.0, creep),
        Check("stop at 0.83 m/s, wheels, rad/s", "3.3", 29.7, 0.1, lambda: impact(0.0, 1).wheel_speeds_radps[0]),
        Check("the same 100 ms later, rad/s", "3.3", 10.9, 0.15, lambda: impact(0.0, 101).wheel_speeds_radps[0]),
        Check("rebound at elasticity 0.5, m/s", "3.3", -0.415, 1e-3, lambda: impact(0.5, 1).twist.vx_mps),
        Check("the same 100 ms later, m/s", "3.3", 0.12, 5e-3, lambda: impact(0.5, 101).twist.vx_mps),
    ]
