"""Bytes that came through a port with wrong settings: which frames, sent rightly, would have given just these bytes?

A frame's bits on the line are partly known: start and stop bits, parity, header, trailer, bits that are always 0. The
rest is free. The search walks along the line bit by bit, tries both values of a free bit, lets the wrongly set reader
look at them, and drops at once what disagrees with the bytes of the file. Ways that have come to the same state are
counted together, so the work stays small and the count exact.

How much that proves is counted too. Of 2**free possible frames `ways` give these m bytes; of random bytes one in
256**m does. (Bits that the reader takes too near to an edge of the line are left out of both.) The quotient, in bits,
is the frame's `gain`: what the frame says for the hypothesis. A reader so slow that any bytes fit gains nothing. Bytes
that are far from random, such as every second one 0xFF, may fit by their habits: therefore a hypothesis that gains
little must also fail on the same bytes in reverse order.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from math import ceil, fsum, inf, log2
from typing import NamedTuple

from bench.rc.line import LATE_BITS, Settings

LEAST_GAIN = 8.0
"""Bits; a frame that says less is none."""
_GREAT_GAIN, _LEAST_LEAD = 32.0, 12.0
MOST_STATES = 800
"""More ways than this at once, and the bytes say too little about the line to go on."""
LEAST_FRAMES, LEAST_SHARE, FRAMES = 4, 0.6, 6
"""How many frames must be explained, and what share of the bytes, of how many frames that are looked at."""
_JUDGED, _TRY_STATES, _JUDGE_STATES = 8, 60_000, 300_000
"""How many hypotheses get past the first frame, and how much may be tried before and after."""
_CLOCK_ERROR = 0.005
"""What the two clocks together may be apart. A sample that may fall on either side of an edge is not looked at."""
_SLOW = 1.3
"""A reader that is slower by more takes nearly all its samples near edges. It is only tried with exact clocks."""
_FAST = 0.6
_SLOWEST, _FASTEST = 4.0, 0.2
_EVEN_BYTES = 4096
_BAUDS = (57_600, 100_000, 115_200, 230_400, 420_000)


class Shape(NamedTuple):
    """What is always the same in the frames of a protocol."""

    protocol: str
    settings: Settings
    known: tuple[tuple[int, int], ...]
    """For each byte, the bits that are known (a mask), and their values."""


_BYTE, _ANY, _ZERO = 0xFF, (0, 0), (0xFF, 0)
SHAPES = (
    Shape(
        "uart12",
        Settings(115_200, True, 2),
        ((_BYTE, 0xAA), *(((0xF0, 0), _ANY) * 4), (0xFE, 0), (0xFE, 0), (_BYTE, 0x55)),
    ),
    # Footers 00, 04, 14, 24, 34; of the flags the upper four bits are 0 nearly everywhere.
    Shape("sbus", Settings(100_000, True, 2, True), ((_BYTE, 0x0F), *(_ANY,) * 22, (0xF0, 0), (0xCB, 0))),
    # As it is without a computer at the transmitter: no mouse, no keys.
    Shape("dbus", Settings(100_000, True, 1, True), (*(_ANY,) * 6, *(_ZERO,) * 10, _ANY, (0xF8, 0))),
    Shape("ibus", Settings(115_200), ((_BYTE, 0x20), (_BYTE, 0x40), *((_ANY, (0xF0, 0)) * 14), _ANY, (0xF0, 0xF0))),
    Shape("crsf", Settings(420_000), ((_BYTE, 0xC8), (_BYTE, 0x18), (_BYTE, 0x16), *(_ANY,) * 23)),
)


class Reading(NamedTuple):
    """A frame that explains bytes of a file."""

    start: int
    end: int
    """Offsets in the file: the bytes that the wrong reader made of this frame."""
    ways: int
    """How many frames would have given them."""
    gain: float
    """In bits: how much better than chance."""


class _Step(NamedTuple):
    """One bit of the line."""

    values: tuple[int, ...]
    """What it may be; empty for the parity bit, which follows from the data."""
    data: bool


class _Look(NamedTuple):
    """What a reader samples in one bit of the line."""

    mask: int
    """The data bits that it takes from here."""
    start: bool
    stop: bool


class _Plan(NamedTuple):
    """One shape through one reader."""

    steps: tuple[_Step, ...]
    """From the first start bit until the reader is at rest again."""
    looks: tuple[_Look, ...]
    """By bits of the line since the edge that began the reader's byte."""
    flip: int
    """1 where one of the two is inverted and the other is not."""
    free: int
    parity: bool
    """Whether the line has it, and the search must count ones."""
    seen: int
    """How many data bits of each of its bytes the reader takes from places that are sure."""


