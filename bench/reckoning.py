"""Where a robot with more than driven wheels believes it is: the one place that chooses what odometry follows.

    displacement   three dead wheels or more, else the driven wheels
    heading        the gyro where there is one, else the same wheels

A source that has been silent for `feedback_timeout_ms` is done without until it speaks again: the driven wheels stand
in for dead wheels, the wheels for the gyro, and what was missed while waiting is made up from them. A robot that has
driven wheels alone needs none of this; its base feeds `Odometry` itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.config import EXACT, Robot
from bench.errors import UsageError
from bench.instruments import GyroBus, encoder_bus
from bench.kinematics import Kinematics
from bench.m2006 import MotorBus
from bench.messages import CanFrame
from bench.odometry import odometry_of

SLIP_WINDOW_TICKS = 10
"""A dead wheel's count in one tick is 0.8 rad/s, too coarse to hold against a motor's; in ten ticks it is a tenth."""
DRIVEN_WHEELS, DEAD_WHEELS, GYRO = "driven wheels", "dead wheels", "gyro"


class Reckoning:
    """The sources of one base and the odometry that follows them. `step` stands in the place of `motors.turned`.

    `turned_rad` counts what each driven wheel has turned, `dead_turned_rad` each dead wheel, since the first report.
    Raises UsageError where a printed form of odometry, which knows wheels alone, would have to follow a gyro.
    """

    __slots__ = (
        "_driven_kinematics",
        "_encoders",
        "_follows_dead_wheels",
        "_kinematics",
        "_motors",
        "_slip_mark",
        "_stood_in",
        "_timeout_ticks",
        "_unfollowed_rad",
        "_unfollowed_turn_rad",
        "_usual_ids",
        "_waiting_turn_rad",
        "dead_turned_rad",
        "gyro",
        "heading_source",
        "odometry",
        "slip_radps",
        "source",
        "turned_rad",
    )

    def __init__(self, robot: Robot, motors: MotorBus, kinematics: Kinematics) -> None:
        if robot.gyro is not None and robot.odometry != EXACT:
            raise UsageError(
                f"{robot.odometry}: a printed form takes its heading from wheels, and {robot.name} has a gyro; "
                "give a robot file without [gyro]"
            )
        dead = robot.dead_wheels
        self._motors = motors
        self._encoders = encoder_bus(robot) if dead else None
        self._follows_dead_wheels = robot.follows_dead_wheels
        self._driven_kinematics = kinematics
        self._kinematics = Kinematics(dead) if self._follows_dead_wheels else kinematics
        self.odometry = odometry_of(robot, self._kinematics)
        self.gyro = GyroBus(robot.gyro) if robot.gyro is not None else None
        encoders = self._encoders.feedback_ids if self._encoders is not None else ()
        self._usual_ids = [*motors.feedback_ids, *encoders, *([self.gyro.can_id] if self.gyro is not None else ())]
        self._timeout_ticks = robot.link.feedback_timeout_ms
        self._stood_in = False  # the driven wheels, for dead ones, since those were last heard
        # What the driven wheels turned since dead wheels were last followed, and any wheels since the gyro was.
        self._unfollowed_rad = [0.0] * len(robot.wheels)
        self._unfollowed_turn_rad = 0.0
        # What the gyro turned while wheels were waited for.
        self._waiting_turn_rad = 0.0
        self.turned_rad = [0.0] * len(robot.wheels)
        self.dead_turned_rad = [0.0] * len(dead)
        self._slip_mark = (0, self.turned_rad, self.dead_turned_rad)
        self.slip_radps = 0.0
        """How far the driven wheels were from the motion that dead wheels tell of: a length, over some 10 ms."""
        self.source = DEAD_WHEELS if self._follows_dead_wheels else DRIVEN_WHEELS
        """What the displacement comes from at present."""
        self.heading_source = self.source if self.gyro is None else GYRO

    def step(self, tick: int, frames: Sequence[CanFrame]) -> None:
        """Take the frames that arrived in this tick, and move by what they say."""
        of_motors = of_encoders = of_gyro = frames
        if [
            can_id for can_id, _ in frames
        ] == self._usual_ids:  # to each its own: who hears nobody else has an easy tick
            motors, others = len(self.turned_rad), len(self.turned_rad) + len(self.dead_turned_rad)
            of_motors, of_encoders, of_gyro = frames[:motors], frames[motors:others], frames[others:]
        driven_rad = self._motors.turned(tick, of_motors)
        if driven_rad:
            self.turned_rad = _sums(self.turned_rad, driven_rad)
        dead_rad = None
        if self._encoders is not None:
            dead_rad = self._encoders.turned(tick, of_encoders)
            if dead_rad and self._stood_in:
                dead_rad = []  # what the driven wheels stood in for must not be counted again
            elif dead_rad:
                self.dead_turned_rad = _sums(self.dead_turned_rad, dead_rad)
        followed_rad = self._choose(tick, driven_rad, dead_rad) if self._follows_dead_wheels else driven_rad
        if driven_rad == [] or dead_rad == []:  # motion was lost, and that is no slip
            self._slip_mark = (tick, self.turned_rad, self.dead_turned_rad)
        elif self._follows_dead_wheels and driven_rad and dead_rad and tick - self._slip_mark[0] >= SLIP_WINDOW_TICKS:
            self._measure_slip(tick)

        if self.gyro is not None:
            self._follow_gyro(tick, of_gyro, followed_rad)
        elif followed_rad:
            if self.source == DEAD_WHEELS or not self._follows_dead_wheels:
                self.odometry.advance(followed_rad)
            else:
                self.odometry.move(*self._driven_kinematics.fit(followed_rad))

    def _measure_slip(self, tick: int) -> None:
        since, driven_rad, dead_rad = self._slip_mark
        self._slip_mark = (tick, self.turned_rad, self.dead_turned_rad)
        moved = self._kinematics.fit([now - then for now, then in zip(self.dead_turned_rad, dead_rad, strict=True)])
        expected_rad = self._driven_kinematics.wheel_speeds(moved)
        total = 0.0
        for now, then, expected in zip(self.turned_rad, driven_rad, expected_rad, strict=True):
            slip = now - then - expected
            total += slip * slip
        self.slip_radps = math.sqrt(total) * 1000.0 / (tick - since)

    def _choose(self, tick: int, driven_rad: list[float] | None, dead_rad: list[float] | None) -> list[float] | None:
        """The increments to follow, of the wheels that `source` names from now on."""
        encoders, unfollowed_rad = self._encoders, self._unfollowed_rad
        assert encoders is not None
        if driven_rad:
            self._unfollowed_rad = unfollowed_rad = _sums(unfollowed_rad, driven_rad)
        if dead_rad:
            self.source = DEAD_WHEELS
        elif dead_rad is not None or encoders.silent_ticks(tick) >= self._timeout_ticks:
            self._stood_in = dead_rad is None and (self._stood_in or any(unfollowed_rad))
            self.source, dead_rad = DRIVEN_WHEELS, unfollowed_rad
        if dead_rad:
            self._unfollowed_rad = [0.0] * len(unfollowed_rad)
        return dead_rad

    def _follow_gyro(self, tick: int, frames: Sequence[CanFrame], followed_rad: list[float] | None) -> None:
        """Displacement from the wheels, heading from the gyro."""
        gyro = self.gyro
        assert gyro is not None
        ux_m = uy_m = 0.0
        if followed_rad:
            kinematics = self._kinematics if self.source == DEAD_WHEELS else self._driven_kinematics
            ux_m, uy_m, wheels_turn_rad = kinematics.fit(followed_rad)
            self._unfollowed_turn_rad += wheels_turn_rad
        seen = gyro.seen
        turn_rad = gyro.receive(tick, frames)
        if turn_rad is not None and tick - seen <= self._timeout_ticks:
            self.heading_source = GYRO
            self._unfollowed_turn_rad = 0.0
        elif turn_rad is not None or tick - seen >= self._timeout_ticks:
            self.heading_source = self.source
            turn_rad = self._unfollowed_turn_rad
            self._unfollowed_turn_rad = 0.0
        else:
            turn_rad = 0.0
        if followed_rad is None:
            self._waiting_turn_rad += turn_rad
        elif self._waiting_turn_rad:
            # The way was gone at the headings since then: in the mean, half of that turn further back.
            c, s = math.cos(0.5 * self._waiting_turn_rad), math.sin(0.5 * self._waiting_turn_rad)
            ux_m, uy_m = c * ux_m + s * uy_m, c * uy_m - s * ux_m
            self._waiting_turn_rad = 0.0
        self.odometry.move(ux_m, uy_m, turn_rad)


def reckoning_of(robot: Robot, motors: MotorBus, kinematics: Kinematics, *, counts_rims: bool) -> Reckoning | None:
    """The sources of this robot; None where its driven wheels are all there is and nobody asks what each has turned."""
    needed = counts_rims or robot.dead_wheels or robot.gyro is not None
    return Reckoning(robot, motors, kinematics) if needed else None


def _sums(totals: Sequence[float], more: Sequence[float]) -> list[float]:
    return [total + one for total, one in zip(totals, more, strict=True)]
