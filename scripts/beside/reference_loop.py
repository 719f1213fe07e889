"""The bench's closed loop as one would build it from libraries: the fair reference of scripts/benchmark.py.

python-can's virtual bus with a `can.Message` for every frame, cantools for every field by a DBC, python-can's candump
writer as recorder, and plain Python for sticks, kinematics and the speed loop. The plant is the bench's own, and so is
the RC decoder: neither library has one. Each tick has the same four CAN frames as the bench's, bit for bit (a test
holds it to that), and they are really encoded, sent, received and decoded.

Nothing in it is slow on purpose. Messages are looked up once; cantools is spared scaling, range checks and choices;
each side receives exactly as many frames as were sent, and never waits. It leaves out what the bench does besides, all
in its own favour: odometry, the SLAMWARE bus with its core, link supervision, the hand-over, field-centric driving,
refusing damaged frames, state.csv, rc.log and slamware.log.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import can
import cantools

from bench import rc_decode
from bench.config import Axis, Robot
from bench.messages import RcFrame
from bench.plant import Plant

CHANNEL = "reference loop"
COMMAND_ID, FEEDBACK_ID = 0x200, 0x200
COUNTS = 8192
DT_S = 0.001


def _feedback_dbc(esc: int) -> str:
    return f"""
BO_ {FEEDBACK_ID + esc} Feedback{esc}: 8 Esc
 SG_ Angle : 7|16@0+ (1,0) [0|8191] "" Base
 SG_ Speed : 23|16@0- (1,0) [-32768|32767] "rpm" Base
 SG_ Current : 39|16@0- (1,0) [-32768|32767] "mA" Base
"""


DBC = f"""VERSION ""
NS_ :
BS_:
BU_: Base Esc

