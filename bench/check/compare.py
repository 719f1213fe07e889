"""Two recordings side by side: what differs first, on which wire, in which field, and by how much.

Bytes first: equal files are not even split into lines, and equal lines are not parsed. What is left is decoded and
reported in time order; within one tick in the order of cause: what reached the base, what it sent, what came of it.
This module says what differs. Why it differs (late, scaled, swapped) is another question, to be asked of two
recordings and a `Comparison`.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cache, partial
from itertools import zip_longest
from typing import Any, TypeAlias

from bench.canbus.table import Family
from bench.check.fields import Value, distance, fields_of_pair, shown, shown_value, tolerance
from bench.check.lines import (
    BASE_TO_CORE,
    CAN_LOG,
    CORE_TO_BASE,
    FEEDBACK_IDS,
    RC,
    STATE,
    STATE_CSV,
    can_id_of,
    frames_by_wire,
)
from bench.check.reading import Recording
from bench.check.recording import LOGS, PROFILE_TOML, ROBOT_TOML, RunInfo

WireData: TypeAlias = tuple[str, bytes]
"""Name of the wire, what crossed it."""

MAX_LINES = 40
_MAX_FIELDS = 6


@dataclass(frozen=True, slots=True)
class Difference:
    """One field of one frame that is not as in the golden. `expected` or `got` is None where there is no such thing."""

    tick: int
    wire: str
    field: str
    expected: Value
    got: Value

    @property
    def text(self) -> str:
        """The sentence for people."""
        if self.field == "ticks":
            return f"the run has {self.got} ticks, the golden {self.expected}; compared up to {_at(self.tick)}"
        where = f"at {_at(self.tick)} (tick {self.tick}) {self.wire}:"
        if self.field == "frame" and self.expected is None:
            return f"{where} the run has {self.got} here, the golden has nothing"
        if self.field == "frame" and self.got is None:
            return f"{where} the golden has {self.expected} here, the run has nothing"
        name, unit = shown(self.wire, self.field)
        return f"{where} {name} expected {shown_value(self.expected)}{unit}, got {shown_value(self.got)}{unit}"


@dataclass(slots=True)
class WireSummary:
    """All of one wire: how many frames (rows of state) the golden has, and how many differ, are missing or too many."""

    wire: str
    frames: int
    differing: int = 0
    first: Difference | None = None
    largest: dict[str, float] = field(default_factory=dict)
    """Field -> largest distance from the golden, tolerated ones too."""

    @property
    def text(self) -> str:
        """One line for people."""
        text = f"{self.wire:20} {self.frames} compared, "
        if self.first is None:
            text += "none differ" if self.largest else "the same"
        else:
            text += f"{self.differing} differ, first at {_at(self.first.tick)}"
        largest = []
        for key, apart in list(self.largest.items())[:_MAX_FIELDS]:
            name, unit = shown(self.wire, key)
            largest.append(f"{name} {shown_value(apart)}{unit}")
        if len(self.largest) > _MAX_FIELDS:
            largest.append(f"and {len(self.largest) - _MAX_FIELDS} fields more")
        return f"{text}; largest: {', '.join(largest)}" if largest else text


@dataclass(frozen=True, slots=True)
class Comparison:
    """What `compare` found. `identical`: not a byte differs. `ok`: nothing differs beyond the tolerances."""

    identical: bool
    exact: bool
    """No tolerance was granted."""
    ticks: int
    """How many ticks both sides have."""
    first: Difference | None
    wires: tuple[WireSummary, ...]
    """In the order of cause; a log that is the same in both is one wire (can, slamware)."""
    notes: tuple[str, ...] = ()
    """Sentences on what the two runs are: another robot file, another seed, cut short."""

    @property
    def ok(self) -> bool:
        """The verdict."""
        return self.first is None

    @property
    def lines(self) -> list[str]:
        """The whole finding for people, in at most 40 lines."""
        what = f"{_at(self.ticks)}, {sum(wire.frames for wire in self.wires)} frames and rows"
        if self.first is not None:
            lines = [f"differs: {self.first.text}"]
        else:
            same = "the same" if self.exact else "the same within the tolerances"
            lines = [f"{'identical' if self.identical else same}: {what}"]
        lines += [f"note: {note}" for note in self.notes]
        if not self.identical:
            lines += [f"  {wire.text}" for wire in self.wires]
        if len(lines) > MAX_LINES:
            lines[MAX_LINES - 1 :] = [f"  ... and {len(lines) - MAX_LINES + 1} lines more"]
        return lines

    def as_dict(self) -> dict[str, Any]:
        """Plain values for --json."""
        return {"ok": self.ok, "text": self.lines[0], **asdict(self), "causes": []}


def compare(run: Recording, golden: Recording, tolerances: Mapping[str, float] | None = None) -> Comparison:
    """Hold a run against a golden: exactly, or by decoded field with tolerances (`fields.TOLERANCES` or the like).

    Where one is longer, the common part is compared, and the length is a difference of its own after all others.
    Raises RecordingError where a line that differs cannot be read.
    """
    end = min(run.ticks, golden.ticks)
    tolerance_of = None if tolerances is None else cache(partial(tolerance, tolerances=tolerances))
    finder = _Finder(tolerance_of, (golden.state_columns, run.state_columns), golden.family)
    identical = run.ticks == golden.ticks
    for name in LOGS:
        if run.content(name) == golden.content(name):
            header = 1 if name == STATE_CSV else 0
            finder.add_wire(name.partition(".")[0], golden.content(name).count(b"\n") - header)
            continue
        identical = False
        if name == CAN_LOG and finder.compare_can(golden, run, end):
            continue
        expected, got = _Log(golden, name, end), _Log(run, name, end)
        for wire, frames in frames_by_wire(name, expected.lines[: expected.end]).items():
            finder.add_wire(wire, frames)
        if name == STATE_CSV:
            finder.compare_columns()
        for tick, before, after in _different_ticks(expected, got):
            finder.compare_tick(tick, before, after)
    wires = sorted(finder.wires.values(), key=lambda summary: rank(summary.wire))
    firsts = [wire.first for wire in wires if wire.first is not None]
    if run.ticks != golden.ticks:
        firsts.append(Difference(end, "run", "ticks", golden.ticks, run.ticks))
    # min() keeps the first of equals, and the wires stand in the order of cause.
    first = min(firsts, key=lambda difference: difference.tick, default=None)
    return Comparison(identical, tolerances is None, end, first, tuple(wires), tuple(_notes(run, golden)))


# --- which lines are not the same --------------------------------------------------------------------------------


class _Log:
    """One log of one recording up to a tick, and how far it has been compared."""

    def __init__(self, recording: Recording, name: str, end_tick: int) -> None:
        self.lines = recording.lines(name)
        self.entry = partial(recording.entry, name)
        self.end = bisect_left(range(len(self.lines)), end_tick, key=lambda index: self.entry(index)[0])
        self.at = 0

    def next_tick(self) -> float:
        return self.entry(self.at)[0] if self.at < self.end else math.inf

    def take(self, tick: int) -> list[WireData]:
        """What is left of this tick."""
        taken = []
        while self.at < self.end:
            found, wire, data = self.entry(self.at)
            if found != tick:
                break
            taken.append((wire, data))
            self.at += 1
        return taken


def _different_ticks(expected: _Log, got: _Log) -> Iterator[tuple[int, list[WireData], list[WireData]]]:
    """Every tick whose lines are not the same, with what is left of it from the first such line on."""
    while True:
        before, after = expected.lines, got.lines
        i, j = expected.at, got.at
        while i < expected.end and j < got.end and before[i] == after[j]:
            i += 1
            j += 1
        expected.at, got.at = i, j
        tick = min(expected.next_tick(), got.next_tick())
        if tick == math.inf:
            return
        tick = int(tick)
        yield tick, expected.take(tick), got.take(tick)


# --- what differs in them ----------------------------------------------------------------------------------------


class _Finder:
    """Collects differences by wire."""

    def __init__(
        self,
        tolerance_of: Callable[[str], float] | None,
        columns: tuple[tuple[str, ...], tuple[str, ...]],
        family: Family,
    ) -> None:
        self.wires: dict[str, WireSummary] = {}
        self._tolerance_of, self._columns, self._family = tolerance_of, columns, family

    def add_wire(self, wire: str, frames: int) -> None:
        self.wires[wire] = WireSummary(wire, frames)

    def compare_columns(self) -> None:
        """Rows are compared by column name; other columns are a difference of their own, at the start."""
        before, after = self._columns
        if before != after:
            self._found(0, STATE, "columns", " ".join(before), " ".join(after))

    def compare_can(self, golden: Recording, run: Recording, end: int) -> bool:
        """The whole can.log at once; False, and nothing is done, where one of them has to be read line by line."""
        sides = golden.can_arrays, run.can_arrays
        if sides[0] is None or sides[1] is None:
            return False
        # Imported here: numpy takes longer to load than two equal logs to be found equal.
        from bench.check.can_compare import findings, tick_of

        before, after = sides[0].until(end), sides[1].until(end)
        for name, wire in findings(before, after, self._family, self._tolerance_of).items():
            self.wires[name] = summary = WireSummary(name, wire.frames, wire.differing, None, wire.largest)
            if wire.first_tick is not None:
                there = _without_start(*(tick_of(side, wire.first_tick) for side in (before, after)))
                alone = _Finder(self._tolerance_of, self._columns, self._family)
                alone.compare_tick(wire.first_tick, *there)
                summary.first = alone.wires[name].first
        return True

    def compare_tick(self, tick: int, expected: list[WireData], got: list[WireData]) -> None:
        """What is left of one tick on both sides: frames of the same wire are held against each other in order."""
        before, after = _by_wire(expected), _by_wire(got)
        if before == after:
            # The same frames in another order: on a bus that is another behaviour.
            orders = [" ".join(wire.removeprefix("can ") for wire, _ in side) for side in (expected, got)]
            self._found(tick, expected[0][0], "order", *orders)
            return
        for wire in sorted({**before, **after}, key=rank):
            for one, other in zip_longest(before.get(wire, ()), after.get(wire, ())):
                if one is None or other is None:
                    self._found(tick, wire, "frame", _whole(wire, one), _whole(wire, other))
                elif one != other:
                    self._compare_frame(tick, wire, one, other)

    def _compare_frame(self, tick: int, wire: str, expected: bytes, got: bytes) -> None:
        before, after = fields_of_pair(wire, expected, got, self._columns, self._family)
        beyond = []
        for name, one in before.items():
            other = after[name]
            if one == other and type(one) is type(other):
                continue
            apart = distance(name, one, other)
            if apart is not None:
                largest = self._summary(wire).largest
                largest[name] = max(apart, largest.get(name, 0.0))
            if self._tolerance_of is None or apart is None or apart > self._tolerance_of(name):
                beyond.append((name, one, other))
        if beyond:
            self._found(tick, wire, *beyond[0])

    def _found(self, tick: int, wire: str, name: str, expected: Value, got: Value) -> None:
        summary = self._summary(wire)
        summary.differing += 1
        if summary.first is None:
            summary.first = Difference(tick, wire, name, expected, got)

    def _summary(self, wire: str) -> WireSummary:
        return self.wires.setdefault(wire, WireSummary(wire, 0))


def _without_start(expected: list[WireData], got: list[WireData]) -> tuple[list[WireData], list[WireData]]:
    """What is left of a tick from the first frame on that is not the same."""
    same = 0
    while same < min(len(expected), len(got)) and expected[same] == got[same]:
        same += 1
    return expected[same:], got[same:]


def _by_wire(frames: list[WireData]) -> dict[str, list[bytes]]:
    found: dict[str, list[bytes]] = {}
    for wire, data in frames:
        found.setdefault(wire, []).append(data)
    return found


def rank(wire: str) -> tuple[int, str]:
    """The order of cause within one tick: inputs, commands and answers, then what came of them."""
    if wire.startswith("can 0x"):
        return (4 if can_id_of(wire) in FEEDBACK_IDS else 2), wire
    return {RC: 0, CORE_TO_BASE: 1, BASE_TO_CORE: 3}.get(wire, 5), wire


def _whole(wire: str, data: bytes | None) -> str | None:
    if data is None:
        return None
    return data.decode() if wire == STATE else data.hex(" ").upper() or "an empty frame"


def _notes(run: Recording, golden: Recording) -> Iterator[str]:
    """What is worth knowing before looking for a cause: the two runs were not made from the same things."""
    for item in fields(RunInfo):
        of_golden, of_run = getattr(golden.info, item.name), getattr(run.info, item.name)
        if of_golden != of_run:
            yield f"{item.name}: {of_golden} in the golden, {of_run} in the run"
    for name in (ROBOT_TOML, PROFILE_TOML):
        files = [side.directory / name for side in (golden, run)]
        there = [path.exists() for path in files]
        if there[0] != there[1] or (all(there) and golden.content(name) != run.content(name)):
            yield f"the two have another {name}"
    for side, recording in (("golden", golden), ("run", run)):
        for note in recording.notes:
            yield f"{side}: {note}"


def _at(tick: int) -> str:
    return f"{tick // 1000}.{tick % 1000:03d} s"
