"""Dead wheels and gyro, both ends of their wire: the true motion in, CAN frames between, increments out.

Dead wheels carry nothing and drive nothing: they turn with the ground, phi_dot = a . (v + omega x p) / r, whatever the
driven wheels do. Their encoder boards report as ESCs without motors do, so both ends of that wire are those of
`m2006`, with the dead wheels in the motors' place. The gyro has a frame of its own, in `canbus.instruments`.

`Instruments` is the world's end; `encoder_bus` and `GyroBus` are the base's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from bench.canbus.instruments import HEADING_COUNTS, RATE_PER_RADPS, gyro
from bench.config import Gyro, Robot
from bench.kinematics import Row, speed_rows
from bench.m2006 import EmulatedEscs, MotorBus
from bench.messages import TICK_US, CanFrame, Pose
from bench.unwrap import ByShorterWay

STEP_S = TICK_US / 1e6
_HALF_TURN = HEADING_COUNTS // 2
_COUNTS_PER_RAD = HEADING_COUNTS / math.tau
_RAD_PER_COUNT = math.tau / HEADING_COUNTS
_MOST_RAW = 32767


class Placed(Protocol):
    """Something that knows where the robot really is."""

    @property
    def pose(self) -> Pose:
        """In the field."""
        ...


# --- the base's end ----------------------------------------------------------------------------------------------


def encoder_bus(robot: Robot) -> MotorBus:
    """The encoder boards as the base hears them, in the order of the dead wheels. It has nobody to command."""
    return MotorBus(_dead_wheels_as_motors(robot), unwrap=ByShorterWay(robot.dead_wheels))


class GyroBus:
    """The base's end of a gyro: `rate_radps` as last reported, `turned_rad` since the first report, not wrapped."""

    __slots__ = (
        "_heading_raw",
        "_layout",
        "_length",
        "can_id",
        "malformed_frames",
        "rate_radps",
        "seen",
        "turned_rad",
    )

    def __init__(self, settings: Gyro) -> None:
        message = gyro(settings.can_id)
        self.can_id = message.can_id
        self._layout = message.layout
        self._length = message.length
        self._heading_raw: int | None = None
        self.rate_radps = 0.0
        self.turned_rad = 0.0
        self.seen = -1
        """The tick of the last report."""
        self.malformed_frames = 0

    def receive(self, tick: int, frames: Sequence[CanFrame]) -> float | None:
        """What it has turned since the report before, in rad, the shorter way round; None where none arrived."""
        turn_rad = None
        for can_id, data in frames:
            if can_id != self.can_id:
                continue
            if len(data) != self._length:
                self.malformed_frames += 1
                continue
            rate_raw, heading_raw = self._layout.unpack(data)
            last = self._heading_raw
            self._heading_raw = heading_raw
            self.rate_radps = rate_raw / RATE_PER_RADPS
            self.seen = tick
            # The first sample only sets the reference.
            counts = 0 if last is None else (heading_raw - last + _HALF_TURN) % HEADING_COUNTS - _HALF_TURN
            turn_rad = (turn_rad or 0.0) + counts * _RAD_PER_COUNT
        if turn_rad is not None:
            self.turned_rad += turn_rad
        return turn_rad


# --- the world's end ---------------------------------------------------------------------------------------------


class PassiveWheels:
    """Angles (rad, since the start, not wrapped) and speeds (rad/s) of a robot's dead wheels, from where it really is.

    Both are new lists with every step. They follow the body, so a wall that holds it holds them too.
    """

    __slots__ = ("_pose", "_rows", "angles_rad", "speeds_radps", "turn_rad")

    def __init__(self, robot: Robot, pose: Pose) -> None:
        self._rows: tuple[Row, ...] = speed_rows(robot.dead_wheels)
        self._pose = pose
        self.angles_rad = [0.0] * len(self._rows)
        self.speeds_radps = [0.0] * len(self._rows)
        self.turn_rad = 0.0
        """By how much the body has turned in the last step."""

    def follow(self, pose: Pose) -> None:
        """Turn with a body that is at `pose` now, one step after the last call."""
        x_m, y_m, heading_rad = self._pose
        self._pose = pose
        dx_m, dy_m = pose.x_m - x_m, pose.y_m - y_m
        self.turn_rad = turn_rad = math.remainder(pose.heading_rad - heading_rad, math.tau)
        # Half way through the step the robot's frame looks along the chord of its arc.
        heading_rad += 0.5 * turn_rad
        c, s = math.cos(heading_rad), math.sin(heading_rad)
        ux_m, uy_m = c * dx_m + s * dy_m, c * dy_m - s * dx_m
        steps_rad = [hx * ux_m + hy * uy_m + hw * turn_rad for hx, hy, hw in self._rows]
        self.angles_rad = [angle + step for angle, step in zip(self.angles_rad, steps_rad, strict=True)]
        self.speeds_radps = [step / STEP_S for step in steps_rad]