BO_ {COMMAND_ID} Command: 8 Base
 SG_ I1 : 7|16@0- (1,0) [-10000|10000] "mA" Esc
 SG_ I2 : 23|16@0- (1,0) [-10000|10000] "mA" Esc
 SG_ I3 : 39|16@0- (1,0) [-10000|10000] "mA" Esc
 SG_ I4 : 55|16@0- (1,0) [-10000|10000] "mA" Esc
{_feedback_dbc(1)}{_feedback_dbc(2)}{_feedback_dbc(3)}"""


class LibraryLoop:
    """Base, bus, ESCs and plant of one three-wheel robot, ticked together. A context manager: it owns two buses."""

    def __init__(self, robot: Robot, log_file: Path) -> None:
        database = cantools.database.load_string(DBC, database_format="dbc")
        self.log = can.CanutilsLogWriter(log_file, channel="can0")
        options: dict[str, Any] = {"interface": "virtual", "channel": CHANNEL, "preserve_timestamps": True}
        self.base_bus = can.Bus(**options)
        self.esc_bus = can.Bus(**options)
        self.base = LibraryBase(robot, database, self.base_bus, self.log)
        self.escs = LibraryEscs(robot, database, self.esc_bus, self.log)
        self.now_tick = 0

    def tick(self, rc_bytes: bytes) -> None:
        """One millisecond."""
        tick = self.now_tick
        self.base.tick(tick, rc_bytes)
        self.escs.tick(tick)
        self.now_tick = tick + 1

    def __enter__(self) -> LibraryLoop:
        return self

    def __exit__(self, *_: object) -> None:
        self.log.stop()
        self.base_bus.shutdown()
        self.esc_bus.shutdown()


class LibraryEscs:
    """Three ESCs and the plant: one command frame in, three feedback frames out."""

    def __init__(self, robot: Robot, database: Any, bus: can.BusABC, log: can.CanutilsLogWriter) -> None:
        self.bus, self.log = bus, log
        self.command = database.get_message_by_frame_id(COMMAND_ID)
        self.reports = [database.get_message_by_frame_id(FEEDBACK_ID + wheel.can_id) for wheel in robot.wheels]
        self.wheels = robot.wheels
        self.plant = Plant(robot)
        self.rpm = [0.0] * len(robot.wheels)
        self.filter = 1.0 - math.exp(-1.0 / robot.motor.speed_filter_ms)

    def tick(self, tick: int) -> None:
        """Receive, move, report."""
        received = self.bus.recv(timeout=0)
        assert received is not None
        values = self.command.decode(received.data, decode_choices=False, scaling=False)
        currents_ma = [values[f"I{wheel.can_id}"] * wheel.direction for wheel in self.wheels]
        plant = self.plant
        plant.step([current / 1000.0 for current in currents_ma])
        for i, (wheel, message) in enumerate(zip(self.wheels, self.reports, strict=True)):
            rotor = wheel.direction * wheel.gear
            rpm = plant.wheel_speeds_radps[i] * rotor * 30.0 / math.pi
            self.rpm[i] += self.filter * (rpm - self.rpm[i])
            fields = {
                "Angle": math.floor(plant.wheel_angles_rad[i] * rotor * COUNTS / (2.0 * math.pi)) % COUNTS,
                "Speed": round(self.rpm[i]),
                "Current": round(plant.currents_a[i] * wheel.direction * 1000.0),
            }
            _send(self.bus, self.log, tick, message, fields)


class LibraryBase:
    """Sticks -> twist -> wheel speeds -> PI -> one command frame, from the three feedback frames of the last tick."""

    def __init__(self, robot: Robot, database: Any, bus: can.BusABC, log: can.CanutilsLogWriter) -> None:
        profile = robot.rc
        assert profile is not None
        assert profile.aux1 is not None
        self.robot, self.profile, self.aux1 = robot, profile, profile.aux1
        self.bus, self.log = bus, log
        self.command = database.get_message_by_frame_id(COMMAND_ID)
        self.reports = {
            FEEDBACK_ID + w.can_id: database.get_message_by_frame_id(FEEDBACK_ID + w.can_id) for w in robot.wheels
        }
        self.index = {FEEDBACK_ID + wheel.can_id: i for i, wheel in enumerate(robot.wheels)}
        self.decoder = rc_decode.decoder(profile.protocol, pause_us=2000)
        self.angles: list[int | None] = [None] * len(robot.wheels)
        self.speeds = [0.0] * len(robot.wheels)
        self.integral = [0.0] * len(robot.wheels)
        self.armed = False
        self.pressed: bool | None = None
        self.wanted = (0.0, 0.0, 0.0)
        self.twist = (0.0, 0.0, 0.0)
        self.rows = []
        for wheel in robot.wheels:
            ax, ay = math.cos(wheel.heading_rad), math.sin(wheel.heading_rad)
            arm = wheel.x_m * ay - wheel.y_m * ax
            self.rows.append((ax / wheel.radius_m, ay / wheel.radius_m, arm / wheel.radius_m))

    def tick(self, tick: int, rc_bytes: bytes) -> None:
        """Receive, decide, command."""
        if tick:
            for _ in self.angles:
                received = self.bus.recv(timeout=0)
                assert received is not None
                self._take_feedback(received)
        if rc_bytes or self.decoder.pending:
            for event in self.decoder.feed(rc_bytes, tick * 1000):
                if isinstance(event, RcFrame):
                    self._take_sticks(event.channels)
        currents_ma = self._control() if self.armed else [0, 0, 0]
        fields = {"I1": 0, "I2": 0, "I3": 0, "I4": 0}
        for wheel, current_ma in zip(self.robot.wheels, currents_ma, strict=True):
            fields[f"I{wheel.can_id}"] = current_ma * wheel.direction
        _send(self.bus, self.log, tick, self.command, fields)

    def _take_feedback(self, received: can.Message) -> None:
        i = self.index[received.arbitration_id]
        message = self.reports[received.arbitration_id]
        angle = message.decode(received.data, decode_choices=False, scaling=False)["Angle"]
        last, self.angles[i] = self.angles[i], angle
        if last is not None:
            turned = (angle - last + COUNTS // 2) % COUNTS - COUNTS // 2
            wheel = self.robot.wheels[i]
            self.speeds[i] = turned * (2.0 * math.pi) / (COUNTS * wheel.direction * wheel.gear) * 1000.0

    def _take_sticks(self, channels: tuple[int, ...]) -> None:
        profile, limits = self.profile, self.robot.limits
        forward = self._stick(channels, profile.forward)
        left = -self._stick(channels, profile.right)
        turn = -self._stick(channels, profile.clockwise)
        pressed = channels[self.aux1.channel] >= self.aux1.pressed_from
        if pressed and self.pressed is False:
            self.armed = not self.armed and not (forward or left or turn)
        self.pressed = pressed
        vx, vy = forward * limits.linear_mps, left * limits.linear_mps
        speed = math.hypot(vx, vy)
        if speed > limits.linear_mps:
            vx, vy = vx * limits.linear_mps / speed, vy * limits.linear_mps / speed
        self.wanted = (vx, vy, turn * limits.angular_radps)

    def _stick(self, channels: tuple[int, ...], axis: Axis) -> float:
        value = (channels[axis.channel] - axis.middle) / axis.travel
        size, dead = abs(value), self.profile.dead_band
        if size <= dead:
            return 0.0
        return math.copysign(min(1.0, (size - dead) / (1.0 - dead)), -value if axis.reversed else value)

    def _control(self) -> list[int]:
        """Ramp, kinematics and one PI loop a wheel with friction feed-forward: currents in mA."""
        robot = self.robot
        self.twist = vx, vy, omega = self._ramped()
        wanted = [hx * vx + hy * vy + hw * omega for hx, hy, hw in self.rows]
        fastest = max(abs(speed) for speed in wanted)
        if fastest > robot.limits.wheel_radps:
            wanted = [speed * robot.limits.wheel_radps / fastest for speed in wanted]
        limit, kp = robot.limits.current_a, robot.control.kp_a_per_radps
        ki_dt = robot.control.ki_a_per_rad * DT_S
        viscous = robot.motor.viscous_nms / robot.motor.torque_nm_per_a
        coulomb = robot.motor.coulomb_nm / robot.motor.torque_nm_per_a
        currents = []
        for i, (want, speed) in enumerate(zip(wanted, self.speeds, strict=True)):
            error = want - speed
            if want == 0.0 and speed == 0.0:
                self.integral[i] *= 0.98
            friction = coulomb * max(-1.0, min(1.0, want / 0.2))
            current = viscous * want + friction + kp * error + self.integral[i]
            if not (current > limit and error > 0.0) and not (current < -limit and error < 0.0):
                self.integral[i] += ki_dt * error
            currents.append(round(1000.0 * max(-limit, min(limit, current))))
        return currents

    def _ramped(self) -> tuple[float, float, float]:
        if not any(self.wanted):
            return 0.0, 0.0, 0.0
        limits = self.robot.limits
        (vx, vy, omega), (to_vx, to_vy, to_omega) = self.twist, self.wanted
        distance, step = math.hypot(to_vx - vx, to_vy - vy), limits.linear_acceleration_mps2 * DT_S
        if distance <= step:
            vx, vy = to_vx, to_vy
        else:
            vx, vy = vx + (to_vx - vx) * step / distance, vy + (to_vy - vy) * step / distance
        turn, step = to_omega - omega, limits.angular_acceleration_radps2 * DT_S
        return vx, vy, omega + max(-step, min(step, turn))


def _send(bus: can.BusABC, log: can.CanutilsLogWriter, tick: int, message: Any, fields: Mapping[str, int]) -> None:
    frame = can.Message(
        timestamp=tick / 1000.0,
        arbitration_id=message.frame_id,
        is_extended_id=False,
        data=message.encode(fields, scaling=False, strict=False),
        channel="can0",
        is_rx=False,
    )
    bus.send(frame)
    log(frame)