@lru_cache
def _plan(shape: Shape, reader: Settings) -> _Plan:
    sender = shape.settings
    zero, one = _Step((0,), False), _Step((1,), False)
    steps: list[_Step] = []
    for mask, value in shape.known:
        data = [_Step((value >> k & 1,) if mask >> k & 1 else (0, 1), True) for k in range(8)]
        steps += [zero, *data, *[_Step((), False)] * sender.even_parity, *[one] * sender.stop_bits]
    free = 8 * len(shape.known) - sum(mask.bit_count() for mask, _ in shape.known)
    ratio = sender.baud / reader.baud
    steps += [one] * (ceil(11.5 * ratio) + 2)
    looks = _looks(ratio, reader)
    seen = sum(look.mask.bit_count() for look in looks)
    return _Plan(tuple(steps), looks, int(sender.inverted != reader.inverted), free, sender.even_parity, seen)


def _looks(ratio: float, reader: Settings) -> tuple[_Look, ...]:
    """`ratio`: bits of the line in one bit of the reader."""
    stop_at = 10 if reader.even_parity else 9
    looks = [_Look(0, False, False)] * (int((stop_at + 1) * ratio) + 1)
    for k in (*range(9), stop_at):  # a reader's parity bit changes nothing
        at = (k + 0.5 + LATE_BITS) * ratio
        unsure = (LATE_BITS + (k + 0.5) * _CLOCK_ERROR) * ratio if ratio < _SLOW else 0.0
        mask, start, stop = looks[int(at)]
        if k in (0, stop_at):
            looks[int(at)] = _Look(mask, start or k == 0, stop or k == stop_at)
        elif unsure <= at % 1 <= 1 - unsure:
            looks[int(at)] = _Look(mask | 1 << (k - 1), start, stop)
    return tuple(looks)


_States = dict[tuple[int, int, int, int], int]
"""(next byte of the file, bit of the line that began it or -1, level now, parity so far) to the ways that lead there"""


class Budget:
    """How much may be tried; the unit is one state carried over one bit of the line, about a microsecond."""

    def __init__(self, states: int) -> None:
        self.left = states


def frames_at(
    data: bytes, start: int, shape: Shape, reader: Settings, budget: Budget, least_gain: float = LEAST_GAIN
) -> list[Reading]:
    """What a frame explains of the bytes from `start` on, best first: it may end at more than one place.

    Empty where no frame does, or none with enough gain, or where there is too much to try.
    """
    plan = _plan(shape, reader)
    states: _States = {(start, -1, 1 ^ plan.flip, 0): 1}
    for n, step in enumerate(plan.steps):
        budget.left -= len(states)
        states = _advanced(states, n, step, plan, data)
        if not 0 < len(states) <= MOST_STATES or budget.left < 0:
            return []
    found = [
        Reading(start, end, ways, plan.seen * (end - start) + log2(ways) - plan.free)
        for (end, _, _, _), ways in states.items()
    ]
    return sorted((one for one in found if one.gain >= least_gain), key=lambda one: -one.gain)


def _advanced(states: _States, n: int, step: _Step, plan: _Plan, data: bytes) -> _States:
    """All states one bit of the line later."""
    (values, is_data), looks, flip, counts, size = step, plan.looks, plan.flip, plan.parity, len(data)
    after: _States = {}
    for (at, edge, level, parity), ways in states.items():
        for bit in values or (parity,):
            view, began, reached = bit ^ flip, edge, at
            if began < 0 and level > view:
                began = n
            if began >= 0:
                if reached == size:
                    continue  # the reader sees a byte that the file does not have
                mask, is_start, is_stop = looks[n - began]
                if mask and data[reached] & mask != (mask if view else 0):
                    continue
                if is_start and view:
                    began = -1  # it was too short for a start bit
                elif is_stop:
                    began, reached = -1, reached + 1
            ones = parity ^ bit if is_data and counts else parity if values else 0
            key = (reached, began, view, ones)
            after[key] = after.get(key, 0) + ways
    return after


class Explanation(NamedTuple):
    """What one hypothesis says to the bytes of a file."""

    shape: Shape
    reader: Settings
    readings: tuple[Reading, ...]
    looked_at: int
    """How many bytes were gone through."""

    @property
    def share(self) -> float:
        """Of the bytes that were gone through, those that some frame explains."""
        return sum(reading.end - reading.start for reading in self.readings) / max(1, self.looked_at)

    @property
    def proves_the_line_only(self) -> bool:
        """Whether the reader is so fast that frames of any protocol with the same settings would fit as well.

        It does not see how long the line stays up between its bytes, so a frame can be stretched over what it is not.
        """
        return self.shape.settings.baud / self.reader.baud < _FAST

    @property
    def gain(self) -> float:
        """Bits a frame, on average."""
        return fsum(reading.gain for reading in self.readings) / max(1, len(self.readings))

    @property
    def density(self) -> float:
        """Bits a byte, of those that were gone through: what hypotheses are compared by."""
        return fsum(reading.gain for reading in self.readings) / max(1, self.looked_at)


