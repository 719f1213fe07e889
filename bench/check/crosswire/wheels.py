"""Which wheel is to blame where counts and truth part: what each has counted beside what it really turned."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from bench.check.crosswire.counts import LONGEST_GAP_TICKS, Counts
from bench.config import Robot
from bench.messages import StateRow

KEPT_ROWS = 300
"""Three seconds: more than any window."""
SHARE = 0.05
LEAST_RAD = 0.05
"""A wheel that is off by less than both is not named: speeds every 10 ms do not add up better."""


class _Row(NamedTuple):
    tick: int
    state: StateRow
    counted: list[int]


class WheelWords:
    """Follows the rows of state and the counts at their ticks; works out nothing before it is asked."""

    def __init__(self, robot: Robot, columns: Sequence[str], counts: Counts) -> None:
        self._counts = counts
        self._columns = [columns.index(f"wheel{number}_radps") for number in range(1, len(robot.wheels) + 1)]
        self._rows: deque[_Row] = deque(maxlen=KEPT_ROWS)

    def take_row(self, tick: int, state: StateRow, counted: list[int]) -> None:
        """A row of state, and what the encoders have counted until this tick."""
        self._rows.append(_Row(tick, state, counted))

    def between(self, first_tick: int, last_tick: int) -> str:
        """What the wheels' encoders did wrong in this time, as the end of a sentence; empty where nothing is known."""
        rows = [row for row in self._rows if first_tick <= row.tick <= last_tick]
        if len(rows) < 2:
            return ""
        said = []
        for place, column in enumerate(self._columns):
            number, turned = place + 1, _turned_rad(rows, column)
            counted = (rows[-1].counted[place] - rows[0].counted[place]) * self._counts.rad_per_count[place]
            silent = max(
                (
                    one.last_tick - one.first_tick
                    for one in self._counts.silences
                    if one.wheel == place and one.last_tick > first_tick and one.first_tick < last_tick
                ),
                default=0,
            )
            if silent > LONGEST_GAP_TICKS:
                said.append(f"wheel {number} was not heard for {silent} ms")
            elif abs(counted - turned) > max(LEAST_RAD, SHARE * abs(turned)):
                said.append(f"wheel {number} {_how(turned, counted)}")
        return "; " + ", ".join(said) if said else "; each wheel counts what it turned: they slip, or stand elsewhere"


def _turned_rad(rows: Sequence[_Row], column: int) -> float:
    """What a wheel really turned: its true speed, from row to row."""
    turned = 0.0
    for before, now in pairwise(rows):
        turned += (now.tick - before.tick) / 2000.0 * (float(before.state[column]) + float(now.state[column]))
    return turned


def _how(turned: float, counted: float) -> str:
    if abs(counted + turned) <= SHARE * abs(turned):
        return "counts the other way round"
    if abs(counted) < SHARE * abs(turned):
        return "turns, and its counts stand still"
    return f"turned {turned:+.2f} rad and counted {counted:+.2f}"
