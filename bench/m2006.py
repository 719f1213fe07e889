"""DJI C610 speed controllers on CAN: commands and feedback, both ends of the wire.

                 byte  0      1      2      3      4      5      6      7
    0x200   command  | current 1   | current 2   | current 3   | current 4   |   1 count = 1 mA, -10000 .. 10000
    0x1FF   command  | current 5   | current 6   | current 7   | current 8   |
    0x200+n feedback | rotor angle | rotor speed | current     |  0   |  0   |   0 .. 8191, rpm, 1 count = 1 mA

All fields are big-endian, signed but for the angle (C610 user guide V1.0; bytes 6 and 7 are empty on a C610). Angle and
speed are those of the rotor, before the 36:1 gear. `MotorBus` is the base's end, `EmulatedEscs` the motors' end; the
sign of each motor's wire against its wheel is applied by both through one table, `Wiring`, and nowhere else.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from bench.config import Motor, Robot
from bench.messages import CanFrame

COMMAND_IDS = (0x200, 0x1FF)  # ESCs 1 to 4, ESCs 5 to 8
FEEDBACK_ID = 0x200  # plus the ESC's number, 1 to 8
MIN_RAW, MAX_RAW = -10_000, 10_000  # C610 user guide: stands for -10 A .. 10 A
RAW_PER_A = 1000.0
COUNTS = 8192  # counts in one rotor turn (not 8191: two public drivers drift one count a turn)
HALF_TURN = COUNTS // 2
RPM_PER_RADPS = 30.0 / math.pi

_COMMAND = struct.Struct(">4h")
_FEEDBACK = struct.Struct(">Hhh2x")
FRAME_LENGTH = 8


def encode_command(currents_raw: Sequence[int]) -> bytes:
    """Four currents in counts of 1 mA -> 8 bytes. Raises ValueError outside -10000 .. 10000."""
    for raw in currents_raw:
        if not MIN_RAW <= raw <= MAX_RAW:
            raise ValueError(f"current {raw} outside {MIN_RAW}..{MAX_RAW}")
    return _COMMAND.pack(*currents_raw)


def decode_command(data: bytes) -> tuple[int, int, int, int] | None:
    """8 bytes -> four currents in counts of 1 mA, as they are on the wire; None where the length is wrong."""
    return _COMMAND.unpack(data) if len(data) == FRAME_LENGTH else None


def encode_feedback(angle_counts: int, speed_rpm: int, current_ma: int) -> bytes:
    """Rotor angle 0..8191, rotor rpm and current -> 8 bytes. Raises ValueError outside the fields."""
    if not 0 <= angle_counts < COUNTS:
        raise ValueError(f"angle {angle_counts} outside 0..{COUNTS - 1}")
    for name, value in (("speed", speed_rpm), ("current", current_ma)):
        if not -32768 <= value <= 32767:
            raise ValueError(f"{name} {value} outside -32768..32767")
    return _FEEDBACK.pack(angle_counts, speed_rpm, current_ma)


def decode_feedback(data: bytes) -> tuple[int, int, int] | None:
    """8 bytes -> (rotor angle in counts, rotor rpm, current in mA); None where the length is wrong."""
    return _FEEDBACK.unpack(data) if len(data) == FRAME_LENGTH else None


def describe(can_id: int, data: bytes) -> dict[str, object]:
    """A frame's fields by name, for people and for JSON; empty for a frame that is none of the C610's."""
    if can_id in COMMAND_IDS and (currents := decode_command(data)) is not None:
        first = 1 if can_id == COMMAND_IDS[0] else 5
        return {f"current_{first + i}_ma": current for i, current in enumerate(currents)}
    if FEEDBACK_ID < can_id <= FEEDBACK_ID + 8 and (fields := decode_feedback(data)) is not None:
        return dict(zip(("angle_counts", "speed_rpm", "current_ma"), fields, strict=True))
    return {}


class Wiring:
    """Which ESC turns which wheel and in which sense: the one table that knows `direction` and the gear."""

    __slots__ = ("can_ids", "command_ids", "counts_per_rad", "rad_per_count", "raw_per_a", "rpm_per_radps", "slots")

    def __init__(self, robot: Robot) -> None:
        wheels = robot.wheels
        self.can_ids = tuple(wheel.can_id for wheel in wheels)
        self.raw_per_a = tuple(wheel.direction * RAW_PER_A for wheel in wheels)
        self.counts_per_rad = tuple(wheel.direction * wheel.gear * COUNTS / (2.0 * math.pi) for wheel in wheels)
        self.rad_per_count = tuple(1.0 / counts for counts in self.counts_per_rad)
        self.rpm_per_radps = tuple(wheel.direction * wheel.gear * RPM_PER_RADPS for wheel in wheels)
        # Each wheel's place in its command frame: (index of the frame among those sent, slot 0 to 3).
        groups = sorted({(can_id - 1) // 4 for can_id in self.can_ids})
        self.command_ids = tuple(COMMAND_IDS[group] for group in groups)
        self.slots = tuple((groups.index((can_id - 1) // 4), (can_id - 1) % 4) for can_id in self.can_ids)


class MotorBus:
    """The base's end of the motor bus: currents out, what the wheels did in.

    All per-wheel values are lists in the robot's wheel order: `speeds_radps` from the encoder, in the wheel's positive
    sense; `currents_ma` and `rotor_rpm` as reported (wire sign). `take_increments` gives what the wheels turned.
    """

    __slots__ = (
        "_command_ids",
        "_increments_rad",
        "_limit_raw",
        "_outputs",
        "_quietest_tick",
        "_reports",
        "_seen",
        "_sources",
        "_stop_frames",
        "_taken_tick",
        "_tick",
        "foreign_frames",
        "malformed_frames",
        "speeds_radps",
    )

    def __init__(self, robot: Robot) -> None:
        wiring = Wiring(robot)
        count = len(robot.wheels)
        # Where a feedback frame comes from: wheel, rad per count.
        self._sources = {
            FEEDBACK_ID + can_id: (wheel, wiring.rad_per_count[wheel]) for wheel, can_id in enumerate(wiring.can_ids)
        }
        self._command_ids = wiring.command_ids
        # Where a current goes: wheel, place among the slots of all command frames, raw per A.
        self._outputs = tuple(
            (wheel, 4 * frame + slot, wiring.raw_per_a[wheel]) for wheel, (frame, slot) in enumerate(wiring.slots)
        )
        self._stop_frames = tuple((can_id, bytes(FRAME_LENGTH)) for can_id in wiring.command_ids)
        self._limit_raw = float(math.floor(robot.limits.current_a * RAW_PER_A))
        self._reports: list[tuple[int, int, int] | None] = [None] * count
        self._seen = [-1] * count
        self._tick = self._taken_tick = self._quietest_tick = -1
        self._increments_rad = [0.0] * count
        self.speeds_radps = [0.0] * count
        self.malformed_frames = 0
        self.foreign_frames = 0

    def receive(self, tick: int, frames: Sequence[CanFrame]) -> None:
        """Take the feedback frames that arrived in this tick."""
        sources, reports, seen, increments = self._sources, self._reports, self._seen, self._increments_rad
        for can_id, data in frames:
            source = sources.get(can_id)
            if source is None:
                self.foreign_frames += 1
                continue
            if len(data) != FRAME_LENGTH:
                self.malformed_frames += 1
                continue
            wheel, rad_per_count = source
            last = reports[wheel]
            reports[wheel] = report = _FEEDBACK.unpack(data)
            ticks = tick - seen[wheel]
            seen[wheel] = tick
            if last is None:  # the first sample only sets the reference
                continue
            # The shorter way round: right up to 30,000 rotor rpm at 1 kHz (m2006-c610, section 1.2).
            increment = ((report[0] - last[0] + HALF_TURN) % COUNTS - HALF_TURN) * rad_per_count
            increments[wheel] += increment
            if ticks > 0:
                self.speeds_radps[wheel] = increment * 1000.0 / ticks
        self._tick = tick
        self._quietest_tick = min(seen)

    @property
    def currents_ma(self) -> list[int]:
        """Current as each ESC last reported it, wire sign; 0 before its first report."""
        return [report[2] if report else 0 for report in self._reports]

    @property
    def rotor_rpm(self) -> list[int]:
        """Rotor speed as each ESC last reported it, wire sign; 0 before its first report."""
        return [report[1] if report else 0 for report in self._reports]

    @property
    def complete(self) -> bool:
        """True when every wheel has reported since the tick in which the increments were last taken."""
        return self._quietest_tick > self._taken_tick

    def take_increments(self) -> list[float]:
        """What each wheel turned, in rad, since this was last called."""
        increments = self._increments_rad
        self._increments_rad = [0.0] * len(increments)
        self._taken_tick = self._tick
        return increments

    def silent_ticks(self, tick: int) -> int:
        """Ticks since the wheel that has been quiet for longest was heard."""
        return tick - self._quietest_tick

    def command(self, currents_a: Sequence[float]) -> tuple[CanFrame, ...]:
        """Currents in the wheels' positive sense -> command frames. The last line before the port: it clamps."""
        most = self._limit_raw
        least = -most
        raws = [0] * (4 * len(self._command_ids))
        for wheel, place, raw_per_a in self._outputs:
            raw = currents_a[wheel] * raw_per_a
            if least <= raw <= most:
                raws[place] = round(raw)
            elif raw > most:
                raws[place] = round(most)
            elif raw < least:
                raws[place] = round(least)
            # Not-a-number compares false with everything: its slot stays 0.
        if len(raws) == 4:
            return ((self._command_ids[0], _COMMAND.pack(*raws)),)
        return tuple((can_id, _COMMAND.pack(*raws[4 * i : 4 * i + 4])) for i, can_id in enumerate(self._command_ids))

    def stop(self) -> tuple[CanFrame, ...]:
        """Command frames that ask for no current anywhere."""
        return self._stop_frames


