"""Why a run differs from its golden: late, dropped, swapped, scaled and the like, ranked, with what speaks for each.

    found = causes(run, golden)
    found[0].text       "feedback of ESC 1 is scaled by 0.9 from 3.120 s on"

Every cause is a guess that is put to the test: it predicts the run from the golden, and its score is the share of the
differences that are gone then. What fits nearly anything (noise, single missing frames) counts less than what predicts
every byte. The wire that differs first, in the order of cause, leads; what other wires show stands behind it.

In a closed loop one fault soon changes everything. Where nothing explains a wire's whole story, its first seconds are
asked alone, and count less.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.check import words
from bench.check.align import (
    ONE_BY_ONE,
    copies,
    events_apart,
    late_by_turns,
    likely_lags,
    paired_rows,
    period_ticks,
    shifted,
)
from bench.check.compare import rank
from bench.check.lines import CAN_LOG
from bench.check.patterns import Pattern, Stretch, late, patterns
from bench.check.reading import Recording
from bench.check.traces import FieldTrace, Ints, Trace, can_of, traces_of_pair

Mask = NDArray[np.bool_]
Pairs = Mapping[str, tuple[Trace, Trace]]

GOOD = 0.6
"""A score from which a cause is said without a "perhaps"."""
_BEYOND_DOUBT = 0.9
"""A score from which the next best explanation of the same wire is not worth a line."""
_SETTLED = 0.965
"""A score from which times explain it all, and values are not looked at."""
_EARLY = ((400, 0.9), (100, 0.8), (30, 0.7))
"""Ticks from the first difference on, and what an explanation of these alone is worth."""
_FEWEST = 8
"""Fewer differences than this in the first moments say nothing."""
_FEWEST_ROWS = 3
"""What two frames have in common is chance: lost or doubled they may be, but not late, stuck or exchanged."""
_ASKED = 200
_MOST = 8


@dataclass(frozen=True, slots=True)
class Cause:
    """One explanation. `fields` is empty where whole frames are meant, `last_tick` None where it lasts to the end."""

    kind: str
    wires: tuple[str, ...]
    fields: tuple[str, ...]
    first_tick: int
    last_tick: int | None
    amount: float
    """What the kind has a number for: ticks late, frames, a factor, an offset or step in the field's unit."""
    score: float
    """0 to 1: the share of the wire's differences that it explains, less what its easiness costs."""
    differing: int
    left: int
    """Of so many differences so many stay unexplained."""
    text: str = ""
    usual: float = 0.0
    """What the golden has in place of the amount, where a sentence needs both: its period."""

    @property
    def is_sure(self) -> bool:
        """Whether it explains most of what it is said to explain."""
        return self.score >= GOOD

    @property
    def evidence(self) -> str:
        """What speaks for it, as a clause."""
        if not self.left:
            return "explains every difference there"
        return f"explains {math.floor(1000 * (1 - self.left / self.differing)) / 10} % of the differences there"

    def as_dict(self) -> dict[str, Any]:
        """Plain values for --json."""
        return {**asdict(self), "score": round(self.score, 3), "evidence": self.evidence}


def causes(run: Recording, golden: Recording) -> list[Cause]:
    """The causes, most likely first; empty where nothing differs. Raises RecordingError as `compare` does."""
    return causes_of_pairs(run, golden, traces_of_pair(golden, run))


def causes_of_pairs(run: Recording, golden: Recording, pairs: Pairs) -> list[Cause]:
    """The same of traces that are there already."""
    end_tick = min(run.ticks, golden.ticks)
    pairs = {wire: pair for wire, pair in pairs.items() if len(events_apart(*_until(pair, end_tick)))}
    found = [_best_of_wire(pair, end_tick) for pair in pairs.values()]
    between = [*_swapped_wires(pairs, end_tick), *_other_order(run, golden, pairs)]
    ranked = _ranked(found, between)
    if not ranked and run.ticks != golden.ticks:
        ranked = [Cause("length", ("run",), (), end_tick, None, run.ticks - golden.ticks, 1.0, 1, 0)]
    speaker = words.Speaker(golden)
    return [replace(cause, text=speaker.sentence(cause)) for cause in ranked]


