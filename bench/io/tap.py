"""What a screen sees of the wires and signals, sampled beside the loop: the ticks go in, plain values come out.

A tick costs no more than a place in a queue. The work is done when somebody looks, 20 times a second, and only for
what is looked at. Where the loop has a process of its own, this stays with the loop: a `Look` goes there, a `Seen`
comes back.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from itertools import islice

from bench.config import Robot
from bench.io.look import Look, Seen
from bench.io.past import Past
from bench.io.scope import Scope
from bench.io.wires.wiretap import Wiretap
from bench.messages import TickOutput

KEPT_TICKS = 4000
"""So many ticks are kept whole: a signal that is chosen now has a past. Some 3 MB."""


class Tap:
    """Takes every tick of a run; `look` answers for the last one.

    `rebuilt` gives (first, end) ticks that are no longer kept; empty where nobody can.
    """

    def __init__(
        self,
        robot: Robot,
        state_columns: Sequence[str],
        rebuilt: Callable[[int, int], Sequence[TickOutput]] = lambda *_: (),
    ) -> None:
        self._rebuilt = rebuilt
        self._robot, self._columns = robot, tuple(state_columns)
        self._ticks: deque[TickOutput] = deque(maxlen=KEPT_TICKS)
        self.add = self._ticks.append
        """One more tick."""
        self._wiretap = Wiretap(robot)
        self._scope: Scope | None = None
        self._seen_tick = -1
        self._past: Past | None = None

    def look(self, wanted: Look, before_tick: int | None = None) -> Seen:
        """Catch up with the run, then say what is wanted. Raises ValueError for a signal that the run does not have.

        `before_tick` is an earlier instant, for which ticks may have to be built again: see `Seen.building`.
        """
        fresh = self._fresh()
        self._wiretap.take(fresh)
        if before_tick is not None and self._ticks and before_tick <= self._ticks[-1].tick:
            if self._scope is not None:
                self._scope.take(fresh)
            return self._look_back(wanted, before_tick)
        self._past = None
        scope = self._scope
        if scope is not None:
            scope.take(fresh)
        if wanted.scope is not None and (scope is None or scope.settings.signals != wanted.scope.signals):
            scope = self._scope = Scope(self._robot, self._columns, wanted.scope)
            scope.take(self._ticks)
        if wanted.scope is not None and scope is not None:
            scope.change(wanted.scope)
        return Seen(
            self._wiretap.table(wanted.filter, wanted.log) if wanted.wires else None,
            scope.picture(wanted.columns) if wanted.scope is not None and scope is not None else None,
        )

    def cut(self, tick: int) -> None:
        """Forget everything from this tick on: the run goes on from there another way."""
        self._wiretap.take(self._fresh())
        wiretap = Past(self._robot, self._columns, self, self._wiretap).wiretap(tick)
        while self._ticks and self._ticks[-1].tick >= tick:
            self._ticks.pop()
        self._wiretap, self._scope, self._past = wiretap, None, None
        self._seen_tick = tick - 1

    @property
    def kept_from(self) -> int:
        """The oldest tick that is kept."""
        return self._ticks[0].tick if self._ticks else 0

    def between(self, first: int, end: int) -> list[TickOutput]:
        """The ticks first <= tick < end, from those that are kept, or built again."""
        ticks = self._ticks
        oldest = ticks[0].tick if ticks else end
        found = list(self._rebuilt(first, min(end, oldest))) if first < oldest else []
        start = max(0, first - oldest)
        return found + list(islice(ticks, start, max(start, end - oldest)))

    def _look_back(self, wanted: Look, before_tick: int) -> Seen:
        if self._past is None:
            self._past = Past(self._robot, self._columns, self, self._wiretap)
        return self._past.look(wanted, before_tick)

    def _fresh(self) -> list[TickOutput]:
        """The ticks since the last look, as far as they are still kept."""
        ticks = self._ticks
        if not ticks:
            return []
        count = min(len(ticks), ticks[-1].tick - self._seen_tick)
        self._seen_tick = ticks[-1].tick
        return list(islice(reversed(ticks), count))[::-1] if count > 0 else []
