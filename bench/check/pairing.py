"""Which answers of two bases belong together, when some of one never came, or one is late.

Answers are frames, whatever pieces they came in. Counting them off side by side would set every answer after a lost
one beside its neighbour's; so the shift that most of them share is found first, and each is paired where that puts it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from bench.messages import TickOutput
from bench.slamware.framing import FrameDecoder

ALIKE_WEIGHS = 10
"""Two answers with the same bytes say so much more of the shift than two others."""


class Answer(NamedTuple):
    """A frame of the base, or bytes that are none, and the tick in which it was whole."""

    tick: int
    data: bytes


class Pairs(NamedTuple):
    """Answers that belong together, and how many of either side have no partner."""

    pairs: list[tuple[Answer, Answer]]
    missing: int
    extra: int


def answers_of(outs: Sequence[TickOutput]) -> list[Answer]:
    """The answers of a run, in order."""
    decoder, stream, found = FrameDecoder(), bytearray(), []
    for out in outs:
        if not out.base_to_core:
            continue
        stream += out.base_to_core
        for event in decoder.feed(out.base_to_core, out.tick):
            found.append(Answer(out.tick, bytes(stream[event.offset : event.offset + event.length])))
    last_tick = outs[-1].tick if outs else 0
    rest = [Answer(last_tick, bytes(stream[one.offset : one.offset + one.length])) for one in decoder.finish()]
    return found + rest


def paired(reference: Sequence[Answer], peer: Sequence[Answer], most_ticks: int) -> Pairs:
    """Pair them in order of time, as the shift (within `most_ticks`, both ways) has it that most of them share."""
    shift = _shift(reference, peer, most_ticks)
    gaps = sorted(after.tick - before.tick for before, after in pairwise(reference))
    near = max(1, gaps[len(gaps) // 2] // 2) if gaps else most_ticks
    pairs: list[tuple[Answer, Answer]] = []
    missing = extra = here = there = 0
    while here < len(reference) and there < len(peer):
        late = peer[there].tick - reference[here].tick - shift
        if abs(late) <= near:
            pairs.append((reference[here], peer[there]))
            here, there = here + 1, there + 1
        elif late > 0:
            missing, here = missing + 1, here + 1
        else:
            extra, there = extra + 1, there + 1
    return Pairs(pairs, missing + len(reference) - here, extra + len(peer) - there)


def _shift(reference: Sequence[Answer], peer: Sequence[Answer], most_ticks: int) -> int:
    """By how many ticks most of the peer's answers are later; the least of several that are as good."""
    votes: Counter[int] = Counter()
    first = 0
    for tick, data in reference:
        while first < len(peer) and peer[first].tick < tick - most_ticks:
            first += 1
        at = first
        while at < len(peer) and peer[at].tick <= tick + most_ticks:
            votes[peer[at].tick - tick] += ALIKE_WEIGHS if peer[at].data == data else 1
            at += 1
    return min(votes, key=lambda shift: (-votes[shift], abs(shift)), default=0)
