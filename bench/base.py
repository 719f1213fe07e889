"""Our robot base, complete: the half of the picture that foreign firmware replaces, behind one call.

    Base.step(tick, rc_bytes, slamware_bytes, can_in) -> (can_out, slamware_out)

Decoders, link supervision, drive mapping, kinematics, speed loops, odometry and the SLAMWARE slave. What it knows of
its wheels it knows from decoded feedback frames; the truth is the world's.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from bench import rc_decode
from bench.config import Robot
from bench.controller import control_of
from bench.drive import DRIVER_CORE, Drive
from bench.kinematics import Kinematics, desaturate
from bench.link import RcLink
from bench.messages import TICK_US, BodyTwist, CanFrame
from bench.motors import motor_bus
from bench.odometry import odometry_of
from bench.reckoning import reckoning_of
from bench.slamware.omni_base import OmniMotion, slave_of, tells_rims

RC_PAUSE_US = 2000
"""Silence that ends an RC frame. Bytes carry the time of their tick, so two ticks are the least that can be told."""


class ControlledBase(Protocol):
    """The seam: anything that answers wires with wires can be the device under test."""

    def step(
        self, tick: int, rc_bytes: bytes, slamware_bytes: bytes, can_in: Sequence[CanFrame]
    ) -> tuple[tuple[CanFrame, ...], bytes]:
        """One millisecond: bytes and frames that arrived -> frames and bytes to send."""
        ...


class Base:
    """The bench's own base controller for one robot."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.kinematics = Kinematics(robot.wheels)
        self.motors = motor_bus(robot)
        self.reckoning = reckoning_of(robot, self.motors, self.kinematics, counts_rims=tells_rims(robot))
        self.odometry = self.reckoning.odometry if self.reckoning else odometry_of(robot, self.kinematics)
        self.drive = Drive(robot)
        self.inverse, self.controller = control_of(robot, self.kinematics, self._field_heading_rad)
        motion = OmniMotion(robot, self.kinematics, self.odometry, self.motors.silences, self.reckoning)
        self.slave = slave_of(robot, motion)
        profile = robot.rc
        self.rc_decoder = rc_decode.decoder(profile.protocol, pause_us=RC_PAUSE_US) if profile else None
        self.link = RcLink(profile, robot.link) if profile else None
        self._rc_pending = False  # a frame has begun: time alone may end it
        self.wanted_radps = [0.0] * len(robot.wheels)
        self.powered = False
        self._twist: BodyTwist | None = None  # the one that `wanted_radps` moves the base with
        self._slip_radps: tuple[float, ...] = ()  # and what a core wants of the wheels beyond it
        self._feedback_timeout = robot.link.feedback_timeout_ms

    @property
    def slip_radps(self) -> float:
        """By how much the driven wheels contradict dead wheels, or else each other (three cannot: 0)."""
        if self.reckoning is not None and self.robot.follows_dead_wheels:
            return self.reckoning.slip_radps
        return self.kinematics.slip_residual(self.motors.speeds_radps)

    def step(
        self, tick: int, rc_bytes: bytes, slamware_bytes: bytes, can_in: Sequence[CanFrame]
    ) -> tuple[tuple[CanFrame, ...], bytes]:
        """Decode, choose, control, encode; see the module's first lines. Never raises on what the wires bring."""
        motors = self.motors
        if self.reckoning is not None:
            self.reckoning.step(tick, can_in)
        else:
            increments_rad = motors.turned(tick, can_in)
            if increments_rad:
                self.odometry.advance(increments_rad)

        link, decoder = self.link, self.rc_decoder
        if decoder is not None and link is not None:
            if rc_bytes or self._rc_pending:
                link.step(tick, decoder.feed(rc_bytes, tick * TICK_US))
                self._rc_pending = decoder.pending
            elif tick >= link.review_tick:
                link.step(tick, ())
        slave = self.slave
        answer = slave.receive(slamware_bytes, tick) if slamware_bytes else b""

        core_alive = tick <= slave.last_alive_tick
        twist = self.drive.step(tick, link, slave.wanted_twist, core_alive, self.odometry.heading_rad)
        self.powered = twist is not None and tick - motors.quietest_tick < self._feedback_timeout
        if twist is None or not self.powered:
            self._twist = None
            self.wanted_radps = [0.0] * len(self.wanted_radps)
            self.controller.reset()
            return motors.stop(), answer
        woken: tuple[CanFrame, ...] = ()
        slip_radps = slave.wanted_slip_radps
        if slip_radps and self.drive.driver != DRIVER_CORE:
            slip_radps = ()
        if twist is not self._twist or slip_radps is not self._slip_radps:  # while cruising they are the same for long
            if self._twist is None:
                woken = motors.wake()
            self._twist, self._slip_radps = twist, slip_radps
            speeds_radps = self.inverse.wheel_speeds(twist)
            if slip_radps:
                speeds_radps = [speed + slip for speed, slip in zip(speeds_radps, slip_radps, strict=True)]
            self.wanted_radps = desaturate(speeds_radps, self.robot.limits.wheel_radps)
        commands = motors.command(self.controller.step(self.wanted_radps, motors.speeds_radps))
        return woken + commands if woken else commands, answer

    def _field_heading_rad(self) -> float:
        return self.drive.turned_rad(self.odometry.heading_rad)