class EmulatedGyro:
    """Reports rate and sum of what a body turns, with the bias and the noise of its settings."""

    __slots__ = ("_bias_radps", "_can_id", "_noise", "_noise_radps", "_pack", "turned_rad")

    def __init__(self, settings: Gyro) -> None:
        message = gyro(settings.can_id)
        self._can_id, self._pack = message.can_id, message.layout.pack
        self._bias_radps, self._noise_radps = settings.bias_radps, settings.rate_noise_radps
        self._noise = NormalNumbers(settings.seed)
        self.turned_rad = 0.0
        """What it believes to have turned since power-up."""

    def report(self, turn_rad: float) -> CanFrame:
        """The frame after a step in which the body turned so far."""
        rate_radps = turn_rad / STEP_S + self._bias_radps
        if self._noise_radps:
            rate_radps += self._noise_radps * self._noise.next()
        self.turned_rad += rate_radps * STEP_S
        rate_raw = max(-_MOST_RAW, min(_MOST_RAW, round(rate_radps * RATE_PER_RADPS)))
        return self._can_id, self._pack(rate_raw, math.floor(self.turned_rad * _COUNTS_PER_RAD) % HEADING_COUNTS)


class NormalNumbers:
    """Of mean 0 and deviation 1, to 6 deviations: twelve even ones added up. The same everywhere.

    The even ones are the upper bits of Knuth's 64-bit congruential generator (MMIX). `bench.noise` draws by another;
    neither can take the other's place, because a recording runs again only from the numbers that it was made with.
    """

    __slots__ = ("_state",)

    def __init__(self, seed: int) -> None:
        self._state = seed % (1 << 64)

    def next(self) -> float:
        """The next one."""
        state = self._state
        total = 0
        for _ in range(12):
            state = (6364136223846793005 * state + 1442695040888963407) % (1 << 64)
            total += state >> 32
        self._state = state
        return total / (1 << 32) - 6.0


class Instruments:
    """The dead wheels and the gyro of one robot in the world. One `step` after each of the plant's."""

    def __init__(self, robot: Robot, plant: Placed) -> None:
        self._plant = plant
        self._wheels = PassiveWheels(robot, plant.pose)
        self._boards = EmulatedEscs(_dead_wheels_as_motors(robot)) if robot.dead_wheels else None
        self._currents_a = [0.0] * len(robot.dead_wheels)
        self._gyro = EmulatedGyro(robot.gyro) if robot.gyro is not None else None

    @property
    def dead_wheel_angles_rad(self) -> list[float]:
        """What the dead wheels have really turned since the start."""
        return self._wheels.angles_rad

    def step(self) -> tuple[CanFrame, ...]:
        """Follow the body; one frame of each encoder board and of the gyro."""
        wheels = self._wheels
        wheels.follow(self._plant.pose)
        frames: tuple[CanFrame, ...] = ()
        if self._boards is not None:
            frames = self._boards.feedback(wheels.angles_rad, wheels.speeds_radps, self._currents_a)
        return frames if self._gyro is None else (*frames, self._gyro.report(wheels.turn_rad))


def instruments_of(robot: Robot, plant: Placed) -> Instruments | None:
    """What this robot carries besides its driven wheels; None where that is nothing."""
    return Instruments(robot, plant) if robot.dead_wheels or robot.gyro is not None else None


def _dead_wheels_as_motors(robot: Robot) -> Robot:
    """The robot with driven and dead wheels in each other's place, for the ends of a wire that is an ESC's."""
    return replace(robot, wheels=robot.dead_wheels, dead_wheels=robot.wheels)