# --- one wire ----------------------------------------------------------------------------------------------------


def _best_of_wire(pair: tuple[Trace, Trace], end_tick: int) -> list[Cause]:
    """What may have happened to one wire, best first; never empty."""
    found = _of_wire(*pair, end_tick)
    first_tick = found[0].first_tick
    for ticks, weight in _EARLY:
        if found[0].score >= GOOD:
            break
        end = first_tick + ticks
        early = [one for one in _of_wire(*_until(pair, end), end) if one.kind not in ("changed", "noise")]
        if early and early[0].differing < _FEWEST:
            break
        found = _sorted([*found, *(replace(one, score=one.score * weight, last_tick=end - 1) for one in early[:1])])
    return found


def _of_wire(golden: Trace, run: Trace, end_tick: int) -> list[Cause]:
    golden_here, run_here = _until((golden, run), end_tick)
    apart = events_apart(golden_here, run_here)
    ticks = np.concatenate((golden_here.ticks[apart.missing], run_here.ticks[apart.extra]))
    first, last = int(ticks.min()), int(ticks.max())
    blank = Cause("changed", (golden.wire,), (), first, _last_tick(last, end_tick), 0.0, 0.2, len(apart), len(apart))
    found = [blank]
    if not np.array_equal(golden_here.ticks, run_here.ticks):
        found += _of_timing(golden_here, run_here, blank, last + 1)
    if max(cause.score for cause in found) < _SETTLED:
        found += _of_values(golden_here, run_here, blank, end_tick)
    return _sorted(found)


def _of_timing(golden: Trace, run: Trace, blank: Cause, end_tick: int) -> Iterator[Cause]:
    """Frames that come at other times, too few or too many."""
    apart = events_apart(golden, run)
    missing, extra = len(apart.missing), len(apart.extra)
    total = missing + extra
    first = blank.first_tick
    if missing:
        yield _scored(blank, "dropped", missing, total, extra, 0.97)
    if extra:
        again = int(copies(run, apart.extra).sum())
        if again:
            yield _scored(blank, "duplicated", again, total, total - again, 0.97)
        if again < extra:
            yield _scored(blank, "added", extra, total, missing, 0.6)
    before, after = _until((golden, run), end_tick)
    best_late = 0.0
    for lag in likely_lags(golden, run, apart):
        left = min(total, len(events_apart(shifted(golden, lag, first, end_tick), after)))
        cause = _scored(blank, "late", lag, total, left, 0.99)
        best_late = max(best_late, cause.score)
        yield cause
    if best_late < GOOD:
        delays = late_by_turns(golden, run, apart)
        if len(delays):
            asked = min(total, 2 * ONE_BY_ONE)
            left = round(total * (1.0 - min(1.0, 2 * len(delays) / asked)))
            yield _scored(blank, "late", int(delays.max()), total, left, 0.9)
    yield from _of_rate(before, after, blank, total)


def _of_rate(golden: Trace, run: Trace, blank: Cause, total: int) -> Iterator[Cause]:
    there = run.ticks[run.ticks >= blank.first_tick - 1]
    usual = golden.ticks[golden.ticks >= blank.first_tick - 1]
    period = period_ticks(there)
    if period is None or period < 1.0 or len(usual) < 4:
        return
    before = (usual[-1] - usual[0]) / (len(usual) - 1)
    if abs(period - before) * len(there) >= 3.0 and abs(period / before - 1.0) > 0.005:
        yield replace(_scored(blank, "rate", period, total, 0, 0.99), usual=float(before))


# --- values ------------------------------------------------------------------------------------------------------


