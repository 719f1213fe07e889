"""Where some wheels' counts have come to: summed counts through the wheels' kinematics, in steps of 20 ms or less."""

from __future__ import annotations

from collections.abc import Sequence
from operator import mul, sub

from bench.check.crosswire.block import Block
from bench.check.crosswire.counts import Counts
from bench.check.crosswire.way import Way, fitted
from bench.config import Wheel
from bench.kinematics import Kinematics


class CountedWay:
    """`take` a block, then ask `at` ticks of it, or the last one before it, in rising order."""

    def __init__(self, wheels: Sequence[Wheel], kinematics: Kinematics) -> None:
        self.counts = Counts(wheels)
        self._rows = kinematics.forward_rows
        self._way = Way()
        self.reached: list[int] = [0] * len(wheels)
        """What each wheel had counted at the tick that was asked for last."""
        self._before: list[int] = self.reached
        self._first = 0

    def take(self, block: Block) -> None:
        """The next block."""
        self._before, self._first = self.counts.take(block), block.first

    def release(self) -> None:
        """No more ticks of this block will be asked for."""
        self.counts.release()

    def at(self, tick: int) -> Way:
        """The way until the end of this tick."""
        place = tick - self._first
        sums = self.counts.sums(place) if place >= 0 else self._before
        reached = self.reached
        if sums != reached:
            turned_rad = list(map(mul, map(sub, sums, reached), self.counts.rad_per_count))
            self._way = self._way.turned_by(*fitted(self._rows, turned_rad))
            self.reached = sums
        return self._way
