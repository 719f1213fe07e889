"""DJI C610 speed controllers on CAN: commands and feedback, both ends of the wire.

                 byte  0      1      2      3      4      5      6      7
    0x200   command  | current 1   | current 2   | current 3   | current 4   |   1 count = 1 mA, -10000 .. 10000
    0x1FF   command  | current 5   | current 6   | current 7   | current 8   |
    0x200+n feedback | rotor angle | rotor speed | current     |  0   |  0   |   0 .. 8191, rpm, 1 count = 1 mA

All fields are big-endian, signed but for the angle (C610 user guide V1.0; bytes 6 and 7 are empty on a C610). Angle and
speed are those of the rotor, before the 36:1 gear. `MotorBus` is the base's end, `EmulatedEscs` the motors' end; the
sign of each motor's wire against its wheel is applied by both through one table, `wiring.Wiring`, and nowhere else.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from math import floor

from bench.canbus.c610 import COMMAND_IDS, COUNTS, FAMILY, FEEDBACK_ID, QUICK_ID
from bench.canbus.instruments import GYRO_ID
from bench.canbus.table import Family
from bench.canbus.watch import BusWatch, Kind
from bench.config import Motor, Robot
from bench.messages import CanFrame
from bench.unwrap import COUNTS_PER_RPM_TICK, HALF_TURN, Births, BySpeed, Unwrap, filter_share, shorter_way
from bench.wiring import Wiring

FRAME_LENGTH = 8
SHORT_GAP_TICKS = 2
"""One lost frame: where an ESC reports a speed that its angle contradicts, the shorter way round is right below 15,000
rpm."""

_COMMAND = FAMILY.commands[0].layout
_FEEDBACK = FAMILY.feedback[0].layout
_FEEDBACK_WORDS = struct.Struct(">HhhH")
"""The same with bytes 6 and 7, which a C610 leaves empty and other motors do not."""

# Half to even, like round(), which takes four times as long to find out that it was given a float.
_round = float.__round__

describe = FAMILY.describe


def encode_command(currents_raw: Sequence[int]) -> bytes:
    """Four currents in counts of 1 mA -> 8 bytes. Raises ValueError outside -10000 .. 10000."""
    return FAMILY.commands[0].encode(currents_raw)


def decode_command(data: bytes) -> tuple[int, int, int, int] | None:
    """8 bytes -> four currents in counts of 1 mA, as they are on the wire; None where the length is wrong."""
    return _COMMAND.unpack(data) if len(data) == FRAME_LENGTH else None


def encode_feedback(angle_counts: int, speed_rpm: int, current_ma: int) -> bytes:
    """Rotor angle 0..8191, rotor rpm and current -> 8 bytes. Raises ValueError outside the fields."""
    return FAMILY.feedback[0].encode((angle_counts, speed_rpm, current_ma))


def decode_feedback(data: bytes) -> tuple[int, int, int] | None:
    """8 bytes -> (rotor angle in counts, rotor rpm, current in mA); None where the length is wrong."""
    return _FEEDBACK.unpack(data) if len(data) == FRAME_LENGTH else None


class MotorBus:
    """The base's end of the motor bus: currents out, what the wheels did in.

    All per-wheel values are lists in the robot's wheel order: `speeds_radps` from the encoder, in the wheel's positive
    sense; `currents_ma` and `rotor_rpm` as reported (wire sign); `quietest_tick` is when the wheel was heard that has
    been quiet for longest, -1 for never. `turned`, once a tick, takes the feedback and says what the wheels turned.
    `watch` keeps what else was on the bus: frames of other nodes, wrong lengths, two senders on one identifier, and
    wheels that were not heard for so long that nobody knows how far they turned (`unwrap` decides).
    """

    __slots__ = (
        "_angles",
        "_births",
        "_commands",
        "_in_step",
        "_increments_rad",
        "_limit_raw",
        "_lost_count",
        "_others",
        "_outputs",
        "_reports",
        "_seen",
        "_settled_tick",
        "_sources",
        "_stop_frames",
        "_taken_tick",
        "_tick",
        "_unwrap",
        "_usual",
        "foreign_frames",
        "malformed_frames",
        "quietest_tick",
        "speeds_radps",
        "watch",
    )

    def __init__(self, robot: Robot, family: Family = FAMILY, unwrap: Unwrap | None = None) -> None:
        wiring = Wiring(robot, family)
        count = len(robot.wheels)
        self._unwrap = unwrap or BySpeed(robot)
        # Where a feedback frame comes from: wheel, rad per count.
        self._sources = {
            FEEDBACK_ID + can_id: (wheel, wiring.rad_per_count[wheel]) for wheel, can_id in enumerate(wiring.can_ids)
        }
        # Who else reports on this bus, to somebody else: encoder boards of dead wheels, and a gyro.
        self._others = {FEEDBACK_ID + wheel.can_id for wheel in robot.dead_wheels}
        if robot.gyro is not None:
            self._others.add(GYRO_ID + robot.gyro.can_id)
        # What a usual tick brings, in wheel order: wheel, identifier, rad per count.
        self._usual = tuple((wheel, can_id, rad) for can_id, (wheel, rad) in self._sources.items())
        self._outputs, self._commands = wiring.outputs, wiring.commands
        self._stop_frames = tuple((can_id, bytes(FRAME_LENGTH)) for can_id in wiring.command_ids)
        self._limit_raw = float(math.floor(robot.limits.current_a * family.raw_per_a))
        self._reports: Sequence[CanFrame] = [(0, b"")] * count
        self._angles: Sequence[int] = [0] * count
        self._seen = [-1] * count
        self._births = Births(count)
        self._lost_count = self._in_step = False
        self._tick = self._taken_tick = self.quietest_tick = -1
        self._settled_tick = -2
        self._increments_rad = [0.0] * count
        self.speeds_radps = [0.0] * count
        self.malformed_frames = 0
        self.foreign_frames = 0
        self.watch = BusWatch(wiring.can_ids)

    def turned(self, tick: int, frames: Sequence[CanFrame]) -> list[float] | None:
        """Take this tick's feedback frames; what the wheels turned, in rad, since they were last all heard.

        None while one is missing: nothing is left out, it comes with the rest. An empty list where a wheel was not
        heard for so long that its whole turns cannot be known: its motion is lost, and that of the others meanwhile.
        """
        # Nearly every tick brings each wheel's report once, in wheel order, each born a tick after the last: the
        # shorter way round is right up to 30,000 rotor rpm (m2006-c610, section 1.2), and nothing has to be kept by
        # wheel. In plain steps, because a call into C costs as much as twenty of them.
        usual = self._usual
        if self._settled_tick == tick - 1 and len(frames) == len(usual):
            angles, lasts = [], self._angles
            increments_rad, speeds_radps = [], []
            for wheel, feedback_id, rad_per_count in usual:
                can_id, data = frames[wheel]
                if can_id != feedback_id or len(data) != FRAME_LENGTH:
                    break
                angle = data[0] << 8 | data[1]
                angles.append(angle)
                increment = ((angle - lasts[wheel] + HALF_TURN) % COUNTS - HALF_TURN) * rad_per_count
                increments_rad.append(increment)
                speeds_radps.append(increment * 1000.0)
            else:
                self._angles = angles
                self._reports = frames
                self.speeds_radps = speeds_radps
                self._tick = self._taken_tick = self.quietest_tick = self._settled_tick = tick
                return increments_rad
        self.receive(tick, frames)
        if not self.complete:
            return None
        lost, self._lost_count = self._lost_count, False
        increments_rad = self.take_increments()
        return [] if lost else increments_rad

    def receive(self, tick: int, frames: Sequence[CanFrame]) -> None:
        """Take feedback frames, whatever they are; `take_increments` then gives what they add up to."""
        if self._settled_tick >= 0:  # the ticks until then were usual ones
            self._seen = [self._settled_tick] * len(self._seen)
            self._births.exactly(self._settled_tick)
            self._settled_tick = -2
        own, sources, seen, births = self._own(tick, frames), self._sources, self._seen, self._births
        angles = self._angles = list(self._angles)
        reports = self._reports = list(self._reports)
        behind = [0] * len(seen)
        for can_id, _ in own:
            behind[sources[can_id][0]] += 1
        alone = len(own) == len(frames) and behind == [1] * len(seen)
        moved: dict[int, tuple[int, int]] = {}  # by wheel, in this tick: counts, and the ticks in which they came
        for can_id, data in own:
            wheel, _ = sources[can_id]
            behind[wheel] -= 1
            (_, last), reports[wheel] = reports[wheel], (can_id, data)
            last_angle, angles[wheel] = angles[wheel], data[0] << 8 | data[1]
            if last:
                way = self._way(tick, can_id, angles[wheel] - last_angle, (last, data), behind[wheel])
                if way is not None:
                    counts, ticks = moved.get(wheel, (0, 0))
                    # A copy, which takes no time, or a report at rest, whose speed is 0 over any time.
                    moved[wheel] = counts + way[0], ticks + (way[1] if data != last else 0)
            else:  # the first sample only sets the reference
                births.first(wheel, tick - behind[wheel])
            seen[wheel] = tick
        for wheel, rad_per_count in sources.values():
            if wheel in moved:
                counts, ticks = moved[wheel]
                increment = counts * rad_per_count
                self._increments_rad[wheel] += increment
                self.speeds_radps[wheel] = increment * 1000.0 / max(ticks, 1)
        self._tick = tick
        self.quietest_tick = min(seen)
        self._in_step = births.settled(tick, alone)

    def _own(self, tick: int, frames: Sequence[CanFrame]) -> list[CanFrame]:
        """The reports among these frames; the others are counted."""
        own: list[CanFrame] = []
        ids = set()
        for frame in frames:
            can_id, data = frame
            if can_id not in self._sources:
                if can_id not in self._others:
                    self.foreign_frames += 1
                    self.watch.foreign(tick, can_id)
            elif len(data) != FRAME_LENGTH:
                self.malformed_frames += 1
                self.watch.report(Kind.LENGTH, tick, can_id)
            else:
                if can_id in ids:
                    self.watch.again(tick, can_id)
                ids.add(can_id)
                own.append(frame)
        return own

    def _way(
        self, tick: int, can_id: int, apart: int, reports: tuple[bytes, bytes], behind: int
    ) -> tuple[int, int] | None:
        """What a rotor turned between two reports, in counts, and in how many ticks; None where nobody can know."""
        (wheel, rad_per_count), births = self._sources[can_id], self._births
        apart, gaps = shorter_way(apart), births.gaps(wheel, tick, behind)
        if gaps[-1] == 1:
            births.heard(wheel, tick, behind, 1, 1)
            return apart, 1
        (_, before_rpm, _), (_, rpm, _) = map(_FEEDBACK.unpack, reports)
        # Where no gap agrees with the speed, the report may be later than any before it was.
        for some in (gaps, range(1, gaps[-1] + 1)):
            way = self._unwrap.way(wheel, apart, (before_rpm, rpm), some)
            if way is not None:
                births.heard(wheel, tick, behind, way.least_ticks, way.most_ticks)
                return way.counts, min(max(tick - self._seen[wheel], way.least_ticks), way.most_ticks)
        births.heard(wheel, tick, behind, gaps[0], gaps[-1])
        if gaps[-1] <= SHORT_GAP_TICKS:
            return apart, gaps[-1]
        self.watch.report(Kind.LOST_COUNT, tick, can_id)
        self._lost_count = True
        self.speeds_radps[wheel] = rpm * COUNTS_PER_RPM_TICK * rad_per_count * 1000.0
        return None

    @property
    def feedback_ids(self) -> tuple[int, ...]:
        """Whose reports it takes, in wheel order."""
        return tuple(self._sources)

    @property
    def currents_ma(self) -> list[int]:
        """Current as each ESC last reported it, wire sign; 0 before its first report."""
        return [_FEEDBACK.unpack(data)[2] if data else 0 for _, data in self._reports]

    @property
    def rotor_rpm(self) -> list[int]:
        """Rotor speed as each ESC last reported it, wire sign; 0 before its first report."""
        return [_FEEDBACK.unpack(data)[1] if data else 0 for _, data in self._reports]

    @property
    def complete(self) -> bool:
        """True when every wheel has reported since the tick in which the increments were last taken."""
        return self.quietest_tick > self._taken_tick

    def take_increments(self) -> list[float]:
        """What each wheel turned, in rad, since this was last called."""
        increments = self._increments_rad
        self._increments_rad = [0.0] * len(increments)
        self._taken_tick = self._tick
        if self._in_step:
            self._settled_tick = self._tick
        return increments

    def silent_ticks(self, tick: int) -> int:
        """Ticks since the wheel that has been quiet for longest was heard."""
        return tick - self.quietest_tick

    def silences(self, tick: int) -> list[int]:
        """Ticks since each wheel was heard, in wheel order."""
        if self._settled_tick >= 0:
            return [tick - self._settled_tick] * len(self._seen)
        return [tick - seen for seen in self._seen]

    def command(self, currents_a: Sequence[float]) -> tuple[CanFrame, ...]:
        """Currents in the wheels' positive sense -> command frames. The last line before the port: it clamps."""
        most = self._limit_raw
        least = -most
        raws = []
        for wheel, raw_per_a in self._outputs:
            raw = currents_a[wheel] * raw_per_a
            raws.append(_round(raw) if least <= raw <= most else _clamped(raw, most))
        if len(self._commands) == 1:
            can_id, layout, _, _ = self._commands[0]
            return ((can_id, layout.pack(*raws)),)
        return tuple((can_id, layout.pack(*raws[start:end])) for can_id, layout, start, end in self._commands)

    def stop(self) -> tuple[CanFrame, ...]:
        """Command frames that ask for no current anywhere."""
        return self._stop_frames

    def wake(self) -> tuple[CanFrame, ...]:
        """What has to be sent before the first command that shall move something: nothing, to a C610."""
        return ()