def _of_values(golden: Trace, run: Trace, blank: Cause, end_tick: int) -> Iterator[Cause]:
    """Frames that come when they should and say something else."""
    rows_before, rows_after = paired_rows(golden, run)
    keys = golden.keys[rows_before], run.keys[rows_after]
    differ = keys[0] != keys[1]
    if not differ.any():
        return
    unpaired = len(golden) + len(run) - 2 * len(rows_before)
    total = int(differ.sum()) + unpaired
    ticks = golden.ticks[rows_before]
    seen = _Seen(blank, ticks, differ, total, unpaired, end_tick)
    yield from seen.of_frames(*keys)
    columns = {
        name: _Column.of_pair(name, before, run.fields[name], rows_before, rows_after)
        for name, before in golden.fields.items()
        if name in run.fields
    }
    yield from seen.of_fields([column for column in columns.values() if column.differ.any()])
    yield from seen.swapped_fields(columns)


@dataclass(frozen=True, slots=True)
class _Column:
    """One field over the frames that both sides have."""

    name: str
    golden: Ints
    run: Ints
    valid: Mask
    step: float
    turn: int

    @classmethod
    def of_pair(cls, name: str, before: FieldTrace, after: FieldTrace, rows: Ints, others: Ints) -> _Column:
        valid = before.valid[rows] & after.valid[others]
        return cls(name, before.counts[rows], after.counts[others], valid, before.step, before.turn)

    @property
    def differ(self) -> Mask:
        return np.asarray((self.golden != self.run) & self.valid)


@dataclass(frozen=True, slots=True)
class _Fit:
    """A pattern of one column, and which frames of the wire it does not explain."""

    column: _Column
    pattern: Pattern
    wrong: Mask


@dataclass(frozen=True, slots=True)
class _Seen:
    """The differing frames of one wire, against which explanations are counted."""

    blank: Cause
    ticks: Ints
    differ: Mask
    total: int
    unpaired: int
    end_tick: int

    def of_frames(self, golden: Ints, run: Ints) -> Iterator[Cause]:
        """Whole frames, by their bytes alone."""
        if self.differ.sum() < _FEWEST_ROWS:
            return
        first, last = _span(self.differ)
        stretch = Stretch(golden[: last + 1], run[: last + 1], first)
        found = late(stretch)
        if found is not None and abs(int(found.amount)) < len(self.ticks):
            yield self._cause("late", self._in_ticks(found.amount), (), int(found.wrong.sum()), self.differ, 0.98)
        if first and (golden[first : last + 1] != golden[first]).any():
            wrong = int((run[first : last + 1] != run[first - 1]).sum())
            yield self._cause("stuck", 0.0, (), wrong, self.differ, 1.0)
        exchanged = _exchanged(golden, run, self.differ)
        if exchanged.any():
            yield self._cause("order", 0.0, (), int((self.differ & ~exchanged).sum()), self.differ, 0.98)

    def of_fields(self, columns: list[_Column]) -> Iterator[Cause]:
        """Each field by itself, and all fields together where the same happened to them."""
        anything = np.zeros(len(self.ticks), bool)
        for column in columns:
            anything |= column.differ
        unseen = self.differ & ~anything
        fits: dict[str, list[_Fit]] = {}
        for column in columns:
            others = unseen.copy()
            for other in columns:
                if other is not column:
                    others |= other.differ
            for fit in _fits(column):
                fits.setdefault(fit.pattern.kind, []).append(fit)
                yield self._of_fit(fit, int((fit.wrong | others).sum()))
        for kind, same in fits.items():
            if len(same) == len(columns) > 1 and _alike(same):
                wrong = unseen.copy()
                for fit in same:
                    wrong |= fit.wrong
                weight = min(fit.pattern.weight for fit in same)
                names = tuple(fit.column.name for fit in same)
                amount = self._amount(same[0])
                yield self._cause(kind, amount, names, int(wrong.sum()), self.differ, weight)

    def swapped_fields(self, columns: Mapping[str, _Column]) -> Iterator[Cause]:
        """Fields that carry each other's values: two of one unit, or all of wheel 2 and wheel 3."""
        if self.differ.sum() < _FEWEST_ROWS:
            return
        differing = {name for name, column in columns.items() if column.differ.any()}
        for pairs in _exchangeable(differing):
            involved = {name for pair in pairs for name in pair}
            wrong = np.zeros(len(self.ticks), bool)
            for one, other in pairs:
                first, last = _span(columns[one].differ | columns[other].differ)
                there = slice(first, last + 1)
                wrong[there] |= columns[one].run[there] != columns[other].golden[there]
                wrong[there] |= columns[other].run[there] != columns[one].golden[there]
            for name in differing - involved:
                wrong |= columns[name].differ
            names = tuple(sorted(involved))
            yield self._cause("swapped", 0.0, names, int(wrong.sum()), self.differ, 1.0)

    def _of_fit(self, fit: _Fit, left: int) -> Cause:
        pattern = fit.pattern
        return self._cause(pattern.kind, self._amount(fit), (fit.column.name,), left, fit.column.differ, pattern.weight)

    def _amount(self, fit: _Fit) -> float:
        pattern = fit.pattern
        if pattern.kind == "late":
            return self._in_ticks(pattern.amount)
        return pattern.amount if pattern.kind == "scaled" else pattern.amount * fit.column.step

    def _in_ticks(self, frames: float) -> float:
        period = np.median(np.diff(self.ticks)) if len(self.ticks) > 1 else 1.0
        return float(frames * period)

    def _cause(self, kind: str, amount: float, fields: tuple[str, ...], left: int, where: Mask, weight: float) -> Cause:
        first, last = (int(self.ticks[row]) for row in _span(where))
        left = min(self.total, left + self.unpaired)
        return replace(
            _scored(self.blank, kind, amount, self.total, left, weight),
            fields=fields,
            first_tick=first,
            last_tick=_last_tick(last, self.end_tick),
        )


