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

from dataclasses import replace

import numpy as np

from bench.check import words
from bench.check.align import events_apart
from bench.check.causes.between import Pairs, other_order, swapped_wires
from bench.check.causes.cause import GOOD, Cause, by_score, end_of
from bench.check.causes.cut import cut
from bench.check.causes.ranking import in_rank
from bench.check.causes.timing import of_timing
from bench.check.causes.values import of_values
from bench.check.reading import Recording
from bench.check.traces import Trace, traces_of_pair

__all__ = ["GOOD", "Cause", "causes", "causes_of_pairs"]

_SETTLED = 0.965
"""A score from which times explain it all, and values are not looked at."""
_EARLY = ((400, 0.9), (100, 0.8), (30, 0.7))
"""Ticks from the first difference on, and what an explanation of these alone is worth."""
_FEWEST = 8
"""Fewer differences than this in the first moments say nothing."""


def causes(run: Recording, golden: Recording) -> list[Cause]:
    """The causes, most likely first; empty where nothing differs. Raises RecordingError as `compare` does."""
    return causes_of_pairs(run, golden, traces_of_pair(golden, run))


def causes_of_pairs(run: Recording, golden: Recording, pairs: Pairs) -> list[Cause]:
    """The same of traces that are there already."""
    end_tick = min(run.ticks, golden.ticks)
    pairs = {wire: pair for wire, pair in pairs.items() if len(events_apart(*cut(pair, end_tick)))}
    found = [_best_of_wire(pair, end_tick) for pair in pairs.values()]
    between = [*swapped_wires(pairs, end_tick), *other_order(run, golden, pairs)]
    ranked = in_rank(found, between)
    if not ranked and run.ticks != golden.ticks:
        ranked = [Cause("length", ("run",), (), end_tick, None, run.ticks - golden.ticks, 1.0, 1, 0)]
    speaker = words.Speaker(golden)
    return [replace(cause, text=speaker.sentence(cause)) for cause in ranked]


def _best_of_wire(pair: tuple[Trace, Trace], end_tick: int) -> list[Cause]:
    """What may have happened to one wire, best first; never empty."""
    found = _of_wire(*pair, end_tick)
    first_tick = found[0].first_tick
    for ticks, weight in _EARLY:
        if found[0].score >= GOOD:
            break
        end = first_tick + ticks
        early = [one for one in _of_wire(*cut(pair, end), end) if one.kind not in ("changed", "noise")]
        if early and early[0].differing < _FEWEST:
            break
        found = by_score([*found, *(replace(one, score=one.score * weight, last_tick=end - 1) for one in early[:1])])
    return found


def _of_wire(golden: Trace, run: Trace, end_tick: int) -> list[Cause]:
    golden_here, run_here = cut((golden, run), end_tick)
    apart = events_apart(golden_here, run_here)
    ticks = np.concatenate((golden_here.ticks[apart.missing], run_here.ticks[apart.extra]))
    first, last = int(ticks.min()), int(ticks.max())
    blank = Cause("changed", (golden.wire,), (), first, end_of(last, end_tick), 0.0, 0.2, len(apart), len(apart))
    found = [blank]
    if not np.array_equal(golden_here.ticks, run_here.ticks):
        found += of_timing(golden_here, run_here, blank, last + 1)
    if max(cause.score for cause in found) < _SETTLED:
        found += of_values(golden_here, run_here, blank, end_tick)
    return by_score(found)
