"""Counters for each kind of frame: how many, how many a second, how many bits; and what they were, once a second."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from bench.io.wires.table import ORDER
from bench.io.wires.words import Words

MARK_TICKS, MARKS = 100, 10
"""Rates are over the last second, counted in tenths of it."""
MOST_ROWS = 96
"""A bus full of strangers fills no memory: what comes after these is only counted."""
KEPT_EVERY_TICKS, MOST_KEPT = 1000, 3600
"""The figures are kept once a second for whoever looks back; after an hour every second time."""

Figures: TypeAlias = tuple[str, str, str, int, int, int, int, bytes, Words | None]


class Row:
    """The counters of a `WireRow`. `bits` are those on the wire."""

    __slots__ = ("bits", "count", "data", "key", "latest_bits", "marks", "name", "tick", "wire", "words")

    def __init__(self, wire: str, key: str, name: str, marks: int) -> None:
        self.wire, self.key, self.name = wire, key, name
        self.count = self.bits = self.latest_bits = self.tick = 0
        self.data = b""
        self.words: Words | None = None
        # (count, bits) at each mark of the last second; a row that is new had nothing before.
        self.marks: deque[tuple[int, int]] = deque([(0, 0)] * marks, maxlen=MARKS + 1)

    def figures(self) -> Figures:
        """All that is to be kept of it."""
        return (
            self.wire, self.key, self.name, self.count, self.bits, self.latest_bits, self.tick, self.data, self.words
        )  # fmt: skip

    @classmethod
    def restored(cls, figures: Figures) -> Row:
        """One that goes on from there."""
        row = cls(*figures[:3], 0)
        row.count, row.bits, row.latest_bits, row.tick, row.data, row.words = figures[3:]
        row.marks.append((row.count, row.bits))
        return row


class Kept(NamedTuple):
    """The figures of all rows before a tick."""

    tick: int
    errors: dict[str, int]
    rows: tuple[tuple[tuple[str, object], Figures], ...]


class Counts:
    """The rows of all wires. `errors` counts for each wire what became no row's frame."""

    def __init__(self) -> None:
        self.rows: dict[tuple[str, object], Row] = {}
        self.errors = dict.fromkeys(ORDER, 0)
        self.kept: list[Kept] = []
        self._keep_every_ticks = KEPT_EVERY_TICKS
        self._marks: deque[int] = deque([0], maxlen=MARKS + 1)

    def row(self, wire: str, key: object, shown: str, name: Callable[[], str]) -> Row | None:
        """The row of a key, new or not; None where there is no room for another."""
        row = self.rows.get((wire, key))
        if row is None and len(self.rows) < MOST_ROWS:
            row = self.rows[wire, key] = Row(wire, shown, name(), len(self._marks))
        return row

    def mark(self, tick: int) -> None:
        """A tenth of a second has passed: `tick` ticks have run."""
        self._marks.append(tick)
        for row in self.rows.values():
            row.marks.append((row.count, row.bits))
        if tick % self._keep_every_ticks == 0:
            self._keep(tick)

    def seconds(self, tick: int) -> float:
        """How long rates are counted over, before this tick."""
        return max(1, tick - self._marks[0]) / 1000.0

    def kept_before(self, tick: int) -> int:
        """The last tick, but none after this one, whose figures are kept; 0 is the beginning."""
        place = bisect_right(self.kept, tick, key=lambda kept: kept.tick) - 1
        return self.kept[place].tick if place >= 0 else 0

    def before(self, tick: int) -> Counts:
        """The figures that were kept before this tick, to go on from; none where none were."""
        other = Counts()
        other._marks = deque([tick], maxlen=MARKS + 1)
        other.kept = [kept for kept in self.kept if kept.tick <= tick]
        other._keep_every_ticks = self._keep_every_ticks
        if other.kept and other.kept[-1].tick == tick:
            kept = other.kept[-1]
            other.errors = dict(kept.errors)
            other.rows = {key: Row.restored(figures) for key, figures in kept.rows}
        return other

    def _keep(self, tick: int) -> None:
        rows = tuple((key, row.figures()) for key, row in self.rows.items())
        self.kept.append(Kept(tick, dict(self.errors), rows))
        if len(self.kept) > MOST_KEPT:
            self._keep_every_ticks *= 2
            self.kept = [kept for kept in self.kept if kept.tick % self._keep_every_ticks == 0]
