"""Wall time and pacing. The only file that reads a clock; everything else is told the tick.

A pacer says how many ticks may run now. It knows nothing of benches: `due(done)` takes the number that have run.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from bench.io.lateness import Lateness
from bench.io.punctual import be_ordinary
from bench.messages import TICK_US

TICK_NS = TICK_US * 1000
BURST_TICKS = 250
"""Five frames of a 20 Hz screen: a hiccup is caught up, a longer stop is not run through in one go."""
WINDOW_NS = 1_000_000_000
"""Speed and lateness are measured over this long, so that the figures can be read."""
MOST_SPIN_NS = 50_000
"""Woken this much before a deadline, a quiet machine is on time to the microsecond; a busy one charges the spinner."""
MISSED_NS = 300_000
CALM_TICKS, MOST_CALM_TICKS = 1000, 64_000
SLIP_NS = BURST_TICKS * TICK_NS


def now_ns() -> int:
    """Monotonic time, for durations only."""
    return time.monotonic_ns()


def wait_ns(duration_ns: int) -> None:
    """Sleep so long."""
    time.sleep(duration_ns / 1e9)


class Pacer(Protocol):
    """How many ticks may run now, and how well that has gone."""

    rate: float
    """Simulated seconds for one of the wall, as asked for."""
    speed: float | None
    """The same as measured; None before there is a measurement."""
    late_ticks: int
    """The most ticks that were due at once, in the last window."""
    slipped_ticks: int
    """Ticks of wall time that were given up since the start, because the machine could not keep pace."""

    def due(self, done: int) -> int:
        """How many ticks may run now, given how many have run."""
        ...

    def restart(self) -> None:
        """Count from the next `due` on: what passed until then (a pause, a suspended process) is no delay."""
        ...

    def set_rate(self, rate: float) -> None:
        """Run faster or in slow motion from the next `due` on."""
        ...


class WallPacer:
    """Wall time times `rate`. Deadlines are absolute, so errors never add up; `burst_ticks` bounds each answer."""

    def __init__(self, rate: float = 1.0, burst_ticks: int = BURST_TICKS, read_ns: Callable[[], int] = now_ns) -> None:
        if burst_ticks < 1:
            raise ValueError(f"burst_ticks {burst_ticks} is less than one tick")
        self.rate = rate
        self.speed: float | None = None
        self.late_ticks = 0
        self.slipped_ticks = 0
        self._burst = burst_ticks
        self._read_ns = read_ns
        self.set_rate(rate)

    def set_rate(self, rate: float) -> None:
        """Run at another rate from the next `due` on. Raises ValueError for a rate that is not positive."""
        if not rate > 0.0:
            raise ValueError(f"rate {rate} is not positive")
        self.rate = rate
        self.restart()

    def restart(self) -> None:
        """Count from the next `due` on."""
        self._start: tuple[int, int] | None = None  # (wall ns, ticks that were due by then)
        self._window = (0, 0)
        self._window_late = 0

    def due(self, done: int) -> int:
        """Ticks between what has run and what should have, at most the burst; the rest slips and is counted."""
        now = self._read_ns()
        if self._start is None:
            self._start = self._window = (now, done)
        start_ns, start_tick = self._start
        behind = start_tick + int((now - start_ns) * self.rate) // TICK_NS - done
        if behind > self._burst:
            slip = behind - self._burst
            self.slipped_ticks += slip
            self._start = (start_ns, start_tick - slip)
            behind = self._burst
        self._measure(now, done, behind)
        return max(0, behind)

    def _measure(self, now: int, done: int, behind: int) -> None:
        self._window_late = max(self._window_late, behind)
        window_ns, window_done = self._window
        if now - window_ns >= WINDOW_NS:
            self.speed = (done - window_done) * TICK_NS / (now - window_ns)
            self.late_ticks = self._window_late
            self._window = (now, done)
            self._window_late = 0


class FreePacer:
    """As many ticks as `burst_ticks` at every call: replays and tests that wait for nobody."""

    def __init__(self, burst_ticks: int = BURST_TICKS) -> None:
        self.rate = 1.0
        self.speed: float | None = None
        self.late_ticks = 0
        self.slipped_ticks = 0
        self._burst = burst_ticks

    def set_rate(self, rate: float) -> None:
        """Remembered, without effect."""
        self.rate = rate

    def restart(self) -> None:
        """Nothing to forget."""

    def due(self, done: int) -> int:
        """The burst."""
        return self._burst


class Metronome:
    """Absolute deadlines, a millisecond apart: `wait` for each. It sleeps to just before it and spins the rest.

    Spinning is given up where it makes things worse: after a miss it is off, and comes back the later the more often
    it was; but for a process with real-time priority, which pays nothing for it (`spins_on`). What is behind by more
    than a quarter of a second slips and is counted.
    """

    def __init__(
        self, read_ns: Callable[[], int] = now_ns, sleep: Callable[[float], None] = time.sleep, spin: bool = True
    ) -> None:
        self.lateness = Lateness()
        self.window_us = 0.0
        """The most since somebody set this to 0."""
        self.slipped_ticks = 0
        self.spins_on = False
        self._read_ns, self._sleep = read_ns, sleep
        self._most_spin_ns = MOST_SPIN_NS if spin else 0
        self._spin_ns = self._most_spin_ns
        self._calm, self._calm_needed = 0, CALM_TICKS
        self.restart()

    def restart(self) -> None:
        """Count from now on."""
        self._deadline_ns = self._read_ns() + TICK_NS

    @property
    def is_behind(self) -> bool:
        """Whether the next deadline has passed already."""
        return self._read_ns() >= self._deadline_ns

    def wait(self) -> int:
        """Until the next deadline; by how many ns it was missed."""
        read_ns, deadline_ns = self._read_ns, self._deadline_ns
        left_ns = deadline_ns - read_ns()
        if left_ns > self._spin_ns:
            self._sleep((left_ns - self._spin_ns) / 1e9)
        now = read_ns()
        while now < deadline_ns:
            now = read_ns()
        late_ns = now - deadline_ns
        self.lateness.add(late_ns)
        self._deadline_ns = deadline_ns + TICK_NS
        if late_ns > 1000 * self.window_us:
            self.window_us = late_ns / 1000
        if late_ns > MISSED_NS:
            self._missed(late_ns)
        elif self._spin_ns < self._most_spin_ns:
            self._calm += 1
            if self._calm >= self._calm_needed:
                self._calm, self._spin_ns = 0, min(self._most_spin_ns, self._spin_ns + 10_000)
        return late_ns

    def _missed(self, late_ns: int) -> None:
        if not self.spins_on:
            if self._spin_ns:
                self._calm_needed = min(2 * self._calm_needed, MOST_CALM_TICKS)
            self._spin_ns = self._calm = 0
        if late_ns > SLIP_NS:
            be_ordinary()
            self.spins_on = False
            slip = late_ns // TICK_NS
            self.slipped_ticks += slip
            self._deadline_ns += slip * TICK_NS
