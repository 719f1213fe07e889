"""Frames that come at other times, too few or too many: late, dropped, duplicated, another rate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from bench.check.align import (
    ONE_BY_ONE,
    copies,
    events_apart,
    late_by_turns,
    likely_lags,
    period_ticks,
    shifted,
)
from bench.check.causes.cause import GOOD, Cause, scored
from bench.check.causes.cut import cut
from bench.check.traces import Trace


def of_timing(golden: Trace, run: Trace, blank: Cause, end_tick: int) -> Iterator[Cause]:
    """Frames that come at other times, too few or too many."""
    apart = events_apart(golden, run)
    missing, extra = len(apart.missing), len(apart.extra)
    total = missing + extra
    first = blank.first_tick
    if missing:
        yield scored(blank, "dropped", missing, total, extra, 0.97)
    if extra:
        again = int(copies(run, apart.extra).sum())
        if again:
            yield scored(blank, "duplicated", again, total, total - again, 0.97)
        if again < extra:
            yield scored(blank, "added", extra, total, missing, 0.6)
    before, after = cut((golden, run), end_tick)
    best_late = 0.0
    for lag in likely_lags(golden, run, apart):
        left = min(total, len(events_apart(shifted(golden, lag, first, end_tick), after)))
        cause = scored(blank, "late", lag, total, left, 0.99)
        best_late = max(best_late, cause.score)
        yield cause
    if best_late < GOOD:
        delays = late_by_turns(golden, run, apart)
        if len(delays):
            asked = min(total, 2 * ONE_BY_ONE)
            left = round(total * (1.0 - min(1.0, 2 * len(delays) / asked)))
            yield scored(blank, "late", int(delays.max()), total, left, 0.9)
    yield from _of_rate(before, after, blank, total)


def _of_rate(golden: Trace, run: Trace, blank: Cause, total: int) -> Iterator[Cause]:
    there = run.ticks[run.ticks >= blank.first_tick - 1]
    usual = golden.ticks[golden.ticks >= blank.first_tick - 1]
    period = period_ticks(there)
    if period is None or period < 1.0 or len(usual) < 4:
        return
    before = (usual[-1] - usual[0]) / (len(usual) - 1)
    if abs(period - before) * len(there) >= 3.0 and abs(period / before - 1.0) > 0.005:
        yield replace(scored(blank, "rate", period, total, 0, 0.99), usual=float(before))
