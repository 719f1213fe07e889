"""The newest frames of all wires in words, those that a filter lets pass."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from itertools import chain, islice

from bench.io.wires.counts import Row
from bench.io.wires.table import Logged
from bench.io.wires.words import Words
from bench.messages import CanFrame

LOGGED = 128
"""So many of the newest frames are kept in words."""
LOOKED_AT = 256
"""And so many are looked through for each picture; where a filter leaves less, older ones are passed over."""


class WireLog:
    """`note` all frames in their order, then `write`: (tick, row, data, words), or (tick, frames) of the motors' bus.

    `can_row` gives an identifier's row, None where it has none; `said` puts a frame into words.
    """

    def __init__(self, can_row: Callable[[int], Row | None], said: Callable[[Row, bytes, Words | None], str]) -> None:
        self.written: deque[Logged] = deque(maxlen=LOGGED)
        """From old to new."""
        self._can_row = can_row
        self._said = said
        self._filter = ""
        self._unwritten: deque[tuple[int, Row, bytes, Words | None] | tuple[int, Sequence[CanFrame]]] = deque(
            maxlen=LOOKED_AT
        )
        self._looked_through = self._unwritten.copy()
        """Kept for another filter: where time stands still, nothing new comes that it could find."""
        self.note = self._unwritten.append

    def write(self, filter: str, most: int) -> None:
        """Put what was noted into words, at most so many; with another filter than before, begin anew. None: wait."""
        if not most:
            return
        wanted = [part for part in filter.lower().split(",") if part]
        again = filter != self._filter
        if again:
            self._filter = filter
            self.written.clear()
        fresh: list[Logged] = []
        for tick, row, data, words in islice(self._newest_first(again), LOOKED_AT):
            said = self._said(row, data, words)
            if not wanted or any(part in f"{row.wire} {row.key} {row.name} {said}".lower() for part in wanted):
                fresh.append(Logged(tick, row.wire, row.key, data, said))
                if len(fresh) == most:
                    break
        self._looked_through.extend(self._unwritten)
        self._unwritten.clear()
        self.written.extend(reversed(fresh))

    def _newest_first(self, again: bool) -> Iterator[tuple[int, Row, bytes, Words | None]]:
        for noted in chain(reversed(self._unwritten), reversed(self._looked_through) if again else ()):
            if len(noted) == 4:
                yield noted
                continue
            tick, frames = noted
            for can_id, data in reversed(frames):
                row = self._can_row(can_id)
                if row is not None:
                    yield tick, row, data, None
