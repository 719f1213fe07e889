"""The text of the logs, both ways: a block of ticks to lines, a line to (tick, wire, data). No file is opened here.

Writing is what a run pays for in every tick, so it is done a block at a time, column by column, and nothing is
formatted twice. Reading takes the same text and no other, so that what was read and written again is the same bytes.
"""

from __future__ import annotations

import math
import re
from binascii import unhexlify
from collections import Counter
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TypeAlias

from bench.messages import CanFrame, StateRow

CAN_LOG, RC_LOG, SLAMWARE_LOG, STATE_CSV = "can.log", "rc.log", "slamware.log", "state.csv"
BUS_LOG = "bus.log"
"""Where the CAN bus takes its time: the same frames and those of other nodes, each when it was through, to the us."""
CORE_TO_BASE, BASE_TO_CORE = "slamware core->base", "slamware base->core"
RC, STATE = "rc", "state"

Frames: TypeAlias = tuple[CanFrame, ...]
"""What one side sent in one tick."""
Entry: TypeAlias = tuple[int, str, bytes]
"""One line of a log: tick, name of the wire, what crossed it (of state.csv: the row's text)."""

FEEDBACK_IDS = frozenset((*range(0x201, 0x209), *range(0x301, 0x309)))
"""What ESCs, encoder boards and gyros send. Every other frame on the bus is the base's."""

EXPECTED = {
    CAN_LOG: "(0.001000) can0 200#0258025802580000",
    RC_LOG: "(0.010000) rc0 > AA 08 00",
    SLAMWARE_LOG: "(0.050000) slamware0 > 10 02 F8 30 DA, or < for base to core",
    STATE_CSV: "the time in seconds with six decimals, then the other columns, as UTF-8 text",
}
"""What a line looks like, for the sentence that refuses another one."""


# --- writing: a block of ticks -----------------------------------------------------------------------------------

_MILLIS = tuple(f".{milli:03d}000)" for milli in range(1000))


def stamp(tick: int) -> str:
    """What a line begins with: the time of a tick."""
    return f"({tick // 1000}{_MILLIS[tick % 1000]}"


_EIGHT = {8}


class _CanIds(dict[int, str]):
    """The text of an identifier, made once."""

    def __missing__(self, can_id: int) -> str:
        text = self[can_id] = f"{can_id:03X}#"
        return text


_CAN_IDS = _CanIds()


def can_lines(ticks: Sequence[int], commands: Sequence[Frames], feedback: Sequence[Frames]) -> str:
    """Candump lines: in each tick the commands, then the feedback."""
    return _uniform_can_lines(ticks, commands, feedback) or _any_can_lines(ticks, commands, feedback)


