"""Does it all fit on the bus? Load and worst-case response time of every message, from nodes and rates.

Response times are those of Davis, Burns, Bril and Lukkien, "Controller Area Network (CAN) schedulability analysis:
refuted, revisited and revised", Real-Time Systems 35, 2007: fixed priorities, a frame that has begun is not
interrupted, every instance in the busy period is looked at. They count from the moment a frame is ready to the end of
its gap; no errors on the wire, each node sends its most urgent frame first, each message is due when its next is ready.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import NamedTuple

from bench.canbus.streams import Lengths, Stream, streams
from bench.canbus.table import Family

GUARANTEED, IN_PRACTICE, TOO_MUCH, CLASH = "guaranteed", "in practice", "too much", "clash"
"""The verdicts: fits however the bits fall; fits a robot that drives; does not fit; two senders on one identifier."""


class Row(NamedTuple):
    """A stream on its bus."""

    stream: Stream
    period_us: float
    worst_us: float | None
    """Worst-case response time with worst-stuffed frames; None where the bus is full before its turn comes."""
    usual_us: float | None
    """The same with the frames of a robot that drives or rests, whichever are longer."""

    @property
    def is_lost(self) -> bool:
        """True where the bus is full before its turn comes, even with usual frames."""
        return self.usual_us is None

    @property
    def is_late(self) -> bool:
        """True where it gets through, but perhaps after its next one is ready, even with usual frames."""
        return self.usual_us is not None and self.usual_us > self.period_us

    @property
    def is_guaranteed(self) -> bool:
        """True where it is in time however the bits fall."""
        return self.worst_us is not None and self.worst_us <= self.period_us


class Budget(NamedTuple):
    """What `budget` found. Loads are shares of the bus: 1.0 is full."""

    bitrate: int
    rows: tuple[Row, ...]
    clashes: tuple[str, ...]
    least: float
    typical: float
    resting: float
    worst: float

    @property
    def verdict(self) -> str:
        """One of the four verdicts."""
        if self.clashes:
            return CLASH
        if all(row.is_guaranteed for row in self.rows):
            return GUARANTEED
        return TOO_MUCH if any(row.is_lost or row.is_late for row in self.rows) else IN_PRACTICE

    @property
    def text(self) -> str:
        """The verdict as a sentence."""
        if self.verdict == CLASH:
            return f"clash: {'; '.join(self.clashes)}"
        if self.verdict == GUARANTEED:
            return "fits, guaranteed: every frame is through before its next one is ready, however the bits fall"
        if self.verdict == IN_PRACTICE:
            late = _ids(row for row in self.rows if not row.is_guaranteed)
            return f"fits in practice, not guaranteed: frames that stuff badly enough would delay {late}"
        lost, late = _ids(row for row in self.rows if row.is_lost), _ids(row for row in self.rows if row.is_late)
        said = [f"{lost} will get lost"] if lost else []
        return f"does not fit: {', '.join(said + ([f'{late} may be late'] if late else []))}"


def budget(found: Iterable[Stream], bitrate: int = 1_000_000) -> Budget:
    """Loads, response times and the verdict for all streams of one bus."""
    ordered = sorted(found, key=lambda one: one.can_id)
    ids = [one.can_id for one in ordered]
    clashes = [_clash(ordered, can_id) for can_id in sorted({one for one in ids if ids.count(one) > 1})]
    # A period is cut and a mean length raised to whole bits: more often and longer is the safe side.
    periods = [bitrate // one.hz for one in ordered]
    worst = response_times([(one.bits.worst, period) for one, period in zip(ordered, periods, strict=True)])
    longer = [math.ceil(max(one.bits.typical, one.bits.resting)) for one in ordered]
    usual = response_times(list(zip(longer, periods, strict=True)))
    rows = tuple(
        Row(one, 1e6 / one.hz, _us(bits, bitrate), _us(usual_bits, bitrate))
        for one, bits, usual_bits in zip(ordered, worst, usual, strict=True)
    )
    loads = [sum(one.bits[kind] * one.hz for one in ordered) / bitrate for kind in range(len(Lengths._fields))]
    return Budget(bitrate, rows, tuple(clashes), *loads)


def guaranteed_feedback_hz(
    family: Family, numbers: Sequence[int], *, command_hz: int, bitrate: int, others: Sequence[Stream] = ()
) -> int:
    """The highest rate of feedback at which everything is guaranteed to fit; 0 where there is none up to 1 kHz."""
    low, high = 0, 1000
    while low < high:
        middle = (low + high + 1) // 2
        found = streams(family, numbers, feedback_hz=middle, command_hz=command_hz)
        if budget([*found, *others], bitrate).verdict == GUARANTEED:
            low = middle
        else:
            high = middle - 1
    return low


def response_times(messages: Sequence[tuple[int, int]]) -> list[int | None]:
    """Worst-case response time of each message, in bits; None where it has no bound.

    `messages` are (bits, period in bits), most urgent first: the lowest identifier wins the arbitration.
    """
    found: list[int | None] = []
    used = Fraction(0)
    for place, (bits, period) in enumerate(messages):
        used += Fraction(bits, period) if period else 1
        if used >= 1:
            found.append(None)
            continue
        blocking = max((length for length, _ in messages[place + 1 :]), default=0)
        found.append(_response(messages[:place], bits, period, blocking))
    return found


_LONGEST_BUSY = 100
"""A bus that is busy for so many periods without a pause counts as full: nobody waits for its end."""


def _response(urgent: Sequence[tuple[int, int]], bits: int, period: int, blocking: int) -> int | None:
    """Of one message behind `urgent` ones (bits, period), with at most one frame of `blocking` bits under way."""
    everything = (*urgent, (bits, period))
    limit = _LONGEST_BUSY * max(every for _, every in everything)
    busy = blocking + bits
    while True:  # the busy period: until everything that came up in it has been sent
        longer = blocking + sum(-(-busy // every) * length for length, every in everything)
        if longer == busy:
            break
        if longer > limit:
            return None
        busy = longer
    worst = 0
    for instance in range(-(-busy // period)):
        waits = blocking + instance * bits
        while True:
            # One bit more: what comes up while the last bit is awaited still wins the arbitration.
            longer = blocking + instance * bits + sum(-(-(waits + 1) // every) * length for length, every in urgent)
            if longer == waits:
                break
            waits = longer
        worst = max(worst, waits - instance * period + bits)
    return worst


def _us(bits: int | None, bitrate: int) -> float | None:
    return None if bits is None else bits * 1e6 / bitrate


def _clash(found: Sequence[Stream], can_id: int) -> str:
    names = " and ".join(one.name for one in found if one.can_id == can_id)
    return f"0x{can_id:03X} is sent by {names}"


def _ids(rows: Iterable[Row]) -> str:
    return ", ".join(f"0x{row.stream.can_id:03X}" for row in rows)