def _clamped(raw: float, most: float) -> int:
    """A current beyond the limit, or not-a-number, which is none."""
    return round(most) if raw > most else round(-most) if raw < -most else 0


class EmulatedEscs:
    """The motors' end: keeps what each ESC was last told, and reports what its motor does.

    A command frame sets all four motors of its group. On command loss the maker documents nothing: `hold` (keep the
    last current, the safe assumption) and `zero` after `command_timeout_ms` are both offered by the robot file.

    An ESC that hears its own identifier from somebody else stops, as the maker says: no current, no report. The 0x700
    frame puts all of them into quick-ID mode, where rotors are turned by hand: no current, assumed. Both last until the
    power is cycled, which is a new object; `watch` keeps what happened.
    """

    __slots__ = (
        "_currents_a",
        "_filter",
        "_heard",
        "_knows_quick_id",
        "_last_words",
        "_max_raw",
        "_reports",
        "_rpm",
        "_timeout_ticks",
        "_wheels",
        "in_quick_id",
        "malformed_frames",
        "watch",
    )

    def __init__(self, robot: Robot, family: Family = FAMILY) -> None:
        motor: Motor = robot.motor
        wiring = Wiring(robot, family)
        count = len(robot.wheels)
        self._currents_a = [0.0] * count
        self._heard = [0] * count
        self._rpm = [0.0] * count
        # First-order low-pass on the reported speed, exact for a step of 1 ms.
        self._filter = filter_share(motor.speed_filter_ms)
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
        self._last_words = [0] * count
        self._max_raw = family.full_scale_raw
        self._knows_quick_id = family.message(QUICK_ID) is not None
        self.malformed_frames = 0
        self.in_quick_id = False
        self.watch = BusWatch(wiring.can_ids)

    def receive(self, tick: int, frames: Sequence[CanFrame]) -> list[float]:
        """Take this tick's command frames; answer with the current of each wheel in A, in its positive sense."""
        currents_a, heard_ticks = self._currents_a, self._heard
        max_raw = self._max_raw
        min_raw = -max_raw
        for can_id, data in frames:
            wheels = self._wheels.get(can_id)
            if wheels is None:
                self._other_frame(tick, can_id, data)
                continue
            if len(data) != FRAME_LENGTH:
                self.malformed_frames += 1
                self.watch.report(Kind.LENGTH, tick, can_id)
                continue
            raws = _COMMAND.unpack(data)
            for wheel, slot, raw_per_a in wheels:
                raw = raws[slot]
                if not min_raw <= raw <= max_raw:
                    # What a C610 does beyond its range is not documented; clamping is the harmless assumption.
                    raw = max_raw if raw > 0 else min_raw
                currents_a[wheel] = raw / raw_per_a
                heard_ticks[wheel] = tick
        if len(frames) > 1:
            self._look_for_two_controllers(tick, frames)
        if self._timeout_ticks is not None:
            for wheel, heard in enumerate(self._heard):
                if tick - heard >= self._timeout_ticks:
                    currents_a[wheel] = 0.0
        return currents_a

    def _other_frame(self, tick: int, can_id: int, data: bytes) -> None:
        """No command for these ESCs, and mostly none of their business."""
        own = [wheel for wheel, feedback_id, *_ in self._reports if feedback_id == can_id]
        if own:
            self.watch.report(Kind.TWO_SENDERS, tick, can_id)
            self._let_go(own[0])
            self._reports = tuple(report for report in self._reports if report[0] != own[0])
        elif can_id == QUICK_ID and self._knows_quick_id and describe(can_id, data):
            self.watch.report(Kind.QUICK_ID, tick, can_id)
            self.in_quick_id = True
            for wheel in range(len(self._currents_a)):
                self._let_go(wheel)

    def _let_go(self, wheel: int) -> None:
        """This motor takes no command and gives no current from now on."""
        self._currents_a[wheel] = 0.0
        self._wheels = {
            command_id: tuple(place for place in places if place[0] != wheel)
            for command_id, places in self._wheels.items()
        }

    def _look_for_two_controllers(self, tick: int, frames: Sequence[CanFrame]) -> None:
        ids = [can_id for can_id, _ in frames]
        for can_id in COMMAND_IDS:
            if ids.count(can_id) > 1:
                self.watch.again(tick, can_id)

    def feedback(
        self, angles_rad: Sequence[float], speeds_radps: Sequence[float], currents_a: Sequence[float]
    ) -> tuple[CanFrame, ...]:
        """One feedback frame for each ESC from its wheel's angle, speed and current, in wheel order."""
        rpms, filter_share, last_words = self._rpm, self._filter, self._last_words
        pack = _FEEDBACK_WORDS.pack
        frames = []
        for wheel, feedback_id, counts_per_rad, rpm_per_radps, raw_per_a in self._reports:
            rpm = rpms[wheel]
            rpms[wheel] = rpm = rpm + filter_share * (speeds_radps[wheel] * rpm_per_radps - rpm)
            counts = floor(angles_rad[wheel] * counts_per_rad) % COUNTS
            raw = _round(currents_a[wheel] * raw_per_a)
            try:
                data = pack(counts, _round(rpm), raw, last_words[wheel])
            except struct.error:  # no M2006 turns as fast; the field saturates rather than wraps
                data = pack(counts, 32767 if rpm > 0.0 else -32768, raw, last_words[wheel])
            frames.append((feedback_id, data))
        return tuple(frames)
