"""A scope on decoded signals: time base, trigger, and what is to be drawn of it. For a screen that asks.

Tell it the ticks that have passed since the last time (`take`), then ask (`picture`). It samples every tick, whatever
the screen's rate, and keeps as many samples as its longest time base needs. What it gives is plain values: for each
column of dots the least and the greatest sample that fall into it.

    auto      the last trigger; where none comes for a while, what is new
    normal    the last trigger
    single    the first trigger after it was armed, and then nothing more

The trigger looks at the first signal: where it crosses `level`, rising or falling.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Sequence
from copy import copy
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from bench.check.signals import Signals, names
from bench.config import Robot
from bench.messages import TickOutput

SPANS_MS = (20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)
AUTO, NORMAL, SINGLE = "auto", "normal", "single"
MODES = (AUTO, NORMAL, SINGLE)
RISING, FALLING = "rising", "falling"
EDGES = (RISING, FALLING)
KEPT_TICKS = 2 * SPANS_MS[-1]
BEFORE = 0.2
"""The share of the picture that lies before the trigger."""
PATIENCE_TICKS = 500
"""So long after a picture is complete `auto` waits for another trigger before it runs free."""
MOST_TRACES = 4
_NO_NUMBERS = ("link", "driver")

FREE, TRIGGERED, WAITING, CAUGHT = "free", "triggered", "waiting", "caught"


class ScopeSettings(NamedTuple):
    """What the person has set. `shot` counts how often a single trigger was armed."""

    signals: tuple[str, ...]
    span_ms: int = 1000
    mode: str = AUTO
    edge: str = RISING
    level: float = 0.0
    shot: int = 0


class Trace(NamedTuple):
    """One signal: for each column the least and the greatest sample; NaN where there is none."""

    name: str
    low: tuple[float, ...]
    high: tuple[float, ...]
    last: float
    """The newest sample of all, whatever the picture shows."""


class ScopePicture(NamedTuple):
    """What the scope shows. `start_tick` is that of the left edge; `trigger_tick` None where it runs free."""

    settings: ScopeSettings
    state: str
    start_tick: int
    trigger_tick: int | None
    traces: tuple[Trace, ...]


def scope_signals(robot: Robot, state_columns: Sequence[str]) -> tuple[str, ...]:
    """Every signal that can be drawn: those of a run that are numbers."""
    return tuple(name for name in names(robot, state_columns) if name not in _NO_NUMBERS and name != "t_s")


class Scope:
    """Samples the signals of its settings. Raises ValueError for settings with a signal that the run does not have."""

    def __init__(self, robot: Robot, state_columns: Sequence[str], settings: ScopeSettings) -> None:
        self.settings = settings
        self._signals = Signals(robot, state_columns, settings.signals)
        self._samples = {name: array("d") for name in settings.signals}
        self._first_tick = 0
        """Of the oldest sample that is kept."""
        self._next_tick: int | None = None
        self._looked_at = 0
        """The tick up to which the trigger was looked for."""
        self._shown: tuple[int, int] | None = None
        """Start and trigger of the picture that stands."""
        self._pending: int | None = None
        """A trigger whose picture is not complete yet."""
        self._known: dict[str, tuple[tuple[int, int, int], tuple[float, ...], tuple[float, ...]]] = {}
        """Of each signal the least and the greatest samples of a stretch: start, span and columns."""

    def take(self, outs: Iterable[TickOutput]) -> None:
        """The next ticks."""
        columns = [(self._samples[name], name) for name in self.settings.signals]
        take = self._signals.take
        for out in outs:
            if self._next_tick is None or out.tick != self._next_tick:
                self._begin(out.tick)
            sample = take(out)
            for column, name in columns:
                value = sample[name]
                column.append(math.nan if value is None else value)
            self._next_tick = out.tick + 1
        self._forget()
        self._look_for_trigger()

    def change(self, settings: ScopeSettings) -> None:
        """Another time base or trigger. The signals must be the same ones."""
        if settings.signals != self.settings.signals:
            raise ValueError(f"a scope of {self.settings.signals} cannot show {settings.signals}")
        if settings == self.settings:
            return
        self.settings = settings
        self._shown = self._pending = None
        self._looked_at = max(self._first_tick, self._now - settings.span_ms)
        self._look_for_trigger()

    def holds(self, signals: tuple[str, ...], first: int, end: int) -> bool:
        """Whether it has sampled these signals in all ticks from the first to the end."""
        return set(signals) <= set(self.settings.signals) and self._first_tick <= first and end <= self._now

    def until(self, tick: int, settings: ScopeSettings) -> Scope:
        """One that has seen no tick from this one on. It takes none: it is for a picture of what was."""
        other = copy(self)
        other.settings = settings
        count = max(0, tick - self._first_tick)
        other._samples = {name: self._samples[name][:count] for name in settings.signals}
        other._known = {}
        other._next_tick = tick
        other._shown = other._pending = None
        other._looked_at = self._first_tick
        other._look_for_trigger()
        return other

    def picture(self, columns: int) -> ScopePicture:
        """What is to be drawn in so many columns of dots."""
        span, now = self.settings.span_ms, self._now
        if self._shown is not None and self._shown[1] < self._first_tick:
            self._shown = None  # older than what is kept
        start, trigger, state = now - span, None, TRIGGERED
        if self._shown is not None:
            start, trigger = self._shown
        if self._shown is None:
            state = FREE if self.settings.mode == AUTO else WAITING
            if self._pending is not None and state == WAITING:
                start, trigger = self._pending - round(BEFORE * span), self._pending
        elif self.settings.mode == SINGLE:
            state = CAUGHT
        elif self.settings.mode == AUTO and now - (start + span) > PATIENCE_TICKS + span:
            state, start, trigger = FREE, now - span, None
        traces = tuple(self._trace(name, start, columns) for name in self.settings.signals)
        return ScopePicture(self.settings, state, start, trigger, traces)

    @property
    def _now(self) -> int:
        return self._next_tick or 0

    def _begin(self, tick: int) -> None:
        """The run jumped, or begins: what was sampled before does not belong to it."""
        for column in self._samples.values():
            del column[:]
        self._known.clear()
        self._first_tick = self._looked_at = tick
        self._shown = self._pending = None

    def _forget(self) -> None:
        old = self._now - self._first_tick - KEPT_TICKS
        if old > KEPT_TICKS // 4:  # in pieces: moving all samples costs
            for column in self._samples.values():
                del column[:old]
            self._first_tick += old

    def _look_for_trigger(self) -> None:
        settings, now = self.settings, self._now
        after = settings.span_ms - round(BEFORE * settings.span_ms)
        while True:
            if self._pending is not None:
                if now < self._pending + after:
                    return
                self._shown = (self._pending - round(BEFORE * settings.span_ms), self._pending)
                self._looked_at = self._pending + after
                self._pending = None
            if settings.mode == SINGLE and self._shown is not None:
                return
            self._pending = self._crossing(self._looked_at, now)
            if self._pending is None:
                self._looked_at = now
                return

    def _crossing(self, since: int, now: int) -> int | None:
        """The first tick from `since` on in which the first signal has passed the level; it may have lain on it."""
        samples = self._samples[self.settings.signals[0]]
        level, sign = self.settings.level, 1.0 if self.settings.edge == RISING else -1.0
        first = max(since - self._first_tick, 1)
        for place in range(first, now - self._first_tick):
            if sign * (samples[place] - level) > 0.0 and sign * (samples[place - 1] - level) <= 0.0:
                return self._first_tick + place
        return None

    def _trace(self, name: str, start: int, columns: int) -> Trace:
        samples, span = self._samples[name], self.settings.span_ms
        offset, have = start - self._first_tick, len(self._samples[name])
        if columns and offset >= 0 and offset + span <= have:
            # All of it is there: nothing has to be asked of a column, and one that stands is not looked at again.
            stretch = (start, span, columns)
            known = self._known.get(name)
            if known is None or known[0] != stretch:
                whole = samples[offset : offset + span].tolist()
                parts = list(map(whole.__getitem__, _columns(span, columns)))
                known = self._known[name] = (stretch, tuple(map(min, parts)), tuple(map(max, parts)))
            return self._told(name, known[1], known[2])
        low, high = [], []
        first = offset
        for column in range(1, columns + 1):
            end = offset + column * span // columns
            last = end if end > first else first + 1
            part = samples[first:last] if first >= 0 else samples[: max(last, 0)]
            if not part or first >= have:
                low.append(math.nan)
                high.append(math.nan)
            else:
                low.append(min(part))
                high.append(max(part))
            first = end
        return self._told(name, low, high)

    def _told(self, name: str, low: Sequence[float], high: Sequence[float]) -> Trace:
        samples = self._samples[name]
        if samples and samples[0] != samples[0]:
            # A signal begins as no number until its first frame: that hides what stands beside it in the same column.
            low = [one if one == one else other for one, other in zip(low, high, strict=True)]
        return Trace(name, tuple(low), tuple(high), samples[-1] if samples else math.nan)


@lru_cache(maxsize=8)
def _columns(span: int, columns: int) -> tuple[slice, ...]:
    """The samples of each column: those that are new in it, at least one."""
    edges = [column * span // columns for column in range(columns + 1)]
    return tuple(slice(first, max(end, first + 1)) for first, end in pairwise(edges))
