"""Each wire's traffic in figures: what came, how often, how old it is, how full the wire is. For a screen that asks.

Tell it the ticks that have passed since the last time (`take`), then ask (`table`). What it gives is plain values.

    rc      the receiver's bytes: frames of the robot's protocol, and what is none
    can     the motors' bus: a row an identifier, its load from the exact bits of its frames
    core    the SLAMWARE control bus: a row a sub-command, requests and answers apart
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from bench import rc_decode
from bench.base import RC_PAUSE_US
from bench.canbus.bits import frame_bits
from bench.canbus.table import Message
from bench.config import Robot
from bench.messages import CanFrame, RcEvent, RcFrame, RcLinkStatistics, RcNoise, TickOutput
from bench.motors import family
from bench.rc.misread import SHAPES
from bench.slamware import FrameDecoder, SlamwareEvent, SlamwareFrame, SlamwareNoise, summary
from bench.slamware.commands import SUB_COMMANDS
from bench.slamware.framing import CONTROL_BUS, ERROR

RC, CAN, CORE = "rc", "can", "core"
CAN_BITRATE = 1_000_000
CORE_BAUD, CORE_BYTE_BITS = 115_200, 10
MARK_TICKS, MARKS = 100, 10
"""Rates are over the last second, counted in tenths of it."""
MOST_ROWS = 96
"""A bus full of strangers fills no memory: what comes after these is only counted."""
LOGGED = 128
"""So many of the newest frames are kept in words."""
LOOKED_AT = 256
"""And so many are looked through for each picture; where a filter leaves less, older ones are passed over."""
KEPT_EVERY, MOST_KEPT = 1000, 3600
"""The figures are kept once a second, some 4 kB, for whoever looks back; after an hour every second time."""
FOLLOW_TICKS = 50
"""What was is told as it would have been at 20 frames a second."""
RC_TAIL = 512
MEASURED_EVERY = 4
"""Of an identifier's frames one in so many is counted bit by bit, stuffing included; it stands for the next ones."""


class WireSum(NamedTuple):
    """A whole wire. Rates are a second's; `load` is the share of the wire's time, 1.0 is full."""

    wire: str
    about: str
    frames: int
    rate_hz: float
    load: float
    errors: int
    """Bytes (rc, core) that are no frame; on CAN, frames that no row had room for."""


class WireRow(NamedTuple):
    """All frames of one kind on one wire: an identifier, a sub-command, a kind of RC frame."""

    wire: str
    key: str
    name: str
    frames: int
    rate_hz: float
    load: float
    last_tick: int
    data: bytes
    said: str


class Logged(NamedTuple):
    """One frame."""

    tick: int
    wire: str
    key: str
    data: bytes
    said: str


class WireTable(NamedTuple):
    """Everything at one instant; `log` from old to new, only what the filter lets pass."""

    tick: int
    sums: tuple[WireSum, ...]
    rows: tuple[WireRow, ...]
    log: tuple[Logged, ...]


Words: TypeAlias = Callable[[], str]
"""A frame's contents, put into words only where somebody reads them."""
_Figures: TypeAlias = tuple[str, str, str, int, int, int, int, bytes, Words | None]


class _Row:
    """The counters of a `WireRow`. `bits` are those on the wire."""

    __slots__ = ("bits", "count", "data", "key", "latest_bits", "marks", "name", "tick", "wire", "words")

    def __init__(self, wire: str, key: str, name: str, marks: int) -> None:
        self.wire, self.key, self.name = wire, key, name
        self.count = self.bits = self.latest_bits = self.tick = 0
        self.data = b""
        self.words: Words | None = None
        # (count, bits) at each mark of the last second; a row that is new had nothing before.
        self.marks: deque[tuple[int, int]] = deque([(0, 0)] * marks, maxlen=MARKS + 1)

    def figures(self) -> _Figures:
        """All that is to be kept of it."""
        return (
            self.wire, self.key, self.name, self.count, self.bits, self.latest_bits, self.tick, self.data, self.words
        )  # fmt: skip

    def restore(self, figures: _Figures) -> None:
        """Go on from there."""
        self.count, self.bits, self.latest_bits, self.tick, self.data, self.words = figures[3:]
        self.marks = deque([(self.count, self.bits)], maxlen=MARKS + 1)


