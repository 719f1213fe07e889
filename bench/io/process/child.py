"""The real-time loop in a process of its own: forked here, it owns ports, loop and recording.

It stops and closes everything when its parent is gone. It is in a session of its own, so that Ctrl-C and Ctrl-Z
reach the parent alone.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from typing import NamedTuple, NoReturn

from bench.errors import BenchError
from bench.io.clock import TICK_NS, FreePacer, Metronome, now_ns, wait_ns
from bench.io.forked import fork, leave_the_terminal
from bench.io.link import BenchStopped, InlineLink, Taker
from bench.io.process.realtime import run_in_real_time
from bench.io.process.wire import End, Inputs, Notice, PortNote, Ready, State, Stop, Wire, wire_pair
from bench.io.punctual import REAL_TIME, be_punctual
from bench.io.rig import Rig
from bench.loop import Bench
from bench.messages import TickInput, TickOutput

OPERATOR_SILENCE_NS = 250_000_000
STATE_NS = 50_000_000
LOOK_TICKS = 5
MOST_OUTS = 250
"""Ticks that are kept for the parent: a quarter of a second, after that it misses some."""
_NOTHING = TickInput()


class Prepared(NamedTuple):
    """What the child makes of itself before its first tick."""

    bench: Bench
    rig: Rig | None
    takers: Sequence[Taker] = ()
    finish: Callable[[], object] = lambda: None
    """Called after the run; what it returns goes to the parent as `result`."""
    every_look: Callable[[], None] = lambda: None
    """Called every few ticks, for what need not be done in each."""


class Task(NamedTuple):
    """What a child is to do."""

    prepare: Callable[[], Prepared]
    """Called in the child."""
    inputs: Callable[[int], TickInput]
    ticks: int | None
    operator: bool
    """Whether the parent makes the inputs, instead of the child by `inputs`."""
    watched: bool
    """Whether the parent wants to see the ticks."""
    with_priority: bool


def start(task: Task) -> tuple[int, Wire]:
    """Fork the child; its process id, and the parent's end of the wire to it."""
    mine, theirs = wire_pair()
    child = fork()
    if child == 0:
        mine.close()
        _live(task, theirs)
    theirs.close()
    return child, mine


def _live(task: Task, wire: Wire) -> NoReturn:
    """All that the child does."""
    try:
        loop = _Loop(task, wire)
        leave_the_terminal(with_its_own_share=True)
        error: BenchError | None = None
        try:
            loop.run()
        except BenchError as caught:
            error = caught
        except Exception as caught:
            error = BenchStopped.by(caught, loop.tick)
        loop.end(error)
    finally:
        os._exit(0)


class _Loop:
    """Runs the bench at absolute deadlines, and listens and tells between ticks."""

    def __init__(self, task: Task, wire: Wire) -> None:
        self._task, self._wire = task, wire
        self._inputs = self._operators_inputs if task.operator else task.inputs
        self._queue: dict[int, TickInput] = {}
        self._rig: Rig | None = None
        self._link: InlineLink | None = None
        self._metronome = Metronome()
        self._scheduling = ""
        self._stop = False
        self._beat_ns = self._state_ns = now_ns()
        self._look_tick = 0
        self._every_look: Callable[[], None] = lambda: None
        self._result: object = None
        self._outs: deque[TickOutput] = deque(maxlen=MOST_OUTS)
        self.add = self._outs.append
        """As a taker: one more tick for the parent."""

    @property
    def tick(self) -> int:
        """How many ticks have run."""
        return self._link.now_tick if self._link is not None else 0

    def run(self) -> None:
        """Prepare, wait for the ports, run. Ports and recording are closed whatever happens."""
        made = self._task.prepare()
        rig = self._rig = made.rig
        self._every_look = made.every_look
        try:
            inputs = rig.gated(self._inputs) if rig is not None else self._inputs
            takers = [*made.takers, self] if self._task.watched else made.takers
            # The metronome grants each tick; nobody asks a pacer.
            link = self._link = InlineLink(made.bench, inputs, FreePacer(0), takers=takers, ticks=self._task.ticks)
            ports = rig.ports if rig is not None else []
            self._wire.tell(Ready(tuple(PortNote(port.name, port.where, port.note) for port in ports)))
            try:
                if self._wait_for_ports():
                    self._scheduling = be_punctual(self._task.with_priority)
                    self._metronome.spins_on = self._scheduling == REAL_TIME
                    run_in_real_time(link, rig, self._metronome, self._between)
            finally:
                if rig is not None:
                    self._send_notices(rig)
                    rig.close()
                link.close()
        finally:
            self._result = made.finish()

    def end(self, error: BenchError | None) -> None:
        """The last word, which has to arrive."""
        end = End(self.tick, error, self._result, self._metronome.lateness, self._scheduling)
        self._wire.tell_at_last(end)

    def _wait_for_ports(self) -> bool:
        """Before the first tick nothing is lost yet: wait until all are there. False where the parent gives up."""
        rig, told = self._rig, ""
        while rig is not None and not rig.find():
            waiting = "; ".join(f"{port.name}: {port.lost}" for port in rig.ports if port.lost)
            if waiting != told:
                told = waiting
                self._wire.tell(Notice(0, f"waiting: {waiting}"))
            self._hear()
            if self._stop:
                return False
            wait_ns(5 * TICK_NS)
        return True

    def _between(self) -> bool:
        tick = self.tick
        if tick < self._look_tick:
            return False
        self._look_tick = tick + LOOK_TICKS
        self._hear()
        self._every_look()
        at_ns = now_ns()
        if self._rig is not None:
            self._rig.watch_operator(tick, at_ns - self._beat_ns > OPERATOR_SILENCE_NS)
            self._send_notices(self._rig)
        if at_ns - self._state_ns >= STATE_NS:
            self._state_ns = at_ns
            self._send_state()
        return self._stop

    def _send_notices(self, rig: Rig) -> None:
        notices, rig.notices = rig.notices, []
        for tick, text in notices:
            self._wire.tell(Notice(tick, text))

    def _send_state(self) -> None:
        link, metronome = self._link, self._metronome
        assert link is not None
        outs: tuple[TickOutput, ...] = ()
        snapshot = None
        if self._task.watched:
            outs, snapshot = tuple(self._outs), link.latest()
            self._outs.clear()
        missing = self._rig.missing if self._rig is not None else ()
        late_us, metronome.window_us = metronome.window_us, 0.0
        self._wire.tell(State(link.now_tick, now_ns(), snapshot, outs, late_us, metronome.slipped_ticks, missing))

    def _hear(self) -> None:
        for word in self._wire.heard():
            if isinstance(word, Stop):
                self._stop = True
                return
            self._beat_ns = now_ns()
            if isinstance(word, Inputs):
                self._take_inputs(word)
        if self._wire.is_cut:  # the parent is gone
            self._stop = True

    def _take_inputs(self, told: Inputs) -> None:
        """What comes too late is a frame that was lost, but what it told the core still holds."""
        tick, queue = self.tick, self._queue
        for at, given in enumerate(told.inputs, told.first_tick):
            if at >= tick:
                queue[at] = given
            elif given.core_twist is not None:
                queue[tick] = queue.get(tick, _NOTHING)._replace(core_twist=given.core_twist)

    def _operators_inputs(self, tick: int) -> TickInput:
        return self._queue.pop(tick, _NOTHING)
