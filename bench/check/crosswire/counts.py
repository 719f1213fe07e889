"""Rotor counts out of feedback frames, as anybody on the bus can take them: unwrapped, summed, by wheel and tick.

Nearly every block brings each wheel's report once a tick in the same order; then whole columns are taken at once. What
comes otherwise is taken frame by frame. A rotor is unwrapped the shorter way round, from frame to frame, however long
that was: where it turned further meanwhile, the sum is wrong, and `silences` says where that may have been.
"""

from __future__ import annotations

import math
import sys
from array import array
from collections.abc import Sequence
from itertools import accumulate
from operator import sub
from typing import NamedTuple

from bench.canbus.c610 import COUNTS, FEEDBACK_ID
from bench.check.crosswire.block import Block, Pattern
from bench.config import Wheel

HALF_TURN = COUNTS // 2
LONGEST_GAP_TICKS = 2
"""Up to one lost frame the shorter way round is right below 15,000 rotor rpm."""
MOST_SILENCES = 100
_REPORT_BYTES = 8
# By the difference of two angles, which may be negative as an index may: the step the shorter way round.
_STEPS = [((apart + HALF_TURN) % COUNTS) - HALF_TURN for apart in (*range(COUNTS), *range(-COUNTS, 0))]


class Silence(NamedTuple):
    """A wheel whose encoder was not heard, by its place, between two ticks in which it was."""

    wheel: int
    first_tick: int
    last_tick: int


class Counts:
    """The encoders of some wheels, driven or dead. `take` gives what each has counted at the end of each tick."""

    def __init__(self, wheels: Sequence[Wheel]) -> None:
        self._places = {FEEDBACK_ID + wheel.can_id: place for place, wheel in enumerate(wheels)}
        self.rad_per_count = [wheel.direction * math.tau / (COUNTS * wheel.gear) for wheel in wheels]
        """Of the wheel, in its positive sense."""
        self._totals = [0] * len(wheels)
        self._angles: list[int | None] = [None] * len(wheels)
        self._heard = [-1] * len(wheels)
        self._usual: Pattern = ()
        self._usual_starts: list[int] = []
        self.silences: list[Silence] = []

    @property
    def complete(self) -> bool:
        """Whether every wheel has been heard."""
        return None not in self._angles

    def take(self, block: Block) -> list[list[int]]:
        """For each wheel, its sum after each tick of the block."""
        return self._columns(block) or self._frame_by_frame(block)

    def _columns(self, block: Block) -> list[list[int]] | None:
        """The usual block, each wheel's report once a tick in the same place; None where it is another."""
        pattern = block.feedback.pattern
        starts = self._starts(pattern) if pattern else None
        if pattern is None or starts is None:
            return None
        words = array("H", b"".join(block.feedback.datas))
        if sys.byteorder == "little":
            words.byteswap()
        stride = sum(length for _, length in pattern) // 2
        found = []
        for place, start in enumerate(starts):
            angles = words[start::stride].tolist()
            last = self._angles[place]
            self._note_silence(place, block.first)
            before = [angles[0] if last is None else last, *angles]
            # In steps that all run in C: a third of the cost of saying it with operators.
            sums = list(accumulate(map(_STEPS.__getitem__, map(sub, angles, before)), initial=self._totals[place]))
            found.append(sums[1:])
            self._totals[place], self._angles[place], self._heard[place] = sums[-1], angles[-1], block.ticks[-1]
        return found

    def _starts(self, pattern: Pattern) -> list[int] | None:
        """Where the angle of each wheel lies in the 16-bit words of a tick; None where that cannot be said."""
        if pattern == self._usual:
            return self._usual_starts
        at, starts = 0, {}
        for can_id, length in pattern:
            if length & 1 or can_id in starts or (can_id in self._places and length != _REPORT_BYTES):
                return None
            starts[can_id] = at // 2
            at += length
        if not self._places.keys() <= starts.keys():
            return None
        self._usual, self._usual_starts = pattern, [starts[can_id] for can_id in self._places]
        return self._usual_starts

    def _frame_by_frame(self, block: Block) -> list[list[int]]:
        found: list[list[int]] = [[] for _ in self._places]
        totals, angles = self._totals, self._angles
        for tick, frames in zip(block.ticks, block.can_feedback, strict=True):
            for can_id, data in frames:
                place = self._places.get(can_id)
                if place is None or len(data) != _REPORT_BYTES:
                    continue
                angle = data[0] << 8 | data[1]
                last = angles[place]
                if last is not None:
                    totals[place] += ((angle - last + HALF_TURN) % COUNTS) - HALF_TURN
                    self._note_silence(place, tick)
                angles[place], self._heard[place] = angle, tick
            for sums, total in zip(found, totals, strict=True):
                sums.append(total)
        return found

    def _note_silence(self, place: int, tick: int) -> None:
        heard = self._heard[place]
        if heard >= 0 and tick - heard > LONGEST_GAP_TICKS and len(self.silences) < MOST_SILENCES:
            self.silences.append(Silence(place, heard, tick))
