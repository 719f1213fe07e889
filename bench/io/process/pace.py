"""A child's time as its parent sees it: its tick by now, how it keeps pace, how far ahead of it inputs are made."""

from __future__ import annotations

from bench.io.clock import TICK_NS, WallPacer, now_ns
from bench.io.process.wire import State

LEAD_TICKS, MOST_LEAD_TICKS = 80, 250
"""How far ahead an operator's inputs are made: a frame of 20 Hz and a hiccup; more where frames take longer."""


class ChildsPacer(WallPacer):
    """Tells how the child keeps time. Its rate is that of the wall; once the child is gone it is a pacer like any."""

    is_theirs = True

    def __init__(self) -> None:
        super().__init__()
        self.tick = 0
        """How many ticks had run when the child last told."""
        self._told_ns = 0

    @property
    def has_begun(self) -> bool:
        """Whether the child has told of a tick."""
        return self._told_ns > 0

    def now_tick(self) -> int:
        """How many ticks must have run by now."""
        return self.tick + ((now_ns() - self._told_ns) // TICK_NS if self.has_begun else 0)

    def take(self, state: State) -> None:
        """What the child tells."""
        gone = state.tick - self.tick
        if self.has_begun and gone > 0:
            self.speed = gone * TICK_NS / max(1, state.at_ns - self._told_ns)
        self.tick, self._told_ns = state.tick, state.at_ns
        self.late_ticks, self.slipped_ticks = int(state.late_us / 1000), state.slipped_ticks

    def set_rate(self, rate: float) -> None:
        """Without effect while the child runs: real time has one rate."""
        if not self.is_theirs or rate == 1.0:
            super().set_rate(rate)


class Lead:
    """How far an operator's inputs are made ahead of the child."""

    def __init__(self) -> None:
        self.made_tick = 0
        """Up to which they are made."""
        self.ticks = LEAD_TICKS
        """What is aimed at: twice what the operator's last frame took, and slowly less again."""
        self._asked_ns = 0

    def due(self, now_tick: int) -> int:
        """For how many ticks more, now that the child is at `now_tick`. Asked once a frame."""
        at_ns = now_ns()
        frame_ticks = (at_ns - self._asked_ns) // TICK_NS if self._asked_ns else 0
        self._asked_ns = at_ns
        self.ticks = max(LEAD_TICKS, min(MOST_LEAD_TICKS, max(2 * frame_ticks, self.ticks - 1)))
        self.made_tick = max(self.made_tick, now_tick)  # away for long: what nobody asked for in time is not made
        return max(0, now_tick + self.ticks - self.made_tick)

    def has_room(self, ticks: int, now_tick: int) -> bool:
        """Whether the child can use so many more yet."""
        return self.made_tick + ticks <= now_tick + MOST_LEAD_TICKS + LEAD_TICKS