class EmulatedEscs:
    """The motors' end: keeps what each ESC was last told, and reports what its motor does.

    A command frame sets all four motors of its group. On command loss the maker documents nothing: `hold` (keep the
    last current, the safe assumption) and `zero` after `command_timeout_ms` are both offered by the robot file.
    """

    __slots__ = (
        "_currents_a",
        "_filter",
        "_heard",
        "_reports",
        "_rpm",
        "_timeout_ticks",
        "_wheels",
        "malformed_frames",
    )

    def __init__(self, robot: Robot) -> None:
        motor: Motor = robot.motor
        wiring = Wiring(robot)
        count = len(robot.wheels)
        self._currents_a = [0.0] * count
        self._heard = [0] * count
        self._rpm = [0.0] * count
        # First-order low-pass on the reported speed, exact for a step of 1 ms.
        self._filter = 1.0 if motor.speed_filter_ms == 0.0 else 1.0 - math.exp(-1.0 / motor.speed_filter_ms)
        self._timeout_ticks = motor.command_timeout_ms if motor.on_command_loss == "zero" else None
        self._wheels = {
            command_id: tuple(
                (wheel, slot, wiring.raw_per_a[wheel])
                for wheel, (frame, slot) in enumerate(wiring.slots)
                if wiring.command_ids[frame] == command_id
            )
            for command_id in wiring.command_ids
        }
        self._reports = tuple(
            (wheel, FEEDBACK_ID + can_id, wiring.counts_per_rad[wheel], wiring.rpm_per_radps[wheel], raw_per_a)
            for wheel, (can_id, raw_per_a) in enumerate(zip(wiring.can_ids, wiring.raw_per_a, strict=True))
        )
        self.malformed_frames = 0

    def receive(self, tick: int, frames: Sequence[CanFrame]) -> list[float]:
        """Take this tick's command frames; answer with the current of each wheel in A, in its positive sense."""
        currents_a = self._currents_a
        for can_id, data in frames:
            wheels = self._wheels.get(can_id)
            if wheels is None:
                continue
            if len(data) != FRAME_LENGTH:
                self.malformed_frames += 1
                continue
            raws = _COMMAND.unpack(data)
            for wheel, slot, raw_per_a in wheels:
                raw = raws[slot]
                if not MIN_RAW <= raw <= MAX_RAW:
                    # What a C610 does beyond its range is not documented; clamping is the harmless assumption.
                    raw = MAX_RAW if raw > 0 else MIN_RAW
                currents_a[wheel] = raw / raw_per_a
                self._heard[wheel] = tick
        if self._timeout_ticks is not None:
            for wheel, heard in enumerate(self._heard):
                if tick - heard >= self._timeout_ticks:
                    currents_a[wheel] = 0.0
        return currents_a

    def feedback(
        self, angles_rad: Sequence[float], speeds_radps: Sequence[float], currents_a: Sequence[float]
    ) -> tuple[CanFrame, ...]:
        """One feedback frame for each ESC from its wheel's angle, speed and current, in wheel order."""
        rpms, filter_share = self._rpm, self._filter
        frames = []
        for wheel, feedback_id, counts_per_rad, rpm_per_radps, raw_per_a in self._reports:
            rpm = rpms[wheel]
            rpm += filter_share * (speeds_radps[wheel] * rpm_per_radps - rpm)
            rpms[wheel] = rpm
            counts = math.floor(angles_rad[wheel] * counts_per_rad) % COUNTS
            current_ma = round(currents_a[wheel] * raw_per_a)
            whole_rpm = round(rpm)
            if not -32768 <= whole_rpm <= 32767:  # no M2006 gets there; the field saturates rather than wraps
                whole_rpm = 32767 if whole_rpm > 0 else -32768
            frames.append((feedback_id, _FEEDBACK.pack(counts, whole_rpm, current_ma)))
        return tuple(frames)
