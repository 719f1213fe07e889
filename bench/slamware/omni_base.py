"""The SLAMWARE slave of an omni base, and its wheels as that asks about them: 0x31, 0x40, 0x41.

All out of odometry and kinematics, from decoded feedback frames, and only when a core asks. A wheel speed of 0x40 is a
rim speed, in the robot file's wheel order. What the wheels have in common is a body twist: it takes the way of every
other velocity, through arming, limits and ramp. On three wheels there is nothing else; on four, what is left over is
wheels working against each other, handed on beside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol

from bench.config import Robot
from bench.kinematics import Kinematics
from bench.odometry import Odometry
from bench.slamware.base_side import SlamwareBase
from bench.slamware.commands import DIALECTS
from bench.slamware.facts import facts_of
from bench.slamware.health import ERROR, MOTOR_CONTROLLER_DOWN, Fault
from bench.slamware.payloads import OMNI_MOTOR_DATA_BYTES, Displacement
from bench.slamware.reference_firmware import ReferenceFirmware
from bench.slamware.senses import Motion, Wanted

BEHAVIOURS: dict[str, type[SlamwareBase]] = {"strict": SlamwareBase, "as_reference_firmware": ReferenceFirmware}
SLIP_ABOVE_RADPS = 1e-9
"""Less is rounding."""


class RimCounter(Protocol):
    """Something that counts what each driven wheel has turned since the base was powered."""

    turned_rad: list[float]


def tells_rims(robot: Robot) -> bool:
    """Whether this robot's dialect tells a core how far each rim has rolled: counting costs something in every tick."""
    return DIALECTS[robot.slamware.dialect].motor_data_bytes == OMNI_MOTOR_DATA_BYTES


def slave_of(robot: Robot, motion: Motion) -> SlamwareBase:
    """The slave of a robot file, in the behaviour that it names; it senses nothing until it is given `senses`."""
    return BEHAVIOURS[robot.slamware.behaviour](facts_of(robot), motion, None, robot.link.core_timeout_ms)


class OmniMotion(Motion):
    """The wheels of one base. `silences(tick)` gives for each wheel how many ticks its motor has been quiet."""

    def __init__(
        self,
        robot: Robot,
        kinematics: Kinematics,
        odometry: Odometry,
        silences: Callable[[int], Sequence[int]],
        rims: RimCounter | None = None,
    ) -> None:
        self.wheel_count = len(robot.wheels)
        self._radii_m = [wheel.radius_m for wheel in robot.wheels]
        self._kinematics = kinematics
        self._odometry = odometry
        self._silences = silences
        self._rims = rims
        self._feedback_timeout_ticks = robot.link.feedback_timeout_ms
        self._mark = (0.0, 0.0, 0.0)

    def take_increment(self) -> Displacement:
        """Displacement since the last call."""
        return Displacement(*self._odometry.take_increment())

    def take_second_increment(self) -> Displacement:
        """The same with a mark of its own."""
        x0, y0, heading0 = self._mark
        x, y, _ = self._odometry.pose
        heading = self._odometry.heading_rad
        self._mark = (x, y, heading)
        c, s = math.cos(heading0), math.sin(heading0)
        return Displacement(c * (x - x0) + s * (y - y0), c * (y - y0) - s * (x - x0), heading - heading0)

    def rim_distances_m(self) -> Sequence[float]:
        """How far each rim has rolled since the base was powered, back and forth against each other."""
        if self._rims is None:  # nothing counts rims in a dialect that never tells them
            return super().rim_distances_m()
        turned = zip(self._rims.turned_rad, self._radii_m, strict=True)
        return tuple(turned_rad * radius_m for turned_rad, radius_m in turned)

    def follow_rims(self, speeds_mps: Sequence[float]) -> Wanted:
        """The twist that fits the rim speeds best, and what is left of each wheel's speed."""
        speeds_radps = [speed / radius_m for speed, radius_m in zip(speeds_mps, self._radii_m, strict=True)]
        slip = tuple(self._kinematics.slip(speeds_radps))
        disagree = any(abs(speed) > SLIP_ABOVE_RADPS for speed in slip)
        return Wanted(self._kinematics.twist(speeds_radps), slip if disagree else ())

    def faults(self, tick: int) -> Sequence[Fault]:
        """A motor that has gone quiet: controller down, the unit counting wheels from 0."""
        return [
            Fault(ERROR << 24 | MOTOR_CONTROLLER_DOWN | wheel, f"Motor {wheel + 1} is silent.")
            for wheel, silent in enumerate(self._silences(tick))
            if silent >= self._feedback_timeout_ticks
        ]
