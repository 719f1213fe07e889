"""What a person reads when a run is not as its golden: the cause, the first frame side by side, both traces, the rest.

    differs: speed in the feedback of ESC 3 is scaled by 0.9 from 3.121 s on

At most 40 lines, whatever happened. `as_dict` has the same for machines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.check.align import events_apart
from bench.check.causes import Cause, causes_of_pairs
from bench.check.compare import MAX_LINES, Comparison, Difference
from bench.check.fields import shown, shown_value
from bench.check.lines import RC, STATE
from bench.check.reading import Recording
from bench.check.traces import FieldTrace, Ints, Trace, traces_of_pair
from bench.check.waveform import DOTS, drawn
from bench.check.words import Speaker, number, seconds

_MOST_FIELDS = 8
_MOST_OTHERS = 5
_BEFORE = 0.3
"""Of the waveform lies before the first difference."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One field of the first frame that is not the same; None where a side has no such frame."""

    name: str
    unit: str
    golden: float | int | None
    run: float | int | None


@dataclass(frozen=True, slots=True)
class Picture:
    """Both traces of one field around the first difference, a value for each dot; None where no frame came."""

    title: str
    first_tick: int
    ticks_per_dot: float
    golden: tuple[float | None, ...]
    run: tuple[float | None, ...]
    unit: str
    marked_tick: int

    @property
    def lines(self) -> list[str]:
        """A title, both traces, and where they part."""
        values = [value for value in (*self.golden, *self.run) if value is not None]
        if not values:
            return []
        low, high = min(values), max(values)
        last_tick = self.first_tick + round(DOTS * self.ticks_per_dot)
        scale = f"{number(low)} to {number(high)}{self.unit}" if high > low else f"{number(low)}{self.unit}"
        lines = [f"  {self.title}, {seconds(self.first_tick)} to {seconds(last_tick)}, {scale}"]
        for label, side in (("golden", self.golden), ("run", self.run)):
            for place, row in enumerate(drawn(side, low, high)):
                lines.append(f"  {label if place == 1 else '':7}{row}".rstrip())
        column = int((self.marked_tick - self.first_tick) / self.ticks_per_dot / 2)
        return [*lines, f"  {'':7}{'':{column}}^ {seconds(self.marked_tick)}"]


@dataclass(frozen=True, slots=True)
class Report:
    """A comparison and why it came out so."""

    comparison: Comparison
    causes: tuple[Cause, ...] = ()
    cells: tuple[Cell, ...] = ()
    picture: Picture | None = None

    @property
    def ok(self) -> bool:
        """The verdict."""
        return self.comparison.ok

    @property
    def first(self) -> Difference | None:
        """The comparison's first difference."""
        return self.comparison.first

    @property
    def lines(self) -> list[str]:
        """The whole finding for people, in at most 40 lines."""
        found = self.comparison
        if found.first is None or not self.causes:
            return found.lines
        lead, *others = self.causes
        # Where no cause has a name, the first difference itself says most.
        is_named = lead.kind != "changed"
        lines = [f"differs: {_said(lead) if is_named else found.first.text}"]
        for cause in others[:_MOST_OTHERS]:
            lines.append(f"{'or' if set(cause.wires) & set(lead.wires) else 'also':>7}: {_said(cause)}")
        lines += [f"note: {note}" for note in found.notes]
        lines += [f"first: {found.first.text}"] if is_named else []
        lines += self._table()
        lines += self.picture.lines if self.picture else []
        room = MAX_LINES - len(lines)
        wires = [f"  {wire.text}" for wire in sorted(found.wires, key=lambda wire: wire.first is None)]
        if len(wires) > room:
            wires[max(0, room - 1) :] = [f"  ... and {len(wires) - room + 1} wires more"]
        return (lines + wires)[:MAX_LINES]

    def as_dict(self) -> dict[str, Any]:
        """Plain values for --json: the comparison's own, `causes`, `frame` and `waveform`."""
        picture = self.picture
        return {
            **self.comparison.as_dict(),
            "text": self.lines[0],
            "causes": [cause.as_dict() for cause in self.causes],
            "frame": [
                {"field": cell.name, "unit": cell.unit.strip(), "golden": cell.golden, "run": cell.run}
                for cell in self.cells
            ],
            "waveform": picture
            and {
                "field": picture.title,
                "first_tick": picture.first_tick,
                "ticks_per_value": picture.ticks_per_dot,
                "golden": picture.golden,
                "run": picture.run,
            },
        }

    def _table(self) -> Iterator[str]:
        if not self.cells:
            return
        yield f"  {'':24}{'golden':>20}{'run':>20}"
        for cell in self.cells:
            sides = ("-" if value is None else f"{shown_value(value)}{cell.unit}" for value in (cell.golden, cell.run))
            line = f"  {cell.name:24}" + "".join(f"{side:>20}" for side in sides)
            yield line + ("  <" if cell.golden != cell.run else "")