def _fits(column: _Column) -> Iterator[_Fit]:
    rows = np.flatnonzero(column.valid)
    differ = column.differ[rows]
    first, last = _span(differ)
    stretch = Stretch(column.golden[rows[: last + 1]], column.run[rows[: last + 1]], first, column.turn)
    for pattern in patterns(stretch):
        wrong = np.zeros(len(column.valid), bool)
        wrong[rows[first : last + 1]] = pattern.wrong
        yield _Fit(column, pattern, wrong)


def _alike(fits: list[_Fit]) -> bool:
    """Whether the same happened to all of them. What a value is stuck at, and how loud its noise is, may differ."""
    if fits[0].pattern.kind in ("stuck", "noise", "flipped"):
        return True
    return len({round(fit.pattern.amount, 3) for fit in fits}) == 1


def _exchanged(golden: Ints, run: Ints, differ: Mask, furthest: int = 5) -> Mask:
    """Frames that have changed places with one near them."""
    found = np.zeros(len(differ), bool)
    for apart in range(1, min(furthest, len(differ) - 1) + 1):
        here = differ[:-apart] & differ[apart:] & (run[:-apart] == golden[apart:]) & (run[apart:] == golden[:-apart])
        found[:-apart] |= here
        found[apart:] |= here
    return found


_NUMBER = re.compile(r"\d+")


def _exchangeable(names: Iterable[str]) -> list[list[tuple[str, str]]]:
    """Which fields may have changed places: by number (all that belong to it), or two of the same unit."""
    by_number: dict[tuple[str, str], list[tuple[str, str]]] = {}
    plain = []
    for one, other in combinations(sorted(names), 2):
        numbers = _NUMBER.findall(one), _NUMBER.findall(other)
        if len(numbers[0]) == len(numbers[1]) == 1 and _NUMBER.sub("#", one) == _NUMBER.sub("#", other):
            by_number.setdefault((numbers[0][0], numbers[1][0]), []).append((one, other))
        elif not any(numbers) and one.rpartition("_")[2] == other.rpartition("_")[2]:
            plain.append([(one, other)])
    return [*by_number.values(), *plain]