class _Kept(NamedTuple):
    """The figures of all rows before a tick."""

    tick: int
    errors: dict[str, int]
    rows: tuple[tuple[tuple[str, object], _Figures], ...]


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
        self._rows: dict[tuple[str, object], _Row] = {}
        self._can: dict[int, _Row] = {}
        self._marks: deque[int] = deque([0], maxlen=MARKS + 1)
        self._errors = {RC: 0, CAN: 0, CORE: 0}
        self._tick = -1
        self._log: deque[Logged] = deque(maxlen=LOGGED)
        self._filter = ""
        self._unlogged: deque[tuple[int, _Row, bytes, Words | None]] = deque(maxlen=LOOKED_AT)
        self._robot = robot
        self._kept: list[_Kept] = []
        self._keep_every = KEPT_EVERY

    def take(self, outs: Iterable[TickOutput]) -> None:
        """The next ticks."""
        for out in outs:
            tick = self._tick = out.tick
            if out.rc:
                self._take_rc(out.rc, tick)
            if out.core_to_base or out.base_to_core:
                self._take_core(out, tick)
            self._take_can(out.can_commands, tick)
            self._take_can(out.can_feedback, tick)
            if (tick + 1) % MARK_TICKS == 0:
                self._mark(tick + 1)

    def follow(self, outs: Sequence[TickOutput], filter: str) -> None:
        """The next ticks, as if somebody had looked all the while: with a filter the log reaches back further."""
        for start in range(0, len(outs), FOLLOW_TICKS):
            self.take(outs[start : start + FOLLOW_TICKS])
            if filter:
                self._write_log(filter, LOGGED)

    def kept_before(self, tick: int) -> int:
        """The last tick, but none after this one, whose figures are kept; 0 is the beginning."""
        place = bisect_right(self._kept, tick, key=lambda kept: kept.tick) - 1
        return self._kept[place].tick if place >= 0 else 0

    def again(self, tick: int, lead: Sequence[TickOutput]) -> Wiretap:
        """One that has seen all ticks before this one, as this has: with its figures where they were kept then.

        `lead` are some ticks before: what a decoder had begun to read.
        """
        other = Wiretap(self._robot)
        other.take(lead)
        other._begin_at(tick, next((kept for kept in self._kept if kept.tick == tick), None))
        other._kept = [kept for kept in self._kept if kept.tick <= tick]
        other._keep_every = self._keep_every
        return other

    def table(self, filter: str = "", log: int = LOGGED) -> WireTable:
        """The figures after the last tick, and so many of the newest frames whose words hold `filter`; commas mean or.

        Without a log the rows are without words too: they cost more than all the counting.
        """
        self._write_log(filter, log)
        now = self._tick + 1
        seconds = max(1, now - self._marks[0]) / 1000.0
        rows = [self._row(row, seconds, log > 0) for row in self._rows.values()]
        rows.sort(key=_place)
        about = {RC: f"{self._rc_name} {self._rc_line}".strip(), CAN: "1 Mbit/s", CORE: f"{CORE_BAUD} 8N1"}
        sums = []
        for wire in ORDER:
            own = [row for row in rows if row.wire == wire]
            frames, rate_hz = sum([row.frames for row in own]), sum([row.rate_hz for row in own])
            load = sum([row.load for row in own])
            sums.append(WireSum(wire, about[wire], frames, rate_hz, load, self._errors[wire]))
        return WireTable(self._tick, tuple(sums), tuple(rows), tuple(self._log)[-log:] if log else ())

    # --- counting ------------------------------------------------------------------------------------------------

    def _take_can(self, frames: Iterable[CanFrame], tick: int) -> None:
        rows, note = self._can, self._unlogged.append
        for can_id, data in frames:
            row = rows.get(can_id)
            if row is None:
                row = self._can_row(can_id)
                if row is None:
                    self._errors[CAN] += 1
                    continue
            if row.count % MEASURED_EVERY == 0:
                row.latest_bits = frame_bits(can_id, data)
            row.count += 1
            row.bits += row.latest_bits
            row.tick, row.data = tick, data
            note((tick, row, data, None))

    def _can_row(self, can_id: int) -> _Row | None:
        row = self._found(CAN, can_id, f"{can_id:03X}", lambda: self._can_words.name(can_id))
        if row is not None:
            self._can[can_id] = row
        return row

    def _take_rc(self, data: bytes, tick: int) -> None:
        self._rc_total += len(data)
        self._rc_tail += data
        if self._rc is None:
            return
        for event in self._rc.feed(data, tick * 1000):
            if isinstance(event, RcNoise):
                self._errors[RC] += event.length
            key = _rc_key(event)
            start = event.offset - (self._rc_total - len(self._rc_tail))
            raw = bytes(self._rc_tail[max(0, start) : start + event.length]) if start + event.length > 0 else b""
            self._count(RC, key, self._rc_name, tick, raw, event.length * self._rc_byte_bits, _rc_words(event))
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
            self._errors[CORE] += event.length
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
        row = self._found(wire, key, key, lambda: name)
        if row is None:
            return
        row.count += 1
        row.bits += bits
        row.tick, row.data, row.words = tick, data, words
        self._unlogged.append((tick, row, data, words))

    def _found(self, wire: str, key: object, shown: str, name: Callable[[], str]) -> _Row | None:
        row = self._rows.get((wire, key))
        if row is None and len(self._rows) < MOST_ROWS:
            row = self._rows[wire, key] = _Row(wire, shown, name(), len(self._marks))
        return row

    def _mark(self, tick: int) -> None:
        self._marks.append(tick)
        for row in self._rows.values():
            row.marks.append((row.count, row.bits))
        if tick % self._keep_every == 0:
            self._keep(tick)

    def _keep(self, tick: int) -> None:
        rows = tuple((key, row.figures()) for key, row in self._rows.items())
        self._kept.append(_Kept(tick, dict(self._errors), rows))
        if len(self._kept) > MOST_KEPT:
            self._keep_every *= 2
            self._kept = [kept for kept in self._kept if kept.tick % self._keep_every == 0]

    def _begin_at(self, tick: int, kept: _Kept | None) -> None:
        """Only what is being read stays of the ticks until here; the figures are those that were kept, or none."""
        self._tick = tick - 1
        self._marks = deque([tick], maxlen=MARKS + 1)
        self._rows, self._can = {}, {}
        self._unlogged.clear()
        self._errors = dict(kept.errors) if kept is not None else dict.fromkeys(ORDER, 0)
        for (wire, key), figures in kept.rows if kept is not None else ():
            row = self._rows[wire, key] = _Row(*figures[:3], 0)
            row.restore(figures)
            if wire == CAN:
                assert isinstance(key, int)
                self._can[key] = row

    # --- telling -------------------------------------------------------------------------------------------------

    def _row(self, row: _Row, seconds: float, in_words: bool) -> WireRow:
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

    def _said(self, row: _Row, data: bytes, words: Words | None) -> str:
        return words() if words is not None else self._can_words.said(int(row.key, 16), data)

    def _write_log(self, filter: str, most: int) -> None:
        wanted = [part for part in filter.lower().split(",") if part]
        if filter != self._filter:
            self._filter = filter
            self._log.clear()
        fresh: list[Logged] = []
        while self._unlogged and len(fresh) < most:
            tick, row, data, words = self._unlogged.pop()
            said = self._said(row, data, words)
            if not wanted or any(part in f"{row.wire} {row.key} {row.name} {said}".lower() for part in wanted):
                fresh.append(Logged(tick, row.wire, row.key, data, said))
        self._unlogged.clear()
        self._log.extend(reversed(fresh))