def explain(data: bytes, shape: Shape, reader: Settings, budget: Budget, frames: int) -> Explanation:
    """Frame after frame, up to so many of them; bytes that no frame explains are passed over."""
    found: list[Reading] = []
    known: dict[int, list[Reading]] = {}

    def at_offset(at: int) -> list[Reading]:
        if at not in known:
            known[at] = frames_at(data, at, shape, reader, budget)
        return known[at]

    at = 0
    while at < len(data) and len(found) < frames and budget.left > 0:
        options = at_offset(at)
        if options:
            # Of several places where it may end, one after which the next frame can begin.
            followed = (one for one in options if one.end == len(data) or at_offset(one.end))
            found.append(next(followed, options[0]))
            at = found[-1].end
        else:
            at += 1
    return Explanation(shape, reader, tuple(found), at)


def search(data: bytes) -> list[Explanation]:
    """What explains the bytes, the best first. Looks at the first few frames, for about a second."""
    if _even(data[:_EVEN_BYTES]):
        return []
    tried = []
    for shape, reader in _hypotheses():
        if len(data) < _reach(shape, reader, LEAST_FRAMES - 1):
            continue
        explanation = explain(data[: _reach(shape, reader, 2)], shape, reader, Budget(_TRY_STATES), 1)
        if explanation.readings:
            tried.append(explanation)
    tried.sort(key=lambda one: -one.density)
    judged = [
        explain(data[: _reach(shape, reader, FRAMES)], shape, reader, Budget(_JUDGE_STATES), FRAMES)
        for shape, reader, *_ in tried[:_JUDGED]
    ]
    enough = [one for one in judged if len(one.readings) >= LEAST_FRAMES and one.share >= LEAST_SHARE]
    proved = [one for one in enough if _is_more_than_a_line(data, one)]
    proved = [one for one in proved if one.gain >= _GREAT_GAIN or not _fits_backwards(data, one)]
    return sorted(proved, key=lambda one: -one.density)


def _is_more_than_a_line(data: bytes, explanation: Explanation) -> bool:
    """Whether the frames fit by what is theirs: any bytes at these settings would do much worse.

    Start, stop and parity bits alone gain much where the reader is fast enough to see them: that proves the line's
    settings, but no protocol. Slow readers see next to none of them; of fast ones no more than the line is believed.
    """
    shape, reader, readings, _ = explanation
    if explanation.proves_the_line_only or shape.settings.baud / reader.baud > _SLOW:
        return True
    any_bytes = shape._replace(known=(_ANY,) * len(shape.known))
    leads = []
    for one in readings[:LEAST_FRAMES]:
        free = frames_at(data, one.start, any_bytes, reader, Budget(_JUDGE_STATES), -inf)
        leads += [one.gain - other.gain for other in free if other.end == one.end]
    return len(leads) == LEAST_FRAMES and fsum(leads) >= _LEAST_LEAD * LEAST_FRAMES


def _fits_backwards(data: bytes, explanation: Explanation) -> bool:
    """Whether the same bytes in reverse order would do nearly as well."""
    shape, reader, readings, looked_at = explanation
    control = explain(data[:looked_at][::-1], shape, reader, Budget(_JUDGE_STATES), len(readings))
    return control.density > 0.6 * explanation.density


def _even(data: bytes) -> bool:
    """Whether all byte values are about equally frequent. Frames have headers and sticks at rest: theirs never are.

    Two bytes picked by chance are equal once in 256 times if they are random.
    """
    pairs = len(data) * (len(data) - 1)
    return pairs == 0 or sum(count * (count - 1) for count in Counter(data).values()) / pairs < 2 / 256


def _hypotheses() -> Iterator[tuple[Shape, Settings]]:
    """Every protocol through every port that does not simply read it, with one mistake or two that go together."""
    for shape in SHAPES:
        sender = shape.settings
        for baud, even_parity, inverted in product(_BAUDS, (False, True), (False, True)):
            ratio = sender.baud / baud
            turned, more_parity = inverted != sender.inverted, even_parity > sender.even_parity
            # A reader without parity still gets every byte of a line that has it: the stop bit is looked at too early.
            reads = ratio == 1 and not turned and not more_parity
            too_many = (turned and ratio > _SLOW) or (more_parity and ratio != 1)
            if not reads and not too_many and _FASTEST <= ratio <= _SLOWEST:
                yield shape, Settings(baud, even_parity, 1, inverted)


def _reach(shape: Shape, reader: Settings, frames: int) -> int:
    """About how many bytes a reader makes of so many frames, and of a part of one before."""
    bits = len(shape.known) * (9 + shape.settings.even_parity + shape.settings.stop_bits)
    byte_bits = max(7.0, 10 * shape.settings.baud / reader.baud)
    return ceil((frames + 1) * bits / byte_bits)