# --- between wires -----------------------------------------------------------------------------------------------


def _swapped_wires(pairs: Pairs, end_tick: int) -> Iterator[Cause]:
    """Two CAN identifiers that carry each other's frames."""
    wires = [wire for wire in pairs if wire.startswith("can ")]
    apart = {wire: events_apart(*_until(pairs[wire], end_tick)) for wire in wires}
    for one, other in combinations(wires, 2):
        if not _look_swapped(pairs[one][1], apart[one].extra, pairs[other][0]):
            continue
        total = len(apart[one]) + len(apart[other])
        ticks = [_ticks_apart(pairs[wire], end_tick) for wire in (one, other)]
        first, last = int(min(t.min() for t in ticks)), int(max(t.max() for t in ticks))
        left = 0
        for here, there in ((one, other), (other, one)):
            expected = _joined(pairs[here][0], pairs[there][0], first, last)
            left += len(events_apart(*_until((expected, pairs[here][1]), end_tick)))
        if left < total:
            score = 1.0 - left / total
            until = _last_tick(last, end_tick)
            yield Cause("swapped", (one, other), (), first, until, 0.0, score, total, left)


def _look_swapped(run: Trace, extra: Ints, golden: Trace) -> bool:
    """Whether the first frames that only the run has are another wire's, at their tick."""
    asked = extra[:_ASKED]
    there = np.minimum(np.searchsorted(golden.ticks, run.ticks[asked]), len(golden) - 1)
    if not len(asked) or not len(golden):
        return False
    same = (golden.keys[there] == run.keys[asked]) & (golden.ticks[there] == run.ticks[asked])
    return bool(2 * same.sum() >= len(asked))


def _joined(outside: Trace, inside: Trace, first_tick: int, last_tick: int) -> Trace:
    """One trace, with another's frames from a tick to another."""
    inner = (inside.ticks >= first_tick) & (inside.ticks <= last_tick)
    outer = (outside.ticks < first_tick) | (outside.ticks > last_tick)
    ticks = np.concatenate((outside.ticks[outer], inside.ticks[inner]))
    order = np.argsort(ticks, kind="stable")
    return Trace(outside.wire, ticks[order], np.concatenate((outside.keys[outer], inside.keys[inner]))[order])


def _other_order(run: Recording, golden: Recording, pairs: Pairs) -> Iterator[Cause]:
    """The same frames in every tick, but not in the same order."""
    if run.content(CAN_LOG) == golden.content(CAN_LOG):
        return
    before, after = (can_of(side).until(min(run.ticks, golden.ticks)) for side in (golden, run))
    ticks = [_ticks_apart(pair, 1 << 62) for wire, pair in pairs.items() if wire.startswith("can ")]
    differing = np.concatenate([*ticks, np.empty(0, np.int64)])
    kept = before.outside(differing), after.outside(differing)
    ids = before.can_id[kept[0]], after.can_id[kept[1]]
    if len(ids[0]) != len(ids[1]) or np.array_equal(*ids):
        return
    moved = before.rows(np.flatnonzero(kept[0])[ids[0] != ids[1]])
    wires = tuple(f"can 0x{can_id:03X}" for can_id in moved.ids)
    first, last = int(moved.tick[0]), int(moved.tick[-1])
    until = _last_tick(last, min(run.ticks, golden.ticks))
    in_ticks = 1.0 + np.count_nonzero(np.diff(moved.tick))
    yield Cause("order", wires, (), first, until, in_ticks, 1.0, len(moved.tick), 0)


# --- ranking -----------------------------------------------------------------------------------------------------


