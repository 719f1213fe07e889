"""Two sequences of frames laid against each other: which are in both, how far one lies behind, how regular it comes.

An event is a frame at its tick. What both sides have at one tick is common; the rest is `missing` or `extra`.
Everything works on whole columns: a log of an hour is a few array operations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.check.traces import Ints, Trace

LONGEST_LAG = 1000
"""Ticks. A second: what comes later than that is another run."""
_ASKED = 500
_COMMON_KEY = 6
"""Bytes that were sent more often than this say little about when they were sent."""
_COPY_FRAMES = 4
ONE_BY_ONE = 10_000
"""Frames that are asked one by one."""


class Difference(NamedTuple):
    """What is left of each side once common events are taken out: rows of the golden, rows of the run."""

    missing: Ints
    extra: Ints

    def __len__(self) -> int:
        return len(self.missing) + len(self.extra)


def events_apart(golden: Trace, run: Trace) -> Difference:
    """The frames that only one side has, at their tick and with their bytes."""
    if _one_a_tick(golden) and _one_a_tick(run):
        return _apart_by_tick(golden, run)
    both = np.concatenate((golden.keys, run.keys))
    dense = np.unique(both, return_inverse=True)[1].astype(np.int64)
    before = golden.ticks * len(both) + dense[: len(golden)]
    after = run.ticks * len(both) + dense[len(golden) :]
    return Difference(_not_in(before, after), _not_in(after, before))


def _one_a_tick(trace: Trace) -> bool:
    return bool((np.diff(trace.ticks) > 0).all())


def _apart_by_tick(golden: Trace, run: Trace) -> Difference:
    """The same for wires with at most one frame a tick, without sorting: each looks up the other's."""
    if not len(golden) or not len(run):
        return Difference(np.arange(len(golden)), np.arange(len(run)))
    first = min(int(golden.ticks[0]), int(run.ticks[0]))
    row_at = np.full(max(int(golden.ticks[-1]), int(run.ticks[-1])) - first + 1, -1, np.int64)
    row_at[run.ticks - first] = np.arange(len(run))
    partner = row_at[golden.ticks - first]
    common = (partner >= 0) & (run.keys[partner] == golden.keys)
    alone = np.ones(len(run), bool)
    alone[partner[common]] = False
    return Difference(np.flatnonzero(~common), np.flatnonzero(alone))


def _not_in(these: Ints, others: Ints) -> Ints:
    """Rows of `these` that `others` has not, or not that often."""
    order = np.argsort(these, kind="stable")
    ranked = these[order]
    nth = np.arange(len(these)) - np.searchsorted(ranked, ranked, "left")
    theirs = np.sort(others)
    there = np.searchsorted(theirs, ranked, "right") - np.searchsorted(theirs, ranked, "left")
    return np.sort(order[nth >= there])


def shifted(golden: Trace, lag: int, first_tick: int, end_tick: int) -> Trace:
    """The golden as it would be if every frame from a tick on came so many ticks later (or, if negative, earlier)."""
    ticks = golden.ticks + np.where(golden.ticks >= first_tick - min(lag, 0), lag, 0)
    kept = (ticks < end_tick) & ~((golden.ticks >= first_tick) & (ticks < first_tick))
    return Trace(golden.wire, ticks[kept], golden.keys[kept])


def likely_lags(golden: Trace, run: Trace, apart: Difference, most: int = 3) -> list[int]:
    """By how many ticks frames of the run lie behind the golden's with the same bytes, most frequent first."""
    deltas = _deltas(golden, run, apart)
    values, votes = np.unique(deltas[deltas != 0], return_counts=True)
    return [int(value) for value in values[np.argsort(-votes, kind="stable")][:most]]


def _deltas(golden: Trace, run: Trace, apart: Difference) -> Ints:
    """Of some frames that only the run has, spread over all: how far they lie from each golden frame like them."""
    found = [np.zeros(0, np.int64)]
    for row in apart.extra[:: max(1, len(apart.extra) // _ASKED)].tolist():
        at = int(run.ticks[row])
        low, high = np.searchsorted(golden.ticks, [at - LONGEST_LAG, at + LONGEST_LAG + 1])
        alike = np.flatnonzero(golden.keys[low:high] == run.keys[row])
        if len(alike) <= _COMMON_KEY:
            found.append(at - golden.ticks[low + alike])
    return np.concatenate(found)


def copies(run: Trace, rows: Ints) -> NDArray[np.bool_]:
    """Which of these frames of the run have the same bytes as a frame next to them.

    On either side: some RC frames are known to be whole only when the next one comes.
    """
    found = np.zeros(len(rows), bool)
    for back in (*range(-_COPY_FRAMES, 0), *range(1, _COPY_FRAMES + 1)):
        beside = rows - back
        there = (beside >= 0) & (beside < len(run))
        found[there] |= run.keys[rows[there]] == run.keys[beside[there]]
    return found


def period_ticks(ticks: Ints) -> float | None:
    """The period of frames that come regularly: each within a tick of its turn. None where they do not."""
    if len(ticks) < 8:
        return None
    turns = np.arange(len(ticks), dtype=np.float64)
    slope, start = np.polyfit(turns, ticks.astype(np.float64), 1)
    apart = np.diff(ticks)
    usual = np.bincount(apart.clip(0, 10_000)).argmax()
    odd = np.abs(apart - usual)
    # Two or three lost frames lie on a straight line by chance; a period that is slowly left behind makes many. A gap
    # that is a millisecond off is no lost frame but a rounded period, where the period is longer than that.
    if 0 < int((odd > (1 if usual > 2 else 0)).sum()) < 6:
        return None
    return float(slope) if bool((np.abs(start + slope * turns - ticks) <= 1.0).all()) else None


def paired_rows(golden: Trace, run: Trace) -> tuple[Ints, Ints]:
    """Rows of both sides that stand at the same tick (the first with the first, where there are several)."""
    if np.array_equal(golden.ticks, run.ticks):
        rows = np.arange(len(golden), dtype=np.int64)
        return rows, rows
    sides = []
    for trace in (golden, run):
        nth = np.arange(len(trace)) - np.searchsorted(trace.ticks, trace.ticks, "left")
        sides.append(trace.ticks * 16 + np.minimum(nth, 15))
    _, before, after = np.intersect1d(*sides, return_indices=True)
    return before.astype(np.int64), after.astype(np.int64)


def late_by_turns(golden: Trace, run: Trace, apart: Difference) -> Ints:
    """Ticks that each late frame lies behind, where every frame has its own delay; empty where they are not late.

    Each of the first frames that only the run has is laid to the oldest one before it that only the
    golden has, with the same bytes.
    """
    waiting: dict[int, list[int]] = {}
    for row in apart.missing[:ONE_BY_ONE].tolist():
        waiting.setdefault(int(golden.keys[row]), []).append(int(golden.ticks[row]))
    delays = []
    for row in apart.extra[:ONE_BY_ONE].tolist():
        at = int(run.ticks[row])
        before = [tick for tick in waiting.get(int(run.keys[row]), ()) if 0 < at - tick <= LONGEST_LAG]
        if before:
            waiting[int(run.keys[row])].remove(before[0])
            delays.append(at - before[0])
    return np.array(delays, np.int64)
