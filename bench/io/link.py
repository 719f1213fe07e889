"""How a screen follows a bench. InlineLink runs the ticks that are due inside the caller's own timer.

What a screen needs of a link: `advance` from its timer, `latest` and `wires` to draw, `pause`, `run`, `close`. A bench
on real ports lives in a process of its own behind the same names (`process`); the screen sees no difference.

A link that has a history can look back: `see` shows another instant of the run, `fork` goes on from it.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Protocol, runtime_checkable

from bench.check.faulty import FaultyWorld, Touch
from bench.errors import EXIT_FAILED, BenchError
from bench.io.clock import Pacer
from bench.io.follower import Followed, Follower, Wires
from bench.io.history import Event, History, LostInstant, Mark, Subject, join, mark_of
from bench.io.look import Look, Seen
from bench.io.tap import Tap
from bench.loop import Bench
from bench.messages import Snapshot, TickInput, TickOutput

__all__ = ["BenchStopped", "InlineLink", "LostInstant", "Taker", "Wires"]


class BenchStopped(BenchError):
    """A stage of the bench raised. The run ends there; its recording is closed and holds every tick before."""

    exit_status = EXIT_FAILED

    @classmethod
    def by(cls, error: Exception, tick: int) -> BenchStopped:
        """What stopped it, and where: the last line of ours or of whoever was called."""
        where = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{where.filename.rpartition('/')[2]}:{where.lineno}"
        return cls(f"stopped at tick {tick}: {type(error).__name__} in {place}: {error}")


class Taker(Protocol):
    """Whoever wants every tick: a recorder, a comparison, a summary. One that has a `close` is told of the end."""

    def add(self, out: TickOutput) -> None:
        """Take one tick."""
        ...


@runtime_checkable
class _Closing(Protocol):
    def close(self) -> None: ...


class InlineLink(Followed):
    """A bench in the caller's own process: `advance` runs what the pacer grants, never more than its burst.

    `inputs` gives what enters each tick, in order, each once. `ticks` ends the run (None: endless). Every output goes
    to the takers in their order. `remembers` keeps the run so far, with `shared` as in `History`.
    """

    lead_ticks = 0
    """What an operator does now takes effect in the next tick."""
    missing: tuple[str, ...] = ()
    """Ports that are lost: there are none here."""

    def __init__(
        self,
        bench: Bench,
        inputs: Callable[[int], TickInput],
        pacer: Pacer,
        *,
        takers: Sequence[Taker] = (),
        ticks: int | None = None,
        remembers: bool = False,
        shared: Sequence[object] = (),
    ) -> None:
        self.bench = bench
        self.pacer = pacer
        self.ticks = ticks
        self.paused = False
        self.inputs = inputs
        self.takers: list[Taker] = list(takers)
        self.witness: Callable[[Touch], object] | None = None
        """Hears of each touch of a fault, before any screen asks for them."""
        self._closed = False
        self._snapshot = bench.snapshot()
        self._seen = Follower(bench.state_columns, bench.robot)
        self._tap = Tap(bench.robot, bench.state_columns, self._rebuilt)
        self._tell_tap = self._tap.add
        self.history = History(Subject(bench, self._seen), shared) if remembers else None
        self._newest: Subject | None = None  # where the run is while another instant is shown

    @property
    def now_tick(self) -> int:
        """How many ticks have run before the instant that is shown."""
        return self.bench.now_tick

    @property
    def newest_tick(self) -> int:
        """How many ticks have run."""
        return (self._newest or self).bench.now_tick

    @property
    def looks_back(self) -> bool:
        """Whether an earlier instant is shown than the newest."""
        return self._newest is not None

    @property
    def ended(self) -> bool:
        """Whether the run has come to its last tick."""
        return self.ticks is not None and self.newest_tick >= self.ticks

    def latest(self) -> Snapshot:
        """The bench as it is after the last tick that is shown."""
        if self._snapshot.tick != self.bench.now_tick:
            self._snapshot = self.bench.snapshot()
        return self._snapshot

    def look(self, wanted: Look) -> Seen:
        """What was sampled of wires and signals before the instant that is shown."""
        return self._tap.look(wanted, self.bench.now_tick)

    def between(self, first: int, end: int) -> list[TickOutput]:
        """The ticks first <= tick < end of this run as they ran; without those that are no longer held."""
        return self._tap.between(first, end)

    def pause(self, paused: bool) -> None:
        """Stand still, or go on as if no time had passed, at the newest instant."""
        self.paused = paused
        if not paused:
            self.see(self.newest_tick)
        self.pacer.restart()

    def due(self) -> int:
        """How many ticks may run now."""
        return 0 if self.paused or self.ended else self.pacer.due(self.bench.now_tick)

    def advance(self) -> int:
        """Run what is due; how many ticks that was. Raises BenchStopped, or what a taker raised, with all closed."""
        return self.run(self.due())

    def run(self, ticks: int) -> int:
        """Run so many ticks, due or not, but none after the end; how many that was. Raises like `advance`."""
        if ticks:
            self.see(self.newest_tick)
        if self.ticks is not None:
            ticks = min(ticks, self.ticks - self.bench.now_tick)
        try:
            for _ in range(ticks):
                self._run_one()
        except BaseException as error:
            self.close()
            if isinstance(error, BenchError) or not isinstance(error, Exception):
                raise
            raise BenchStopped.by(error, self.bench.now_tick) from error
        return ticks

    def see(self, tick: int) -> None:
        """Show the bench as it was before this tick ran; the nearest there is. The run itself stays where it is.

        Raises LostInstant, a sentence, where the link does not remember that, and then shows what it did.
        """
        newest = self._newest or Subject(self.bench, self._seen)
        tick = max(0, min(tick, newest.bench.now_tick))
        if tick == newest.bench.now_tick:
            self._show(newest)
            self._newest = None
        elif self.history is None:
            raise LostInstant("this run cannot be taken back")
        elif self._newest is not None and self.history.reaches(self.bench, tick):
            self.history.go_on(Subject(self.bench, self._seen), tick)
        else:
            shown = self.history.at(tick, newest.bench.now_tick, mark_of(newest.bench))
            self._newest = newest
            self._show(shown)

    def fork(self, inputs: Callable[[int], TickInput]) -> None:
        """Make the instant that is shown the newest: what came after it is no more, and `inputs` goes on from here.

        The link stands still then. Whoever took the ticks has heard of another run: give it new takers.
        """
        if self.history is not None:
            self.history = self.history.branch(self.bench.now_tick)
        self._newest = None
        self._tap.cut(self.bench.now_tick)
        self.ticks = None
        self.inputs = inputs
        self.pause(True)

    def adopt(self, subject: Subject) -> None:
        """Go on with another bench, which has run through the same ticks."""
        if subject.bench.now_tick != self.newest_tick:
            raise ValueError(f"a bench at tick {subject.bench.now_tick} cannot go on from tick {self.newest_tick}")
        if self.history is not None:
            self.history.join_again(subject.bench)
        if self._newest is None:
            self._show(subject)
        else:
            self._newest = subject

    def join(self, event: Event) -> None:
        """Let a fault, or a core, join the run. Raises ValueError for a wheel or wire that is not there."""
        self.see(self.newest_tick)
        join(self.bench, event)
        if self.history is not None:
            self.history.joined(self.bench.now_tick, event)

    def take_notices(self) -> list[str]:
        """What the loop has to say to the person: nothing, in one's own process."""
        return []

    def take_touches(self) -> list[Touch]:
        """What faults have touched since the last call."""
        return (self._newest or Subject(self.bench, self._seen)).take_touches()

    def mark(self) -> Mark:
        """What the newest instant is like, to the last bit."""
        return mark_of((self._newest or self).bench)

    def close(self) -> None:
        """End the recording, and whatever else was told every tick. A second call does nothing."""
        if not self._closed:
            self._closed = True
            for taker in self.takers:
                if isinstance(taker, _Closing):
                    taker.close()

    def _rebuilt(self, first: int, end: int) -> list[TickOutput]:
        if self.history is None:
            return []
        with suppress(LostInstant):
            newest = self.newest_tick
            return self.history.ticks(max(first, self.history.first), min(end, newest), newest, self.mark())
        return []

    def _show(self, subject: Subject) -> None:
        self.bench, self._seen = subject
        self._snapshot = self.bench.snapshot()

    def _run_one(self) -> None:
        bench, history = self.bench, self.history
        given = self.inputs(bench.now_tick)
        if history is not None:
            history.note(bench.now_tick, given)
        out = bench.tick(given)
        for taker in self.takers:
            taker.add(out)
        self._seen.add(out)
        self._tell_tap(out)
        if isinstance(bench.world, FaultyWorld):
            bench.world.injector.observe(out)
            if self.witness is not None:
                for touch in bench.world.injector.touches_of(out.tick):
                    self.witness(touch)
        if history is not None and bench.now_tick >= history.due_tick:
            history.keep(Subject(bench, self._seen))
