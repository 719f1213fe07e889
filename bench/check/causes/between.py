"""What happened between wires: two identifiers with each other's frames, frames in another order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

import numpy as np

from bench.check.align import events_apart
from bench.check.causes.cause import Cause, end_of
from bench.check.causes.cut import cut, ticks_apart
from bench.check.lines import CAN_LOG
from bench.check.reading import Recording
from bench.check.traces import Ints, Trace, can_of

Pairs = Mapping[str, tuple[Trace, Trace]]

_ASKED = 200


def swapped_wires(pairs: Pairs, end_tick: int) -> Iterator[Cause]:
    """Two CAN identifiers that carry each other's frames."""
    wires = [wire for wire in pairs if wire.startswith("can ")]
    apart = {wire: events_apart(*cut(pairs[wire], end_tick)) for wire in wires}
    for one, other in combinations(wires, 2):
        if not _look_swapped(pairs[one][1], apart[one].extra, pairs[other][0]):
            continue
        total = len(apart[one]) + len(apart[other])
        ticks = [ticks_apart(pairs[wire], end_tick) for wire in (one, other)]
        first, last = int(min(t.min() for t in ticks)), int(max(t.max() for t in ticks))
        left = 0
        for here, there in ((one, other), (other, one)):
            expected = _joined(pairs[here][0], pairs[there][0], first, last)
            left += len(events_apart(*cut((expected, pairs[here][1]), end_tick)))
        if left < total:
            score = 1.0 - left / total
            until = end_of(last, end_tick)
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


def other_order(run: Recording, golden: Recording, pairs: Pairs) -> Iterator[Cause]:
    """The same frames in every tick, but not in the same order."""
    if run.content(CAN_LOG) == golden.content(CAN_LOG):
        return
    before, after = (can_of(side).until(min(run.ticks, golden.ticks)) for side in (golden, run))
    ticks = [ticks_apart(pair, 1 << 62) for wire, pair in pairs.items() if wire.startswith("can ")]
    differing = np.concatenate([*ticks, np.empty(0, np.int64)])
    kept = before.outside(differing), after.outside(differing)
    ids = before.can_id[kept[0]], after.can_id[kept[1]]
    if len(ids[0]) != len(ids[1]) or np.array_equal(*ids):
        return
    moved = before.rows(np.flatnonzero(kept[0])[ids[0] != ids[1]])
    wires = tuple(f"can 0x{can_id:03X}" for can_id in moved.ids)
    first, last = int(moved.tick[0]), int(moved.tick[-1])
    until = end_of(last, min(run.ticks, golden.ticks))
    in_ticks = 1.0 + np.count_nonzero(np.diff(moved.tick))
    yield Cause("order", wires, (), first, until, in_ticks, 1.0, len(moved.tick), 0)
