"""Which motors a robot has: the messages of their kind, and both ends of their wire. `motor.kind` in the robot file."""

from __future__ import annotations

from bench.canbus import c610, dm3519
from bench.canbus.instruments import with_instruments
from bench.canbus.table import Family
from bench.config import Dm3519, Robot
from bench.dm3519 import Dm3519Bus, EmulatedDm3519s
from bench.m2006 import EmulatedEscs, MotorBus


def family(robot: Robot) -> Family:
    """The messages on this robot's motor bus: its motors', its dead wheels' and its gyro's."""
    known = dm3519_family(robot.dm3519) if robot.dm3519 is not None else c610.FAMILY
    if not robot.dead_wheels and robot.gyro is None:
        return known
    encoders = tuple(wheel.can_id for wheel in robot.dead_wheels)
    return with_instruments(known, encoders, robot.gyro.can_id if robot.gyro is not None else None)


def dm3519_family(chosen: Dm3519) -> Family:
    """The variant that a robot file has chosen."""
    return dm3519.family(chosen.full_scale_a, chosen.feedback, chosen.clear_error)


def motor_bus(robot: Robot) -> MotorBus:
    """The base's end."""
    return Dm3519Bus(robot, dm3519_family(robot.dm3519)) if robot.dm3519 is not None else MotorBus(robot)


def emulated_escs(robot: Robot) -> EmulatedEscs:
    """The motors' end."""
    return EmulatedDm3519s(robot, dm3519_family(robot.dm3519)) if robot.dm3519 is not None else EmulatedEscs(robot)
