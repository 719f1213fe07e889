"""A run with a printed form in the place of the right one, on purpose: `--controller NAME`, `--odometry NAME`.

A form belongs to a layout of wheels. What a robot's wheels are is read from its kinematics: a wheel that feels the
line (ax, ay) with a moment about the origin is a tangential wheel at that distance, whatever its file calls it. Frames
and signs are turned here, so that a form fails by its own fault and by nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from bench.as_printed import document_001, document_004
from bench.config import Robot
from bench.controller import Controller, Inverse, SpeedController
from bench.errors import UsageError
from bench.kinematics import Kinematics
from bench.odometry import wrap

SAME_ANGLE_RAD = math.radians(0.01)
SAME_LENGTH = 1e-6


class Tangential(NamedTuple):
    """Tangential wheels: bearings counter-clockwise from forward, one distance and one radius for all."""

    bearings_rad: tuple[float, ...]
    distance_m: float
    radius_m: float
    clockwise: tuple[float, ...]
    """Times a speed in the wheel's own sense: the speed along its clockwise tangent."""


def tangential(kinematics: Kinematics) -> Tangential | None:
    """What this base is as a tangential one; None where its wheels differ in distance or radius."""
    rows, radii = kinematics.axes, kinematics.radii
    distance_m, radius_m = abs(rows[0][2]), radii[0]
    if any(abs(abs(moment) - distance_m) > SAME_LENGTH for _, _, moment in rows) or distance_m == 0.0:
        return None
    if any(abs(radius - radius_m) > SAME_LENGTH for radius in radii):
        return None
    bearings = tuple(wrap(math.atan2(ay, ax) - math.copysign(math.pi / 2, moment)) for ax, ay, moment in rows)
    return Tangential(bearings, distance_m, radius_m, tuple(-math.copysign(1.0, moment) for _, _, moment in rows))


def fitting(
    name: str, robot: Robot, kinematics: Kinematics, bearings_deg: Sequence[float] | None, count: int
) -> Tangential:
    """The layout of a base that a form can be used on. Raises UsageError with what the form is for."""
    found = tangential(kinematics)
    if found is not None and len(found.bearings_rad) == count:
        if bearings_deg is None:
            return found
        pairs = zip(found.bearings_rad, bearings_deg, strict=True)
        if all(abs(wrap(has - math.radians(wants))) < SAME_ANGLE_RAD for has, wants in pairs):
            return found
    at = "" if bearings_deg is None else f" at {', '.join(f'{bearing:g}' for bearing in bearings_deg)} degrees"
    raise UsageError(
        f"{name}: is for {count} tangential wheels of one size{at}, in this order, and {robot.name} has others; "
        "give another --robot (`wheelbench robots` lists them)"
    )


class CurrentAsPrinted:
    """Document 004: current proportional to the wanted wheel speed, whatever the wheel does. Row 26."""

    __slots__ = ("_max_a", "_max_radps")

    def __init__(self, robot: Robot) -> None:
        self._max_radps = robot.limits.wheel_radps
        self._max_a = robot.limits.current_a

    def step(self, wanted_radps: Sequence[float], measured_radps: Sequence[float]) -> list[float]:
        """Currents for this tick."""
        return [document_004.current_as_printed(wanted, self._max_radps, self._max_a) for wanted in wanted_radps]

    def reset(self) -> None:
        """There is nothing to forget."""


class Inverse004AsPrinted:
    """Document 004: rows (sin, cos, L), radial where they have to be tangential. Row 22."""

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        self._layout = fitting("inverse-004-as-printed", robot, kinematics, None, 3)

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s."""
        vx, vy, omega = twist
        bearings, distance_m, radius_m, clockwise = self._layout
        printed = document_004.inverse_as_printed(-vy, vx, -omega, bearings, distance_m, radius_m)
        return [sign * speed for sign, speed in zip(clockwise, printed, strict=True)]


class FourWheels001AsPrinted:
    """Document 001, four omni wheels, the compact code: the third wheel's angle is another robot's. Row 11."""

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        bearings_deg = document_001.BEARINGS_4_DEG
        self._layout = fitting("document-001-four-as-printed", robot, kinematics, bearings_deg, len(bearings_deg))

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s; a field-centric command has been turned before, so the heading is 0 here."""
        vx, vy, omega = twist
        _, distance_m, radius_m, clockwise = self._layout
        printed = document_001.four_wheels_as_printed(-vy, vx, distance_m * omega, 0.0)
        return [sign * speed / radius_m for sign, speed in zip(clockwise, printed, strict=True)]


class Mecanum001AsPrinted:
    """Document 001, mecanum wheels: translation comes out times cos 45, rotation does not. Row 12."""

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        root2 = math.sqrt(2.0)
        rows = [(root2 * ax, root2 * ay, root2 * moment) for ax, ay, moment in kinematics.axes]
        self._lever_m = -rows[0][2]
        self._radius_m = root2 * kinematics.radii[0]
        wanted = [(1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
        fits = len(rows) == len(wanted) and all(
            math.dist(row, (x, y, -self._lever_m)) < SAME_LENGTH for row, (x, y) in zip(rows, wanted, strict=True)
        )
        if not fits or any(abs(radius - kinematics.radii[0]) > SAME_LENGTH for radius in kinematics.radii):
            raise UsageError(
                "document-001-mecanum-as-printed: is for four mecanum wheels of one size (front left, front right, "
                f"rear right, rear left, the right side mirrored), and {robot.name} has others; try --robot mecanum"
            )

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s."""
        vx, vy, omega = twist
        printed = document_001.mecanum_as_printed(-vy, vx, self._lever_m * omega, 0.0)
        return [speed / self._radius_m for speed in printed]


def control_as_printed(robot: Robot, kinematics: Kinematics) -> tuple[Inverse, Controller]:
    """The printed form that `control.kind` names: of the wheel speeds, or of the currents. Raises UsageError."""
    match robot.control.kind:
        case "current-as-printed":
            return kinematics, CurrentAsPrinted(robot)
        case "inverse-004-as-printed":
            return Inverse004AsPrinted(robot, kinematics), SpeedController(robot)
        case "document-001-four-as-printed":
            return FourWheels001AsPrinted(robot, kinematics), SpeedController(robot)
        case "document-001-mecanum-as-printed":
            return Mecanum001AsPrinted(robot, kinematics), SpeedController(robot)
    raise ValueError(f"no printed form of control is called {robot.control.kind!r}")
