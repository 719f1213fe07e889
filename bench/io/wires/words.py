"""Frames in words: names and contents of what the motors and the receiver send."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

from bench.canbus.table import Message
from bench.config import Robot
from bench.messages import RcEvent, RcFrame, RcLinkStatistics, RcNoise
from bench.motors import family

Words: TypeAlias = Callable[[], str]
"""A frame's contents, put into words only where somebody reads them."""
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
        number = "%s" if one.words else "%+6d" if one.signed else "%4d"
        is_last = place + 1 == len(units) or units[place + 1] != units[place]
        parts.append(number + (f" {units[place]}" if is_last and units[place] else ""))
    named = any(one.words for one in fields)
    return message, "  ".join(parts), tuple(one.words for one in fields) if named else ()


_UNITS = {"ma": "mA", "counts": "cnt", "mradps": "mrad/s", "degc": "°C"}


def rc_key(event: RcEvent) -> str:
    """Which kind of event it is: the key of its row."""
    if isinstance(event, RcFrame):
        return "channels"
    if isinstance(event, RcNoise):
        return "noise"
    return "link" if isinstance(event, RcLinkStatistics) else event.kind


def rc_words(event: RcEvent) -> Words:
    """Its contents in raw values of the wire."""

    def words() -> str:
        if isinstance(event, RcFrame):
            flags = " FAILSAFE" * event.failsafe + " FRAME LOST" * event.frame_lost
            return " ".join(map(str, event.channels)) + flags
        if isinstance(event, RcNoise):
            return f"{event.length} byte{'s' * (event.length != 1)} refused: {event.reason}"
        if isinstance(event, RcLinkStatistics):
            return f"quality {event.uplink_quality_percent} % {event.uplink_rssi_dbm} dBm"
        return event.kind

    return words
