"""The parent's link to a real-time loop in a process of its own, behind the names of InlineLink.

An operator's inputs are made here at 20 Hz for the ticks to come (`pace`): where the parent falls silent no RC frame
leaves any more, as if switched off.
"""

from __future__ import annotations

import os
from collections.abc import Callable

from bench.check.faulty import Touch
from bench.errors import BenchError, SurroundingsError
from bench.io.clock import TICK_NS, now_ns, wait_ns
from bench.io.follower import Followed, Follower
from bench.io.forked import end_at_once
from bench.io.history import History
from bench.io.lateness import Lateness
from bench.io.link import LostInstant, Taker
from bench.io.look import Look, Seen
from bench.io.process.child import Prepared, Task, start
from bench.io.process.pace import ChildsPacer, Lead
from bench.io.process.wire import Beat, End, Inputs, Notice, PortNote, Ready, State, Stop, Word
from bench.io.tap import Tap
from bench.loop import Bench
from bench.messages import Snapshot, TickInput

END_S = 5.0


class ProcessLink(Followed):
    """Starts the child; `prepare` runs in it. Raises what opening the ports raised, when all is closed again.

    `bench` is the parent's own copy and stands still: what moves is in `latest`, `wires` and `trail`. With `operator`
    the inputs are made here, by the parent; without it the child makes its own from the same callable. `rescue` is
    called when the child has died without a word: it could not stop what it drove.
    """

    looks_back = False
    history: History | None = None

    def __init__(
        self,
        bench: Bench,
        inputs: Callable[[int], TickInput],
        prepare: Callable[[], Prepared],
        *,
        ticks: int | None = None,
        operator: bool = False,
        watched: bool = True,
        with_priority: bool = True,
        rescue: Callable[[], None] = lambda: None,
    ) -> None:
        self.bench = bench
        self.inputs = inputs
        self.ticks = ticks
        self.paused = False
        self.pacer = ChildsPacer()
        self.ports: tuple[PortNote, ...] = ()
        self.notices: list[Notice] = []
        self.lateness: dict[str, float] = {}
        """How late the ticks were, known at the end; `counted` is the whole count."""
        self.counted: Lateness | None = None
        self.scheduling = ""
        """What priority the loop had, known at the end."""
        self.missing: tuple[str, ...] = ()
        self.result: object = None
        self.takers: list[Taker] = []
        self._lead = Lead() if operator else None
        self._rescue = rescue
        self._snapshot: Snapshot | None = None
        self._seen = Follower(bench.state_columns, bench.robot)
        self._tap = Tap(bench.robot, bench.state_columns)
        self._error: BenchError | None = None
        self._is_ready = self._over = False
        self._child, self._wire = start(Task(prepare, inputs, ticks, operator, watched, with_priority))
        self._await_ports()

    # --- the names of InlineLink -----------------------------------------------------------------------------------

    @property
    def now_tick(self) -> int:
        """How many ticks have run; of an operator's, up to which the inputs are made: keys act from there on."""
        return self._lead.made_tick if self._lead is not None else self.pacer.tick

    @property
    def lead_ticks(self) -> int:
        """How much later what an operator does now takes effect."""
        return self._lead.ticks if self._lead is not None else 0

    @property
    def newest_tick(self) -> int:
        """The same as `now_tick`: nobody looks back."""
        return self.now_tick

    @property
    def has_begun(self) -> bool:
        """Whether all ports were there and ticks run."""
        return self.pacer.has_begun or self._over

    @property
    def ended(self) -> bool:
        """Whether the run is over."""
        return self._over

    def latest(self) -> Snapshot:
        """The bench as the child last told."""
        return self._snapshot or self.bench.snapshot()

    def look(self, wanted: Look) -> Seen:
        """What was sampled of wires and signals until the last tick that was told."""
        return self._tap.look(wanted)

    def due(self) -> int:
        """How many ticks the operator should make inputs for now; takes what the child has told."""
        self.poll()
        if self._lead is None or self.paused or not self.pacer.has_begun:
            return 0
        return self._lead.due(self.pacer.now_tick())

    def advance(self) -> int:
        """Take what the child tells, beat, make inputs; how many ticks that was. Raises what ended the run."""
        return self.run(self.due())

    def run(self, ticks: int) -> int:
        """Make the operator's inputs for so many ticks; never further ahead than the child can use."""
        self.poll()
        lead = self._lead
        if self._over or lead is None or self.paused:
            return 0
        while not lead.has_room(ticks, self.pacer.now_tick()) and not self._over:
            wait_ns(TICK_NS)
            self.poll()
        if ticks > 0 and not self._over:
            first = lead.made_tick
            lead.made_tick += ticks
            self._wire.tell(Inputs(first, [self.inputs(tick) for tick in range(first, first + ticks)]))
        return ticks

    def pause(self, paused: bool) -> None:
        """Stop asking for anything: what is real does not stand still."""
        self.paused = paused

    def see(self, tick: int) -> None:
        """Show the newest instant; real time cannot be taken back. Raises LostInstant for another."""
        if tick < self.newest_tick:
            raise LostInstant(
                "a run on real ports cannot be taken back; its recording can: wheelbench drive --replay DIR"
            )

    def fork(self, inputs: Callable[[int], TickInput]) -> None:
        """Raises LostInstant: only simulated time forks."""
        self.see(-1)

    def join(self, what: object) -> None:
        """Raises ValueError: what is real fails by itself."""
        raise ValueError("faults join simulated runs; give a scenario with faults to `wheelbench replay --role`")

    def take_notices(self) -> list[str]:
        """What the loop has to say to the person, since the last call."""
        notices, self.notices = self.notices, []
        return [notice.text for notice in notices]

    def take_touches(self) -> list[Touch]:
        """They are in the child's recording."""
        return []

    def stop(self) -> None:
        """Ask the child to come to an end; `poll` tells when it has."""
        self._wire.tell(Stop())

    def close(self) -> None:
        """Stop, and wait for the child to close ports and recording. Raises nothing; a second call does nothing."""
        if self._child:
            deadline_ns = now_ns() + int(END_S * 1e9)
            while not self._over and now_ns() < deadline_ns:
                self.stop()
                self._receive()
                wait_ns(TICK_NS)
            self._reap(kill=not self._over)
            self.pacer.is_theirs = False

    # --- beyond them -----------------------------------------------------------------------------------------------

    def poll(self) -> None:
        """Beat, and take what the child has told. Raises what ended its run."""
        if self._child:
            self._wire.tell(Beat())
            self._receive()
        if self._over and self._child:
            self._reap()
        if self._error is not None:
            error, self._error = self._error, None
            raise error

    def wait(self, asked: Callable[[], bool], told: Callable[[int, str], None]) -> None:
        """For a run without a screen: beat until it has ended. `told` gets each notice. Raises what ended the run."""
        stopping = False
        while not self._over:
            self._wire.wait(0.05)
            self.poll()
            notices, self.notices = self.notices, []
            for tick, text in notices:
                told(tick, text)
            stopping = stopping or asked()
            if stopping:
                self.stop()

    def _await_ports(self) -> None:
        while not self._is_ready and not self._over:
            self._wire.wait(0.1)
            self._receive()
        if not self._is_ready:
            self._reap()
            if self._error is not None:
                raise self._error

    def _receive(self) -> None:
        if self._over:
            return
        for word in self._wire.heard():
            self._take(word)
            if self._over:
                return
        if self._wire.is_cut:
            self._over = True
            if self._error is None:
                self._error = SurroundingsError(
                    "the process of the real-time loop ended without a word; what it recorded stays"
                )

    def _take(self, word: Word) -> None:
        match word:
            case Ready():
                self.ports, self._is_ready = word.ports, True
            case Notice():
                self.notices.append(word)
            case State():
                self._take_state(word)
            case End():
                self.pacer.tick, self._error, self.result, self.counted, self.scheduling = word
                self.lateness = word.lateness.facts()
                self._over = True

    def _take_state(self, state: State) -> None:
        self.pacer.take(state)
        self._snapshot = state.snapshot or self._snapshot
        self.missing = state.missing
        for out in state.outs:
            self._seen.add(out)
            self._tap.add(out)

    def _reap(self, kill: bool = False) -> None:
        child, self._child = self._child, 0
        if child:
            if kill:
                end_at_once(child)
            os.waitpid(child, 0)
            self._wire.close()
            if kill or self._wire.is_cut:  # it never said that it had come to an end
                self._rescue()
