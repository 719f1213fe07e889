"""Frames that come when they should and say something else: whole frames, single fields, fields that change places."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from bench.check.align import paired_rows
from bench.check.causes.cause import Cause, end_of, scored
from bench.check.patterns import Pattern, Stretch, late, patterns
from bench.check.traces import FieldTrace, Ints, Trace

Mask = NDArray[np.bool_]

_FEWEST_ROWS = 3
"""What two frames have in common is chance: lost or doubled they may be, but not late, stuck or exchanged."""
_NUMBER = re.compile(r"\d+")


def of_values(golden: Trace, run: Trace, blank: Cause, end_tick: int) -> Iterator[Cause]:
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
            scored(self.blank, kind, amount, self.total, left, weight),
            fields=fields,
            first_tick=first,
            last_tick=end_of(last, self.end_tick),
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


def _span(differ: Mask) -> tuple[int, int]:
    rows = np.flatnonzero(differ)
    return int(rows[0]), int(rows[-1])
