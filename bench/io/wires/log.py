"""The newest frames of all wires in words, those that a filter lets pass."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from bench.io.wires.counts import Row
from bench.io.wires.table import Logged
from bench.io.wires.words import Words

LOGGED = 128
"""So many of the newest frames are kept in words."""
LOOKED_AT = 256
"""And so many are looked through for each picture; where a filter leaves less, older ones are passed over."""


class WireLog:
    """`note` every frame as (tick, row, data, words), then `write`; `said` puts a frame into words."""

    def __init__(self, said: Callable[[Row, bytes, Words | None], str]) -> None:
        self.written: deque[Logged] = deque(maxlen=LOGGED)
        """From old to new."""
        self._said = said
        self._filter = ""
        self._unwritten: deque[tuple[int, Row, bytes, Words | None]] = deque(maxlen=LOOKED_AT)
        self.note = self._unwritten.append

    def write(self, filter: str, most: int) -> None:
        """Put what was noted into words, at most so many; with another filter than before, begin anew."""
        wanted = [part for part in filter.lower().split(",") if part]
        if filter != self._filter:
            self._filter = filter
            self.written.clear()
        fresh: list[Logged] = []
        while self._unwritten and len(fresh) < most:
            tick, row, data, words = self._unwritten.pop()
            said = self._said(row, data, words)
            if not wanted or any(part in f"{row.wire} {row.key} {row.name} {said}".lower() for part in wanted):
                fresh.append(Logged(tick, row.wire, row.key, data, said))
        self._unwritten.clear()
        self.written.extend(reversed(fresh))