ORDER = (RC, CAN, CORE)


def _place(row: WireRow) -> tuple[int, str, bool]:
    """By wire and identifier; on the control bus an answer below its request."""
    is_core = row.wire == CORE
    return ORDER.index(row.wire), row.key[2:] if is_core else row.key, is_core and row.key.startswith("<")


_Form: TypeAlias = tuple[Message | None, str, tuple[Mapping[int, str], ...]]
"""A message, its pattern for `%`, and what the values of its fields are called, where any has names."""


class CanWords:
    """Names and contents of the motors' frames: by wheel, in the units of the wire."""

    def __init__(self, robot: Robot) -> None:
        self._family = family(robot)
        self._forms: dict[tuple[int, int], _Form] = {}
        self._names = {0x200 + wheel.can_id: wheel.name for wheel in robot.wheels}
        self._names |= {0x200 + wheel.can_id: f"encoder {wheel.name}" for wheel in robot.dead_wheels}

    def name(self, can_id: int) -> str:
        """Whose frame it is: a wheel's, or what the messages' table calls it."""
        message = self._family.message(can_id)
        if can_id in self._names:
            return self._names[can_id]
        if message in self._family.commands:
            return "to motors 1-4" if message is self._family.commands[0] else "to motors 5-8"
        return message.name.replace("_", " ") if message is not None else "unknown"

    def said(self, can_id: int, data: bytes) -> str:
        """Its fields in the order of its bytes, with their units; nothing where nobody knows them."""
        form = self._forms.get((can_id, len(data)))
        if form is None:
            form = self._forms[can_id, len(data)] = _form(self._family.message(can_id, len(data)))
        message, pattern, words = form
        values = message.decode(data) if message is not None else None
        if values is None:
            return ""
        if words:
            return pattern % tuple(one.get(value, value) for one, value in zip(words, values, strict=True))
        return pattern % values


def _form(message: Message | None) -> _Form:
    """How its values are put into words. A field's width does not change with its value: columns stand still."""
    if message is None:
        return None, "", ()
    fields = message.variables
    units = [_UNITS.get(one.suffix, one.suffix).replace("%", "%%") for one in fields]
    parts = []
    for place, one in enumerate(fields):
        number = f"{one.name} %s" if one.words else "%+6d" if one.signed else "%4d"
        is_last = place + 1 == len(units) or units[place + 1] != units[place]
        parts.append(number + (f" {units[place]}" if is_last and units[place] else ""))
    named = any(one.words for one in fields)
    return message, "  ".join(parts), tuple(one.words for one in fields) if named else ()


_UNITS = {"ma": "mA", "counts": "cnt", "mradps": "mrad/s", "degc": "°C"}


def _rc_key(event: RcEvent) -> str:
    if isinstance(event, RcFrame):
        return "channels"
    if isinstance(event, RcNoise):
        return "noise"
    return "link" if isinstance(event, RcLinkStatistics) else event.kind


def _rc_words(event: RcEvent) -> Words:
    def words() -> str:
        if isinstance(event, RcFrame):
            flags = " FAILSAFE" * event.failsafe + " FRAME LOST" * event.frame_lost
            return " ".join(map(str, event.channels)) + flags
        if isinstance(event, RcNoise):
            return f"{event.length} bytes refused: {event.reason}"
        if isinstance(event, RcLinkStatistics):
            return f"quality {event.uplink_quality_percent} % {event.uplink_rssi_dbm} dBm"
        return event.kind

    return words
