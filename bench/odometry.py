"""Wheel increments -> where the robot believes it is, exactly on SE(2).

Between two samples the twist is taken as constant, so the body increment is carried by the exponential map: no Euler
error that hides in closed circles and shows in quarter turns (kinematics reference, section 4). The heading is summed
without wrapping inside, so that increments over any time are right, and wrapped where it is shown.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.config import EXACT, Robot
from bench.kinematics import Kinematics
from bench.messages import Pose

SERIES_BELOW_RAD = 1e-4
"""Below this turn sin(t)/t and (1 - cos t)/t are taken from their series; the quotients lose digits there."""


def wrap(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    if -math.pi < angle_rad <= math.pi:
        return angle_rad
    wrapped = math.remainder(angle_rad, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def exponential(ux: float, uy: float, dtheta: float) -> tuple[float, float]:
    """Displacement, in the frame at the start, of a body that moves for one unit with a constant twist."""
    if -SERIES_BELOW_RAD < dtheta < SERIES_BELOW_RAD:
        s = 1.0 - dtheta * dtheta / 6.0
        c = dtheta * 0.5 - dtheta * dtheta * dtheta / 24.0
    else:
        s = math.sin(dtheta) / dtheta
        c = (1.0 - math.cos(dtheta)) / dtheta
    return s * ux - c * uy, c * ux + s * uy


def compose(pose: Sequence[float], increment: Sequence[float]) -> Pose:
    """The pose after a body-frame increment (constant twist): pose o exp(increment). The heading is wrapped."""
    x_m, y_m, heading_rad = pose
    dx, dy = exponential(*increment)
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return Pose(x_m + c * dx - s * dy, y_m + s * dx + c * dy, wrap(heading_rad + increment[2]))


class Odometry:
    """Dead reckoning from wheel increments (rad, wheel order): a pose since boot, and displacements since a mark."""

    __slots__ = ("_kinematics", "_mark", "_x_m", "_y_m", "heading_rad")

    def __init__(self, kinematics: Kinematics) -> None:
        self._kinematics = kinematics
        self._x_m = self._y_m = 0.0
        self.heading_rad = 0.0
        """Since boot, not wrapped."""
        self._mark = (0.0, 0.0, 0.0)

    def advance(self, increments_rad: Sequence[float]) -> None:
        """Move by what the wheels turned since the last call."""
        if any(increments_rad):
            ux, uy, dtheta = self._kinematics.fit(increments_rad)
            self.move(ux, uy, dtheta)

    def move(self, ux: float, uy: float, dtheta: float) -> None:
        """Move by a body increment (m, m, rad), taken as one constant twist."""
        heading_rad = self.heading_rad
        dx, dy = exponential(ux, uy, dtheta)
        c, s = math.cos(heading_rad), math.sin(heading_rad)
        self._x_m += c * dx - s * dy
        self._y_m += s * dx + c * dy
        self.heading_rad = heading_rad + dtheta

    @property
    def pose(self) -> Pose:
        """Pose since boot, in the frame in which the robot stood at boot."""
        return Pose(self._x_m, self._y_m, wrap(self.heading_rad))

    def take_increment(self) -> tuple[float, float, float]:
        """Displacement (m, m, rad) since the last call, in the robot's frame as it stood then."""
        x0, y0, heading0 = self._mark
        self._mark = (self._x_m, self._y_m, self.heading_rad)
        c, s = math.cos(heading0), math.sin(heading0)
        dx, dy = self._x_m - x0, self._y_m - y0
        return c * dx + s * dy, c * dy - s * dx, self.heading_rad - heading0


def odometry_of(robot: Robot, kinematics: Kinematics) -> Odometry:
    """The odometry that a robot's file or a run asks for, over the wheels that `kinematics` is of.

    Raises UsageError where a printed form is not for this robot.
    """
    if robot.odometry == EXACT:
        return Odometry(kinematics)
    from bench.as_printed.choices import odometry_as_printed

    return odometry_as_printed(robot, kinematics)