def _ranked(of_wires: list[list[Cause]], between: list[Cause]) -> list[Cause]:
    """The leading wire's causes by score, with the other wires that show the same; then what else there is, by time."""
    best = {found[0].wires[0]: found[0] for found in of_wires}
    for cause in _sorted(between):
        if all(cause.score >= best[wire].score for wire in cause.wires if wire in best):
            best.update(dict.fromkeys(cause.wires, cause))
    first_ticks = {found[0].wires[0]: min(one.first_tick for one in found) for found in of_wires}
    for cause in between:
        for wire in cause.wires:
            first_ticks[wire] = min(cause.first_tick, first_ticks.get(wire, cause.first_tick))
    if not best:
        return []
    order = sorted(best, key=lambda wire: (first_ticks[wire], rank(wire)))
    merged: list[Cause] = []
    for wire in order:
        cause = best[wire]
        # What leads stands alone unless the very same happened elsewhere; that others differ too is no part of it.
        others = merged[1:] if cause.kind == "changed" else merged
        same = next((one for one in others if _is_same(one, cause)), None)
        if same is None:
            merged.append(cause)
        elif wire not in same.wires:
            merged[merged.index(same)] = _merged(same, cause)
    rivals = [one for found in of_wires if found[0].wires[0] == order[0] for one in found]
    rivals = [one for one in _sorted([*rivals, *between]) if order[0] in one.wires and one not in best.values()]
    doubted = merged[0].score < _BEYOND_DOUBT
    return [*merged[:1], *(one for one in rivals[:2] if doubted and one.score > 0.3), *merged[1:]][:_MOST]


def _is_same(one: Cause, other: Cause) -> bool:
    if one is other:
        return True
    own = ("noise", "offset", "dropped", "duplicated", "quantised", "rate", "swapped")
    if one.kind != other.kind or one.kind in own:
        return False
    return one.amount == other.amount and bool(one.fields) == bool(other.fields)


def _merged(one: Cause, other: Cause) -> Cause:
    differing = one.differing + other.differing
    last = None if one.last_tick is None or other.last_tick is None else max(one.last_tick, other.last_tick)
    return replace(
        one,
        wires=(*one.wires, *other.wires),
        fields=tuple(dict.fromkeys((*one.fields, *other.fields))),
        last_tick=last,
        score=(one.score * one.differing + other.score * other.differing) / differing,
        differing=differing,
        left=one.left + other.left,
    )


def _sorted(found: list[Cause]) -> list[Cause]:
    return sorted(found, key=lambda cause: -cause.score)


def _scored(blank: Cause, kind: str, amount: float, total: int, left: int, weight: float) -> Cause:
    left = max(0, min(left, total))
    score = weight * (1.0 - left / total)
    return replace(blank, kind=kind, amount=float(amount), score=score, differing=total, left=left)


def _until(pair: tuple[Trace, Trace], end_tick: int) -> tuple[Trace, Trace]:
    golden, run = (_cut(trace, end_tick) for trace in pair)
    return golden, run


def _cut(trace: Trace, end_tick: int) -> Trace:
    if not len(trace) or trace.ticks[-1] < end_tick:
        return trace
    end = int(np.searchsorted(trace.ticks, end_tick))
    fields = {name: replace(one, counts=one.counts[:end], valid=one.valid[:end]) for name, one in trace.fields.items()}
    return Trace(trace.wire, trace.ticks[:end], trace.keys[:end], fields)


def _ticks_apart(pair: tuple[Trace, Trace], end_tick: int) -> Ints:
    golden, run = _until(pair, end_tick)
    apart = events_apart(golden, run)
    return np.concatenate((golden.ticks[apart.missing], run.ticks[apart.extra]))


def _span(differ: Mask) -> tuple[int, int]:
    rows = np.flatnonzero(differ)
    return int(rows[0]), int(rows[-1])


def _last_tick(last: int, end_tick: int) -> int | None:
    """None where it lasts to the end, or so near that nobody can tell."""
    return None if end_tick - last <= max(100, end_tick // 20) else last
