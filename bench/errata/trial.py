"""Runs of the plant with a printed form in them.

`settled` closes a robot's control over the plant alone, which is quick; `drive` runs the whole bench, bytes and all,
with the SLAMWARE core at the wheel.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from bench.base import Base
from bench.config import Robot, load_robot, with_choices
from bench.controller import control_of
from bench.kinematics import Kinematics, desaturate
from bench.loop import simulated
from bench.messages import ZERO_TWIST, BodyTwist, Pose, TickInput
from bench.odometry import wrap
from bench.plant import STEP_S, Plant

LONGEST_TICKS = 20_000
RAMP_TICKS = 500
SETTLED_TICKS = 4000
"""Nine time constants of the slowest of our robots, the M2006 robot rolling freely."""


def robot_for(name: str, *, controller: str | None = None, odometry: str | None = None) -> Robot:
    """One of our robots, driven by a core alone, with these choices."""
    return with_choices(replace(load_robot(name), rc=None), controller, odometry)


def settled(robot: Robot, twist: BodyTwist, ticks: int = SETTLED_TICKS, start: BodyTwist = ZERO_TWIST) -> Plant:
    """The plant on open floor after so many milliseconds of this wanted twist, rolling with `start` at first."""
    inverse, controller = control_of(robot, Kinematics(robot.wheels))
    plant = Plant(robot, arena=None, twist=start)
    wanted = desaturate(inverse.wheel_speeds(twist), robot.limits.wheel_radps)
    for _ in range(ticks):
        plant.step(controller.step(wanted, plant.wheel_speeds_radps))
    return plant


def pushed(robot: Robot, currents_a: Sequence[float], ticks: int) -> BodyTwist:
    """How the plant moves after so many milliseconds of these currents, from rest."""
    plant = Plant(robot, arena=None)
    for _ in range(ticks):
        plant.step(currents_a)
    return plant.twist


def field_centric(
    robot: Robot, wheels: Callable[[float], Sequence[float]], ticks: int, heading_rad: float, gyro_rad: float
) -> tuple[Pose, float]:
    """Drive by wheel speeds, rad/s, that follow a gyroscope: (pose in the field, angle turned in rad, not wrapped).

    They are ramped up, so that no limit of the current bends the way. The robot starts at a heading that the gyroscope
    calls `gyro_rad`; from there on it accumulates.
    """
    _, controller = control_of(robot, Kinematics(robot.wheels))
    plant = Plant(robot, arena=None, pose=Pose(0.0, 0.0, heading_rad))
    turned_rad = 0.0
    for tick in range(ticks):
        share = min(1.0, tick / RAMP_TICKS)
        asked = [share * speed for speed in wheels(gyro_rad + turned_rad)]
        wanted = desaturate(asked, robot.limits.wheel_radps)
        plant.step(controller.step(wanted, plant.wheel_speeds_radps))
        turned_rad += plant.twist.omega_radps * STEP_S
    return plant.pose, turned_rad


class Driven(NamedTuple):
    """A run from rest: what happened, and what the base believes."""

    pose: Pose
    turned_rad: float
    """Truth, not wrapped."""
    path_m: float
    believed: Pose
    believed_turned_rad: float
    believed_path_m: float


def drive(robot: Robot, twist: BodyTwist, *, ticks: int = LONGEST_TICKS, turn_rad: float = math.inf) -> Driven:
    """The whole bench, its core asking for this twist, for so many ticks or until the robot has turned so far."""
    bench = simulated(robot)
    assert isinstance(bench.base, Base)
    plant, odometry = bench.world.plant, bench.base.odometry
    given = TickInput(core_twist=twist)
    pose, believed = plant.pose, odometry.pose
    turned_rad = path_m = believed_path_m = 0.0
    for _ in range(ticks):
        bench.tick(given)
        before, pose = pose, plant.pose
        turned_rad += wrap(pose.heading_rad - before.heading_rad)
        path_m += math.dist(pose[:2], before[:2])
        before, believed = believed, odometry.pose
        believed_path_m += math.dist(believed[:2], before[:2])
        if abs(turned_rad) >= turn_rad:
            break
    return Driven(pose, turned_rad, path_m, believed, odometry.heading_rad, believed_path_m)
