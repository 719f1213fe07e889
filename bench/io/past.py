"""What wires and signals were before an earlier instant of a run: from its ticks, built again where none are kept.

    wires     the figures that were kept once a second, and every tick since: what was shown then, to the last bit
    scope     every tick of the picture, and of the time before it in which a trigger may lie

The ticks are built a part at a time, the newest first, so that whoever asks 20 times a second goes on meanwhile; until
all are there the answer says how far it is. They stay as long as the past is looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from bench.config import Robot
from bench.io.look import Look, Seen
from bench.io.scope import PATIENCE_TICKS, Scope, ScopePicture, ScopeSettings
from bench.io.wires.counts import KEPT_EVERY_TICKS, MARK_TICKS, MARKS
from bench.io.wires.wiretap import Wiretap
from bench.messages import TickOutput

PART_TICKS = 250
PARTS_AT_ONCE = 2
"""So many are built in one look: some 15 ms where a tick takes 25 us, 40 where their stretch is verified first."""
MOST_PARTS = 96
LEAD_TICKS = 400
"""So long before the first tick that counts decoders are fed, and signals sampled: both begin without a past."""
MOST_BEFORE_TICKS = 3000
"""So far before the left edge of a scope's picture a trigger is looked for."""
OLDEST_KEPT_TICKS = 6 * KEPT_EVERY_TICKS
"""Figures that were kept longer ago are of no use: too much would have to be built from there."""


class Source(Protocol):
    """The ticks of a run."""

    @property
    def kept_from(self) -> int:
        """From this tick on they are there; those before have to be built."""
        ...

    def between(self, first: int, end: int) -> Sequence[TickOutput]:
        """Those with first <= tick < end; without those that nobody can build again."""
        ...


class Past:
    """Looks back in one run. `wiretap` is the run's own, which has kept its figures."""

    def __init__(self, robot: Robot, state_columns: Sequence[str], source: Source, wiretap: Wiretap) -> None:
        self._robot, self._columns = robot, state_columns
        self._source, self._kept = source, wiretap
        self._parts: dict[int, Sequence[TickOutput]] = {}
        self._wiretap: tuple[int, str, Wiretap] | None = None
        self._sampled: Scope | None = None

    def look(self, wanted: Look, before_tick: int) -> Seen:
        """What is wanted, as it was before this tick. Raises ValueError for a signal that the run does not have."""
        first, filter, scope = before_tick, wanted.filter, wanted.scope
        if wanted.wires:
            first = min(first, self._wires_from(before_tick) - LEAD_TICKS)
        if scope is not None:
            first = min(first, _scope_from(before_tick, scope.span_ms) - LEAD_TICKS)
        done = self._build(max(0, first), before_tick)
        if done < 1.0:
            return Seen(building=done)
        return Seen(
            self.wiretap(before_tick, filter).table(filter, wanted.log) if wanted.wires else None,
            self._picture(before_tick, scope, wanted.columns) if scope is not None else None,
        )

    def wiretap(self, before_tick: int, filter: str = "") -> Wiretap:
        """The figures of the wires as they were before a tick; it may go on from there."""
        last = self._wiretap
        if last is not None and last[1] == filter and 0 <= before_tick - last[0] <= PART_TICKS:
            tick, wiretap = last[0], last[2]
        else:
            tick = max(0, self._wires_from(before_tick))
            wiretap = self._kept.again(tick, self._ticks(max(0, tick - LEAD_TICKS), tick))
        wiretap.follow(self._ticks(tick, before_tick), filter)
        self._wiretap = before_tick, filter, wiretap
        return wiretap

    # --- ticks -----------------------------------------------------------------------------------------------------

    def _build(self, first: int, end: int) -> float:
        """Build some of what is missing; the share that is there."""
        numbers = range(first // PART_TICKS, -(-end // PART_TICKS))
        missing = [number for number in reversed(numbers) if not self._has(number, end)]
        at_once = [number for number in missing if number * PART_TICKS >= self._source.kept_from]
        now = missing[: len(at_once) + PARTS_AT_ONCE]
        for number in now:
            self._parts.pop(number, None)
            start = number * PART_TICKS
            self._parts[number] = self._source.between(start, start + PART_TICKS)
        while len(self._parts) > max(MOST_PARTS, len(numbers)):
            self._parts.pop(next(iter(self._parts)))
        return 1.0 - (len(missing) - len(now)) / max(1, len(numbers))

    def _has(self, number: int, end: int) -> bool:
        part = self._parts.get(number)
        return part is not None and (not part or part[-1].tick + 1 >= min(end, (number + 1) * PART_TICKS))

    def _ticks(self, first: int, end: int) -> list[TickOutput]:
        """Ticks in order; what is not built yet is built."""
        while self._build(first, end) < 1.0:
            pass
        found: list[TickOutput] = []
        for number in range(first // PART_TICKS, -(-end // PART_TICKS)):
            part = self._parts[number]
            if part and first <= part[0].tick and part[-1].tick < end:
                found += part
            else:
                found += [out for out in part if first <= out.tick < end]
        return found

    # --- wires and scope -------------------------------------------------------------------------------------------

    def _wires_from(self, tick: int) -> int:
        """From where on ticks are needed: all of the last second, and those since the figures were kept."""
        wanted = tick - tick % MARK_TICKS - MARKS * MARK_TICKS
        kept = self._kept.kept_before(wanted)
        return kept if wanted - kept <= OLDEST_KEPT_TICKS else wanted

    def _picture(self, tick: int, settings: ScopeSettings, columns: int) -> ScopePicture:
        """Samples are taken once for a stretch and cut where the picture is to end."""
        first, sampled = max(0, _scope_from(tick, settings.span_ms)), self._sampled
        if sampled is None or not sampled.holds(settings.signals, first, tick):
            begin = max(0, first - LEAD_TICKS)
            sampled = self._sampled = Scope(self._robot, self._columns, settings)
            sampled.take(self._ticks(begin, tick))
        return sampled.until(tick, settings).picture(columns)


def _scope_from(tick: int, span_ms: int) -> int:
    return tick - span_ms - min(span_ms, MOST_BEFORE_TICKS) - PATIENCE_TICKS