def report(run: Recording, golden: Recording, comparison: Comparison) -> Report:
    """Why the two differ; just the comparison where they do not, or where only tolerated differences are left."""
    if comparison.first is None:
        return Report(comparison)
    pairs = traces_of_pair(golden, run)
    found = causes_of_pairs(run, golden, pairs)
    lead = next((cause for cause in found if cause.wires[0] in pairs), None)
    if lead is None:
        return Report(comparison, tuple(found))
    wire = comparison.first.wire if comparison.first.wire in lead.wires else lead.wires[0]
    before, after = pairs[wire]
    tick = _first_tick(before, after)
    cells = tuple(_cells(wire, before, after, tick))
    name = _told_field(before, after, lead, tick)
    picture = _picture(Speaker(golden), wire, name, before, after, tick) if name else None
    return Report(comparison, tuple(found), cells, picture)


def _said(cause: Cause) -> str:
    if cause.kind in ("length", "changed"):
        return cause.text
    return f"{cause.text if cause.is_sure else f'perhaps {cause.text}'} ({cause.evidence})"


def _first_tick(golden: Trace, run: Trace) -> int:
    apart = events_apart(golden, run)
    return int(min([*golden.ticks[apart.missing[:1]], *run.ticks[apart.extra[:1]]]))


def _cells(wire: str, golden: Trace, run: Trace, tick: int) -> Iterator[Cell]:
    rows = [int(np.searchsorted(side.ticks, tick)) for side in (golden, run)]
    cells = []
    for name in dict.fromkeys((*golden.fields, *run.fields)):
        values = [_value(side, name, row, tick) for side, row in zip((golden, run), rows, strict=True)]
        if values != [None, None]:
            title, unit = shown("" if wire == STATE else wire, name)
            cells.append(Cell(name if wire == STATE else title, unit if wire != RC else "", *values))
    differing = [cell for cell in cells if cell.golden != cell.run]
    # A row of state.csv has dozens of columns, of which those that differ tell enough.
    yield from (cells if len(cells) <= _MOST_FIELDS else differing)[:_MOST_FIELDS]


def _value(side: Trace, name: str, row: int, tick: int) -> float | int | None:
    one = side.fields.get(name)
    if one is None or row >= len(side) or side.ticks[row] != tick or not one.valid[row]:
        return None
    return int(one.counts[row]) if one.step == 1.0 else float(round(one.counts[row] * one.step, 9))


def _told_field(golden: Trace, run: Trace, lead: Cause, tick: int) -> str | None:
    """The field whose trace shows it best: the cause's own, or the one that moves most steadily."""
    named = [name for name in lead.fields if name in golden.fields and name in run.fields]
    if named:
        return named[0]
    there = (golden.ticks >= tick - 50) & (golden.ticks <= tick + 200)
    moving = {
        name: len(np.unique(one.counts[there]))
        for name, one in golden.fields.items()
        if name in run.fields and not one.turn
    }
    return max(moving, key=lambda name: moving[name]) if moving else None


def _picture(speaker: Speaker, wire: str, name: str, golden: Trace, run: Trace, tick: int) -> Picture | None:
    gaps = np.diff(golden.ticks)
    per_dot = float(max(1.0, np.median(gaps))) if len(gaps) else 1.0
    end = max(int(side.ticks[-1]) for side in (golden, run) if len(side))
    start = max(0, round(min(tick - _BEFORE * DOTS * per_dot, end - DOTS * per_dot)))
    times = (start + per_dot * np.arange(DOTS)).astype(np.int64)
    sides = [_held(side, side.fields[name], times, per_dot) for side in (golden, run)]
    unit = shown("" if wire == STATE else wire, name)[1]
    title = speaker.field(wire, name)
    return Picture(title, start, per_dot, sides[0], sides[1], "" if wire == RC else unit, tick)


def _held(trace: Trace, one: FieldTrace, times: Ints, per_dot: float) -> tuple[float | None, ...]:
    """The field's newest value at each time; None where a frame should have come and none has."""
    rows = np.flatnonzero(one.valid)
    at = np.searchsorted(trace.ticks[rows], times, "right") - 1
    return tuple(
        float(one.counts[rows[row]] * one.step) if row >= 0 and time - trace.ticks[rows[row]] < 1.5 * per_dot else None
        for row, time in zip(at.tolist(), times.tolist(), strict=True)
    )
