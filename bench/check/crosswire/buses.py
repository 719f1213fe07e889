"""Identifiers, rates and bus time: what crossed the wires could have crossed real ones.

Looked at in windows of 100 ms. A window may hold what its line can carry, and what may have begun before it: one CAN
frame, 64 bytes on a serial line (a port hands them over in bursts). CAN frames are counted at their longest first; only
where that would not fit, bit by bit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from bench.canbus.bits import frame_bits, worst_bits
from bench.canbus.c610 import FEEDBACK_ID
from bench.canbus.instruments import GYRO_ID
from bench.canbus.watch import BusWatch, Kind
from bench.check.crosswire.block import BLOCK_TICKS, Block, Frames, Pattern
from bench.check.crosswire.finding import Finding, Outcome, span
from bench.check.crosswire.settings import BusCheck
from bench.config import Robot
from bench.motors import family
from bench.rc.line import Settings, byte_bits
from bench.rc.misread import SHAPES

RATE_SPARE = 0.05
"""Two clocks, and a frame on either side of a window's edge: 105 frames and three more in 100 ms at 1 kHz."""
EDGE_FRAMES = 3
EDGE_BYTES = 64
MOST_BYTES = 8
MOST_ID = 0x7FF


class BusJudge:
    """Takes blocks of at most 100 ms."""

    def __init__(self, robot: Robot, check: BusCheck) -> None:
        self._check = check
        self._family = family(robot)
        boards = [wheel.can_id for wheel in (*robot.wheels, *robot.dead_wheels)]
        gyros = [GYRO_ID + robot.gyro.can_id] if robot.gyro is not None else []
        others = [message.can_id for message in self._family.others]
        self._watch = BusWatch(boards, [*others, *gyros])
        self._of_base = {message.can_id for message in self._family.commands} | set(others) - set(gyros)
        self._of_motors = {FEEDBACK_ID + number for number in boards} | set(gyros)
        self._most_rate = check.rate_hz * (1 + RATE_SPARE) * BLOCK_TICKS / 1000 + EDGE_FRAMES
        self._bits = check.bitrate * BLOCK_TICKS // 1000
        self._lines: list[tuple[str, float, Callable[[Block], tuple[bytes, ...]]]] = [
            ("requests to the base", check.slamware_baud / 10, lambda block: block.requests),
            ("answers of the base", check.slamware_baud / 10, lambda block: block.answers),
        ]
        if robot.rc is not None:
            baud, bits = _rc_line(robot.rc.protocol)
            self._lines.append((f"RC bytes ({robot.rc.protocol})", baud / bits, lambda block: block.rc))
        self._found: dict[str, tuple[str, int, int, int]] = {}
        # What a tick may bring, by whose frames they are, and has been seen to be in order.
        self._usual: set[tuple[Pattern, bool]] = set()
        self._windows = 0
        self._used = dict.fromkeys(("CAN", *(name for name, _, _ in self._lines)), 0.0)

    def take(self, block: Block) -> None:
        """The next block."""
        self._windows += 1
        self._look_at_ids(block, block.commands, self._of_base, self._of_motors)
        self._look_at_ids(block, block.feedback, self._of_motors, self._of_base)
        self._look_at_time(block)
        for name, bytes_per_s, column in self._lines:
            sent = len(b"".join(column(block)))
            room = bytes_per_s * BLOCK_TICKS / 1000
            self._used[name] = max(self._used[name], sent / room)
            if sent > room + EDGE_BYTES:
                text = f"{sent} {name} within 100 ms, where the line carries {room:.0f}"
                self._note(name, text, block)

    def _look_at_ids(self, block: Block, frames: Frames, owned: set[int], other: set[int]) -> None:
        pattern = frames.pattern
        if pattern is not None and (pattern, owned is self._of_base) in self._usual:
            return
        before = len(self._found), len(self._watch.findings)
        for (can_id, length), count in Counter(zip(frames.ids, map(len, frames.datas), strict=True)).items():
            if count > self._most_rate:
                text = f"0x{can_id:03X} {count} times within 100 ms, where {self._check.rate_hz} a second is the most"
                self._note(f"rate {can_id}", text, block)
            if can_id > MOST_ID or length > MOST_BYTES:
                self._note(f"frame {can_id}", f"0x{can_id:X} with {length} bytes is no classic CAN frame", block)
            elif can_id not in owned:
                if can_id in other:
                    whose = "a motor or sensor sends" if other is self._of_motors else "the base sends"
                    sender = "the base" if other is self._of_motors else "a motor's side"
                    self._note(f"owner {can_id}", f"0x{can_id:03X} came from {sender}; it is what {whose}", block)
                else:
                    self._watch.foreign(block.first, can_id)
            elif self._family.message(can_id, length) is None:
                self._watch.report(Kind.LENGTH, block.first, can_id)
        if (
            pattern is not None
            and len(block) == BLOCK_TICKS
            and before == (0, 0) == (len(self._found), len(self._watch.findings))
        ):
            self._usual.add((pattern, owned is self._of_base))

    def _look_at_time(self, block: Block) -> None:
        count = len(block.commands.ids) + len(block.feedback.ids)
        longest = worst_bits(MOST_BYTES)
        bits = count * longest
        if bits > self._bits:
            every = (*block.commands.every, *block.feedback.every)
            bits = sum(frame_bits(i, data) for i, data in every if i <= MOST_ID and len(data) <= MOST_BYTES)
        self._used["CAN"] = max(self._used["CAN"], bits / self._bits)
        if bits > self._bits + longest:
            text = f"{count} CAN frames within 100 ms need {bits / self._bits:.0%} of the bus"
            self._note("time", text, block)

    def _note(self, key: str, text: str, block: Block) -> None:
        seen = self._found.get(key)
        if seen is None:
            self._found[key] = text, block.first, block.ticks[-1], 1
        else:
            self._found[key] = seen[0], seen[1], block.ticks[-1], seen[3] + 1

    def outcome(self) -> Outcome:
        """At the end of the run."""
        findings = [
            Finding(f"{text}, {span(first, last + 1)}" + _windows(count), first, last, count)
            for text, first, last, count in self._found.values()
        ]
        for one in self._watch.findings:
            findings.append(Finding(one.text, one.first_tick, one.last_tick + BLOCK_TICKS, one.count))
        most = ", ".join(f"{name} {used:.0%}" for name, used in self._used.items() if used)
        measured = f"busiest 100 ms: {most}" if most else "nothing crossed any wire"
        return Outcome("bus", self._check.state, tuple(findings), self._windows, measured, max(self._used.values()))


def _windows(count: int) -> str:
    return f" (in {count} windows)" if count > 1 else ""


def _rc_line(protocol: str) -> tuple[int, int]:
    """Baud rate, and bits of a byte with start, parity and stop."""
    settings: Settings = next(shape.settings for shape in SHAPES if shape.protocol == protocol)
    return settings.baud, len(byte_bits(0, settings))
