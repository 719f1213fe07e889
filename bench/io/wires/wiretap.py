"""Reads the wires of a run: which frames their bytes are, whose, and how many bits of each wire's time they took.

Tell it the ticks that have passed since the last time (`take`), then ask (`table`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

from bench import rc_decode
from bench.base import RC_PAUSE_US
from bench.canbus.bits import frame_bits
from bench.config import Robot
from bench.io.address import CAN_BITRATE
from bench.io.wires.counts import MARK_TICKS, Counts, Row
from bench.io.wires.log import LOGGED, WireLog
from bench.io.wires.table import CAN, CORE, ORDER, RC, WireRow, WireSum, WireTable
from bench.io.wires.words import CanWords, Words, rc_key, rc_words
from bench.messages import TICK_US, RcNoise, TickOutput
from bench.rc.misread import SHAPES
from bench.slamware import FrameDecoder, SlamwareEvent, SlamwareFrame, SlamwareNoise, summary
from bench.slamware.commands import SUB_COMMANDS
from bench.slamware.framing import CONTROL_BUS, ERROR

CORE_BAUD, CORE_BYTE_BITS = 115_200, 10
FOLLOW_TICKS = 50
"""What was is told as it would have been at 20 frames a second."""
RC_TAIL = 512
MEASURED_EVERY = 4
"""Of an identifier's frames one in so many is counted bit by bit, stuffing included; it stands for the next ones."""


