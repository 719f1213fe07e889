"""Rotor counts out of feedback frames, as anybody on the bus can take them: unwrapped and summed, by wheel.

Nearly every block brings each wheel's report once a tick in the same order. Then it is enough to read every fifth, as
long as no rotor turns further than three eighths of a turn meanwhile; to turn further than five eighths, which would
look like that backwards, a wheel behind a 36:1 gear would have to speed up by 8 rad/s in 5 ms. Faster rotors are read
every other tick, or every one; what comes in another order, or not every tick, is read frame by frame. A rotor is
unwrapped the shorter way round, however long it was silent: where it turned further, the sum is wrong, and `silences`
says when.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from functools import lru_cache
from itertools import accumulate
from operator import sub
from typing import NamedTuple

from bench.canbus.c610 import COUNTS, FEEDBACK_ID
from bench.check.crosswire.block import Block, Pattern
from bench.config import Wheel

HALF_TURN = COUNTS // 2
STRIDES = (5, 2, 1)
"""Ticks between two readings, the longest first."""
SURE_COUNTS = 3 * COUNTS // 8
LONGEST_GAP_TICKS = 2
"""Up to one lost frame the shorter way round is right below 15,000 rotor rpm."""
MOST_SILENCES = 100
_REPORT_BYTES = 8


class Silence(NamedTuple):
    """A wheel whose encoder was not heard, by its place, between two ticks in which it was."""

    wheel: int
    first_tick: int
    last_tick: int


class Counts:
    """The encoders of some wheels, driven or dead. `take` a block, then ask for the `sums` at places of it."""

    def __init__(self, wheels: Sequence[Wheel]) -> None:
        self._wheels = {FEEDBACK_ID + wheel.can_id: place for place, wheel in enumerate(wheels)}
        self.rad_per_count = [wheel.direction * math.tau / (COUNTS * wheel.gear) for wheel in wheels]
        """Of the wheel, in its positive sense."""
        self.silences: list[Silence] = []
        self._totals = [0] * len(wheels)
        self._end = self._totals  # at the end of the last block
        self._angles: list[int | None] = [None] * len(wheels)  # with which the totals were reached
        self._heard = [-1] * len(wheels)
        self._next_stride = self._stride = 1
        # Of the block: each wheel's sums and angles at every `_stride`-th tick, and its place among a tick's frames.
        self._sums: list[list[int]] = [[0]] * len(wheels)
        self._readings: list[tuple[int, ...]] = []
        self._at: list[int] | None = None
        self._block: Block | None = None
        self._usual: tuple[Pattern | None, list[int] | None] = None, None

    @property
    def complete(self) -> bool:
        """Whether every wheel has been heard."""
        return None not in self._angles

    def take(self, block: Block) -> list[int]:
        """The next block; what each wheel had counted at the end of the one before it."""
        before = self._end
        self._block, self._at = block, self._starts(block.feedback.pattern)
        if self._at is None:
            self._frame_by_frame(block)
            return before
        for wheel in range(len(self._heard)):
            self._note_silence(wheel, block.first)
        self._heard = [block.ticks[-1]] * len(self._heard)
        for stride in STRIDES:
            if stride <= self._next_stride:
                longest = self._read(block, self._at, stride)
                if longest <= SURE_COUNTS:
                    break
        self._stride = stride
        self._totals = [sums[-1] for sums in self._sums]
        self._angles = [angles[-1] for angles in self._readings]
        # As seldom as would have done in this block, with room for a quarter more.
        self._next_stride = next((one for one in STRIDES if longest * one * 5 <= SURE_COUNTS * stride * 4), 1)
        return before

    def release(self) -> None:
        """Let go of the block: whoever holds a block longer than needed pays for its removal from a cold cache."""
        assert self._block is not None
        self._end = self.sums(len(self._block) - 1)
        self._block = None

    def sums(self, place: int) -> list[int]:
        """What each wheel has counted until the end of the tick at this place of the block."""
        row, beyond = divmod(place, self._stride)
        found = [column[row] for column in self._sums]
        if beyond and self._block is not None and self._at is not None:
            datas, width = self._block.feedback.datas, len(self._block.can_feedback[0])
            for wheel, start in enumerate(self._at):
                data = datas[place * width + start]
                found[wheel] += _step(self._readings[wheel][row], data[0] << 8 | data[1])
        return found

    def _starts(self, pattern: Pattern | None) -> list[int] | None:
        """Where the report of each wheel stands among the frames of every tick; None where that cannot be said."""
        if pattern != self._usual[0]:
            starts = None
            if pattern is not None:
                ids = [can_id for can_id, _ in pattern]
                wanted = [(can_id, _REPORT_BYTES) for can_id in self._wheels]
                if len(set(ids)) == len(ids) and set(wanted) <= set(pattern):
                    starts = [pattern.index(one) for one in wanted]
            self._usual = pattern, starts
        return self._usual[1]

    def _read(self, block: Block, at: list[int], stride: int) -> int:
        """Read every `stride`-th tick of a block; the longest step that a rotor made."""
        datas, step = block.feedback.datas, stride * len(block.can_feedback[0])
        unpack = _angles((len(block) + stride - 1) // stride).unpack
        self._sums, self._readings, longest = [], [], 0
        for start, last, total in zip(at, self._angles, self._totals, strict=True):
            # All in calls of C: a quarter of the cost of saying it with operators.
            readings = unpack(b"".join(datas[start::step]))
            before = (readings[0] if last is None else last, *readings)
            try:
                steps = list(map(_STEPS.__getitem__, map(sub, readings, before)))
            except IndexError:  # an angle of more than a turn: nonsense, but it was on the wire
                steps = list(map(_step, before, readings))
            longest = max(longest, max(steps), -min(steps))
            self._sums.append(list(accumulate(steps, initial=total))[1:])
            self._readings.append(readings)
        return longest

    def _frame_by_frame(self, block: Block) -> None:
        self._stride = self._next_stride = 1
        self._sums, self._readings = [[] for _ in self._wheels], []
        totals, angles = list(self._totals), list(self._angles)
        for tick, frames in zip(block.ticks, block.can_feedback, strict=True):
            for can_id, data in frames:
                wheel = self._wheels.get(can_id)
                if wheel is None or len(data) != _REPORT_BYTES:
                    continue
                angle = data[0] << 8 | data[1]
                last = angles[wheel]
                if last is not None:
                    totals[wheel] += _step(last, angle)
                    self._note_silence(wheel, tick)
                angles[wheel], self._heard[wheel] = angle, tick
            for sums, total in zip(self._sums, totals, strict=True):
                sums.append(total)
        self._totals, self._angles = totals, angles

    def _note_silence(self, wheel: int, tick: int) -> None:
        heard = self._heard[wheel]
        if heard >= 0 and tick - heard > LONGEST_GAP_TICKS and len(self.silences) < MOST_SILENCES:
            self.silences.append(Silence(wheel, heard, tick))


# By the difference of two angles, which may be negative as an index may: the step the shorter way round.
_STEPS = [((apart + HALF_TURN) % COUNTS) - HALF_TURN for apart in (*range(COUNTS), *range(-COUNTS, 0))]


@lru_cache(maxsize=256)
def _angles(reports: int) -> struct.Struct:
    """The angles of so many reports in a row."""
    return struct.Struct(">" + f"H{_REPORT_BYTES - 2}x" * reports)


def _step(before: int, now: int) -> int:
    """From one angle to another, the shorter way round."""
    return ((now - before + HALF_TURN) % COUNTS) - HALF_TURN
