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
_COMMON_KEY = 6
"""Bytes that were sent more often than this say little about when they were sent."""
_COPY_FRAMES = 4


class Difference(NamedTuple):
    """What is left of each side once common events are taken out: rows of the golden, rows of the run."""

    missing: Ints
    extra: Ints

    def __len__(self) -> int:
        return len(self.missing) + len(self.extra)


def events_apart(golden: Trace, run: Trace) -> Difference:
    """The frames that only one side has, at their tick and with their bytes."""
    both = np.concatenate((golden.keys, run.keys))
    dense = np.unique(both, return_inverse=True)[1].astype(np.int64)
    before = golden.ticks * len(both) + dense[: len(golden)]
    after = run.ticks * len(both) + dense[len(golden) :]
    return Difference(_not_in(before, after), _not_in(after, before))


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
    if not len(apart.extra) or not len(golden):
        return np.empty(0, np.int64)
    order = np.argsort(golden.keys, kind="stable")
    keys = golden.keys[order]
    wanted = run.keys[apart.extra]
    low, high = np.searchsorted(keys, wanted, "left"), np.searchsorted(keys, wanted, "right")
    found = []
    for nth in range(_COMMON_KEY):
        there = (high - low > nth) & (high - low <= _COMMON_KEY)
        found.append(run.ticks[apart.extra[there]] - golden.ticks[order[low[there] + nth]])
    deltas = np.concatenate(found)
    return deltas[np.abs(deltas) <= LONGEST_LAG]


def copies(run: Trace, rows: Ints) -> NDArray[np.bool_]:
    """Which of these frames of the run have the same bytes as one of the few before them."""
    found = np.zeros(len(rows), bool)
    for back in range(1, _COPY_FRAMES + 1):
        before = np.maximum(rows - back, 0)
        found |= (rows >= back) & (run.keys[rows] == run.keys[before])
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

    Each frame that only the run has is laid to the newest earlier frame with the same bytes that only the golden has.
    """
    waiting: dict[int, list[int]] = {}
    for row in apart.missing.tolist():
        waiting.setdefault(int(golden.keys[row]), []).append(int(golden.ticks[row]))
    delays = []
    for row in apart.extra.tolist():
        at = int(run.ticks[row])
        before = [tick for tick in waiting.get(int(run.keys[row]), ()) if 0 < at - tick <= LONGEST_LAG]
        if before:
            waiting[int(run.keys[row])].remove(before[0])
            delays.append(at - before[0])
    return np.array(delays, np.int64)