class Wiretap:
    """Counts from the first tick on. `take` every tick once, in order."""

    def __init__(self, robot: Robot) -> None:
        self._can_words = CanWords(robot)
        rc = robot.rc
        self._rc = rc_decode.decoder(rc.protocol, pause_us=RC_PAUSE_US) if rc is not None else None
        self._rc_name = rc.protocol if rc is not None else ""
        settings = next((shape.settings for shape in SHAPES if shape.protocol == self._rc_name), None)
        self._rc_line = str(settings) if settings is not None else ""
        self._rc_baud = settings.baud if settings is not None else 1
        self._rc_byte_bits = 9 + settings.even_parity + settings.stop_bits if settings is not None else 10
        self._rc_total = 0
        self._rc_tail = bytearray()
        self._requests, self._answers = FrameDecoder(), FrameDecoder()
        self._asked = b""
        self._counts = Counts()
        self._can: dict[int, Row] = {}
        """The rows of the bus once more, by identifier."""
        self._log = WireLog(self._can.get, self._said)
        self._tick = -1
        self._robot = robot

    def take(self, outs: Iterable[TickOutput]) -> None:
        """The next ticks."""
        seen: defaultdict[int, list[bytes]] = defaultdict(list)
        last: dict[int, int] = {}
        note = self._log.note
        for out in outs:
            tick = self._tick = out.tick
            if out.rc:
                self._take_rc(out.rc, tick)
            if out.core_to_base or out.base_to_core:
                self._take_core(out, tick)
            frames = out.can_commands + out.can_feedback
            if frames:
                note((tick, frames))
                for can_id, data in frames:
                    seen[can_id].append(data)
                    last[can_id] = tick
            if (tick + 1) % MARK_TICKS == 0:
                self._count_can(seen, last)
                seen.clear()
                self._counts.mark(tick + 1)
        self._count_can(seen, last)

    def follow(self, outs: Sequence[TickOutput], filter: str) -> None:
        """The next ticks, as if somebody had looked all the while: with a filter the log reaches back further."""
        for start in range(0, len(outs), FOLLOW_TICKS):
            self.take(outs[start : start + FOLLOW_TICKS])
            if filter:
                self._log.write(filter, LOGGED)

    def kept_before(self, tick: int) -> int:
        """The last tick, but none after this one, whose figures are kept; 0 is the beginning."""
        return self._counts.kept_before(tick)

    def again(self, tick: int, lead: Sequence[TickOutput]) -> Wiretap:
        """One that has seen all ticks before this one, as this has: with its figures where they were kept then.

        `lead` are some ticks before: what a decoder had begun to read.
        """
        other = Wiretap(self._robot)
        other.take(lead)
        other._begin_at(tick, self._counts.before(tick))
        return other

    def table(self, filter: str = "", log: int = LOGGED) -> WireTable:
        """The figures after the last tick, and so many of the newest frames whose words hold `filter`; commas mean or.

        Without a log the rows are without words too: they cost more than all the counting.
        """
        self._log.write(filter, log)
        counts = self._counts
        seconds = counts.seconds(self._tick + 1)
        rows = [self._row(row, seconds, log > 0) for row in counts.rows.values()]
        rows.sort(key=_place)
        about = {RC: f"{self._rc_name} {self._rc_line}".strip(), CAN: "1 Mbit/s", CORE: f"{CORE_BAUD} 8N1"}
        sums = []
        for wire in ORDER:
            own = [row for row in rows if row.wire == wire]
            frames, rate_hz = sum([row.frames for row in own]), sum([row.rate_hz for row in own])
            load = sum([row.load for row in own])
            sums.append(WireSum(wire, about[wire], frames, rate_hz, load, counts.errors[wire]))
        return WireTable(self._tick, tuple(sums), tuple(rows), tuple(self._log.written)[-log:] if log else ())

    # --- counting ------------------------------------------------------------------------------------------------

    def _count_can(self, seen: Mapping[int, Sequence[bytes]], last: Mapping[int, int]) -> None:
        """Frames of the bus by identifier, each in its order; `last` has the tick of the last one."""
        for can_id, frames in seen.items():
            row = self._can.get(can_id) or self._can_row(can_id)
            count = len(frames)
            if row is None:
                self._counts.errors[CAN] += count
                continue
            first = -row.count % MEASURED_EVERY
            row.bits += min(first, count) * row.latest_bits
            for place in range(first, count, MEASURED_EVERY):
                row.latest_bits = frame_bits(can_id, frames[place])
                row.bits += min(MEASURED_EVERY, count - place) * row.latest_bits
            row.count += count
            row.tick, row.data = last[can_id], frames[-1]

    def _can_row(self, can_id: int) -> Row | None:
        row = self._counts.row(CAN, can_id, f"{can_id:03X}", lambda: self._can_words.name(can_id))
        if row is not None:
            self._can[can_id] = row
        return row

    def _take_rc(self, data: bytes, tick: int) -> None:
        self._rc_total += len(data)
        self._rc_tail += data
        if self._rc is None:
            return
        for event in self._rc.feed(data, tick * TICK_US):
            if isinstance(event, RcNoise):
                self._counts.errors[RC] += event.length
            key = rc_key(event)
            start = event.offset - (self._rc_total - len(self._rc_tail))
            raw = bytes(self._rc_tail[max(0, start) : start + event.length]) if start + event.length > 0 else b""
            self._count(RC, key, self._rc_name, tick, raw, event.length * self._rc_byte_bits, rc_words(event))
        if len(self._rc_tail) > 2 * RC_TAIL:
            del self._rc_tail[:-RC_TAIL]

    def _take_core(self, out: TickOutput, tick: int) -> None:
        for event in self._requests.feed(out.core_to_base, tick):
            if isinstance(event, SlamwareFrame):
                self._asked = event.payload if event.code == CONTROL_BUS else b""
            self._count_core(event, ">", tick, b"")
        for event in self._answers.feed(out.base_to_core, tick):
            self._count_core(event, "<", tick, self._asked)

    def _count_core(self, event: SlamwareEvent, way: str, tick: int, asked: bytes) -> None:
        bits = event.length * CORE_BYTE_BITS
        if isinstance(event, SlamwareNoise):
            self._counts.errors[CORE] += event.length
            self._count(CORE, f"{way} noise", event.reason, tick, b"", bits, lambda: summary(event))
            return
        about = asked[:1] if way == "<" else event.payload[:1] if event.code == CONTROL_BUS else b""
        key = f"{way} {about.hex().upper() or f'code {event.code:02X}'}"
        known = SUB_COMMANDS.get(about[0]) if about else None
        name = known.name if known is not None else ""
        if way == "<" and event.code == ERROR:
            key, name = f"{key} error", "refused"
        self._count(CORE, key, name, tick, event.payload, bits, lambda: summary(event, asked))

    def _count(self, wire: str, key: str, name: str, tick: int, data: bytes, bits: int, words: Words) -> None:
        row = self._counts.row(wire, key, key, lambda: name)
        if row is None:
            return
        row.count += 1
        row.bits += bits
        row.tick, row.data, row.words = tick, data, words
        self._log.note((tick, row, data, words))

    def _begin_at(self, tick: int, counts: Counts) -> None:
        """Only what is being read stays of the ticks until here."""
        self._tick = tick - 1
        self._counts = counts
        self._can = {int(row.key, 16): row for (wire, _), row in counts.rows.items() if wire == CAN}
        self._log = WireLog(self._can.get, self._said)

    # --- telling -------------------------------------------------------------------------------------------------

    def _row(self, row: Row, seconds: float, in_words: bool) -> WireRow:
        count, bits = row.marks[0]
        per_s = self._rc_baud if row.wire == RC else CAN_BITRATE if row.wire == CAN else CORE_BAUD
        return WireRow(
            row.wire,
            row.key,
            row.name,
            row.count,
            (row.count - count) / seconds,
            (row.bits - bits) / seconds / per_s,
            row.tick,
            row.data,
            self._said(row, row.data, row.words) if in_words else "",
        )

    def _said(self, row: Row, data: bytes, words: Words | None) -> str:
        return words() if words is not None else self._can_words.said(int(row.key, 16), data)


def _place(row: WireRow) -> tuple[int, str, bool]:
    """By wire and identifier; on the control bus an answer below its request."""
    is_core = row.wire == CORE
    return ORDER.index(row.wire), row.key[2:] if is_core else row.key, is_core and row.key.startswith("<")