def _uniform_can_lines(ticks: Sequence[int], commands: Sequence[Frames], feedback: Sequence[Frames]) -> str:
    """The lines of a block of which every tick has the same identifiers and 8 bytes in each frame; or nothing.

    Nearly every block is one. A line then differs from that of another second in its seconds and its data alone, and
    the block's data is put into hex at once: three quarters of what a line at a time takes.
    """
    first_tick, count = ticks[0], len(ticks)
    second, milli = divmod(first_tick, 1000)
    if milli + count > 1000 or ticks[-1] != first_tick + count - 1:
        return ""
    if len(set(map(len, commands))) > 1 or len(set(map(len, feedback))) > 1:
        return ""
    frames: list[CanFrame] = []
    for sent, answered in zip(commands, feedback, strict=True):
        frames += sent
        frames += answered
    if not frames:
        return ""
    can_ids, contents = zip(*frames, strict=True)
    a_tick = can_ids[: len(can_ids) // count]
    if can_ids != a_tick * count or set(map(len, contents)) != _EIGHT:
        return ""
    parts = [f"\n({second}"] * (3 * len(frames))
    parts[1::3] = _middles(a_tick, milli, count)
    parts[2::3] = b"".join(contents).hex("\n", 8).upper().split("\n")
    return "".join(parts)[1:] + "\n"


@lru_cache(maxsize=64)
def _middles(can_ids: tuple[int, ...], milli: int, count: int) -> list[str]:
    """What stands between the second and the data in the lines of `count` ticks from this millisecond on."""
    return [f"{milli} can0 {_CAN_IDS[can_id]}" for milli in _MILLIS[milli:][:count] for can_id in can_ids]


def _any_can_lines(ticks: Sequence[int], commands: Sequence[Frames], feedback: Sequence[Frames]) -> str:
    ids, millis = _CAN_IDS, _MILLIS
    lines: list[str] = []
    add = lines.append
    for tick, sent, answered in zip(ticks, commands, feedback, strict=True):
        stamp = f"({tick // 1000}{millis[tick % 1000]} can0 "
        for can_id, data in sent + answered:
            add(f"{stamp}{ids[can_id]}{data.hex().upper()}\n")
    return "".join(lines)


def bus_lines(frames: Sequence[tuple[int, CanFrame]]) -> str:
    """Candump lines of a bus that takes its time: (when it was through in us, frame)."""
    return "".join(
        f"({us // 1_000_000}.{us % 1_000_000:06d}) can0 {can_id:03X}#{data.hex().upper()}\n"
        for us, (can_id, data) in frames
    )


def rc_lines(ticks: Sequence[int], rc: Sequence[bytes]) -> str:
    """A line for each tick in which RC bytes reached the base."""
    return "".join([_serial_line(tick, "rc0 >", data) for tick, data in zip(ticks, rc, strict=True) if data])


def slamware_lines(ticks: Sequence[int], core_to_base: Sequence[bytes], base_to_core: Sequence[bytes]) -> str:
    """Up to two lines a tick: what the core sent, what the base sent."""
    lines = []
    for tick, asked, answered in zip(ticks, core_to_base, base_to_core, strict=True):
        if asked:
            lines.append(_serial_line(tick, "slamware0 >", asked))
        if answered:
            lines.append(_serial_line(tick, "slamware0 <", answered))
    return "".join(lines)


def _serial_line(tick: int, wire: str, data: bytes) -> str:
    return f"({tick // 1000}{_MILLIS[tick % 1000]} {wire} {data.hex(' ').upper()}\n"


class StateFormat:
    """Rows of state.csv. One % operation makes a row: a format is kept for each sequence of column types."""

    def __init__(self, columns: int) -> None:
        self._columns = columns
        self._formats: dict[tuple[type, ...], str] = {}

    def lines(self, rows: Sequence[StateRow]) -> str:
        """The lines of these rows. Raises ValueError for a row that does not fit the header."""
        formats = self._formats
        lines = []
        for row in rows:
            kinds = tuple(map(type, row))
            form = formats.get(kinds) or self._new_format(kinds)
            lines.append(form % row)
        text = "".join(lines).replace("-0.000000", "0.000000")
        # A separator inside a cell would shift every column behind it.
        if text.count(",") != len(rows) * (self._columns - 1) or text.count("\n") != len(rows) or '"' in text:
            raise ValueError("a comma, quote or line break cannot stand in a cell of state.csv")
        return text

    def _new_format(self, kinds: tuple[type, ...]) -> str:
        if len(kinds) != self._columns:
            raise ValueError(f"a state row has {len(kinds)} values for {self._columns} columns")
        marks = ("%.6f" if issubclass(kind, float) else "%d" if issubclass(kind, int) else "%s" for kind in kinds)
        form = self._formats[kinds] = ",".join(marks) + "\n"
        return form


# --- reading: one line -------------------------------------------------------------------------------------------

_SECONDS = rb"(0|[1-9][0-9]*)\.([0-9]{3})000"
_STAMP = rb"\(" + _SECONDS + rb"\) "
_HEX = rb"((?:[0-9A-F]{2} )*[0-9A-F]{2})"
_match_can = re.compile(_STAMP + rb"can0 ([0-7][0-9A-F]{2})#((?:[0-9A-F]{2}){0,8})").fullmatch
_match_rc = re.compile(_STAMP + rb"rc0 > " + _HEX).fullmatch
_match_slamware = re.compile(_STAMP + rb"slamware0 ([<>]) " + _HEX).fullmatch
_match_state = re.compile(_SECONDS + rb"(?:,[^,]*)*").fullmatch


class _CanWires(dict[bytes, str]):
    """The wire's name for an identifier as it is written, made once."""

    def __missing__(self, can_id: bytes) -> str:
        wire = self[can_id] = f"can 0x{can_id.decode('ascii', 'replace')}"
        return wire


_CAN_WIRES = _CanWires()
_SERIAL_WIRES = {b">": CORE_TO_BASE, b"<": BASE_TO_CORE}


def _can_entry(line: bytes) -> Entry | None:
    match = _match_can(line)
    if match is None:
        return None
    seconds, millis, can_id, data = match.groups()
    return int(seconds) * 1000 + int(millis), _CAN_WIRES[can_id], unhexlify(data)


def _rc_entry(line: bytes) -> Entry | None:
    match = _match_rc(line)
    return match and (int(match[1]) * 1000 + int(match[2]), RC, bytes.fromhex(match[3].decode()))


def _slamware_entry(line: bytes) -> Entry | None:
    match = _match_slamware(line)
    if match is None:
        return None
    return int(match[1]) * 1000 + int(match[2]), _SERIAL_WIRES[match[3]], bytes.fromhex(match[4].decode())


def _state_entry(line: bytes) -> Entry | None:
    match = _match_state(line)
    try:
        line.decode("utf-8")
    except UnicodeDecodeError:
        return None
    return match and (int(match[1]) * 1000 + int(match[2]), STATE, line)


PARSERS: dict[str, Callable[[bytes], Entry | None]] = {
    CAN_LOG: _can_entry,
    RC_LOG: _rc_entry,
    SLAMWARE_LOG: _slamware_entry,
    STATE_CSV: _state_entry,
}
"""What reads a line of each log; None where the line is none of it."""


def can_id_of(wire: str) -> int:
    """The identifier in the name of a CAN wire."""
    return int(wire[4:], 16)


def frames_by_wire(name: str, lines: list[bytes]) -> dict[str, int]:
    """How many frames some lines of a log hold, by wire. Nothing is parsed but the wire."""
    if name == CAN_LOG:
        found = Counter([line.partition(b"#")[0][-3:] for line in lines])
        return {_CAN_WIRES[key]: count for key, count in found.items()}
    if name == SLAMWARE_LOG:
        found = Counter([line.partition(b"0 ")[2][:1] for line in lines])
        return {wire: found[key] for key, wire in _SERIAL_WIRES.items()}
    return {RC if name == RC_LOG else STATE: len(lines)}


def cell_value(cell: str) -> float | int | str:
    """A cell of state.csv: a whole number, a number with decimals, or text. What is not finite stays text."""
    for kind in (float,) if "." in cell else (int, float):
        try:
            value = kind(cell)
        except ValueError:
            continue
        return value if math.isfinite(value) else cell
    return cell
