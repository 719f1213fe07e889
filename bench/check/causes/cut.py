"""Traces until a tick: a comparison goes only as far as both sides do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.check.align import events_apart
from bench.check.traces import Ints, Trace


def cut(pair: tuple[Trace, Trace], end_tick: int) -> tuple[Trace, Trace]:
    """Both sides, without what comes at a tick or after it."""
    golden, run = (_cut_one(trace, end_tick) for trace in pair)
    return golden, run


def _cut_one(trace: Trace, end_tick: int) -> Trace:
    if not len(trace) or trace.ticks[-1] < end_tick:
        return trace
    end = int(np.searchsorted(trace.ticks, end_tick))
    fields = {name: replace(one, counts=one.counts[:end], valid=one.valid[:end]) for name, one in trace.fields.items()}
    return Trace(trace.wire, trace.ticks[:end], trace.keys[:end], fields)


def ticks_apart(pair: tuple[Trace, Trace], end_tick: int) -> Ints:
    """Ticks of the frames that only one side has, until a tick."""
    golden, run = cut(pair, end_tick)
    apart = events_apart(golden, run)
    return np.concatenate((golden.ticks[apart.missing], run.ticks[apart.extra]))
