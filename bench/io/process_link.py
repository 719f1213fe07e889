"""A bench in a process of its own, in real time, behind the names of InlineLink.

    parent                                        child
    inputs of the operator, a little ahead  --->  one for each tick; none there: silence
    a beat, at every `advance`              --->  none for a quarter of a second: silence
    ticks, snapshot, lateness, notices      <---  twenty times a second; dropped while the parent does not read
    error or result                         <---  at the end

The child owns ports, loop and recording. It stops and closes everything when the parent is gone; it is in a process
group of its own, so that Ctrl-C and Ctrl-Z reach the parent alone. An operator's inputs are made by the parent at 20 Hz
for the ticks to come (`LEAD_TICKS`): where it falls silent no RC frame leaves any more, as if switched off.
"""

from __future__ import annotations

import os
import pickle
import select
import signal
import socket
import traceback
import warnings
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from bench.check.faulty import Touch
from bench.errors import BenchError, SurroundingsError
from bench.io.clock import REAL_TIME, TICK_NS, Lateness, Metronome, WallPacer, be_punctual, now_ns, wait_ns
from bench.io.follower import Follower, Wires
from bench.io.history import History
from bench.io.link import BenchStopped, InlineLink, LostInstant, Taker
from bench.io.realtime import run_in_real_time
from bench.io.roles import Rig
from bench.io.tap import Look, Seen, Tap
from bench.loop import Bench
from bench.messages import Snapshot, TickInput, TickOutput

OPERATOR_SILENCE_NS = 250_000_000
LEAD_TICKS, MOST_LEAD_TICKS = 80, 250
"""How far ahead an operator's inputs are made: a frame of 20 Hz and a hiccup; more where frames take longer."""
STATE_NS = 50_000_000
LOOK_TICKS = 5
MOST_OUTS = 250
"""Ticks that are kept for the parent: a quarter of a second, after that it misses some."""
MOST_BYTES = 1 << 18
END_S = 5.0


class Prepared(NamedTuple):
    """What the child makes of itself before its first tick."""

    bench: Bench
    rig: Rig | None
    takers: Sequence[Taker] = ()
    finish: Callable[[], object] = lambda: None
    """Called after the run; what it returns goes to the parent as `result`."""
    every_look: Callable[[], None] = lambda: None
    """Called every few ticks, for what need not be done in each."""


class State(NamedTuple):
    """What the child tells while it runs."""

    tick: int
    at_ns: int
    """When that was; the clock is the same in both processes."""
    snapshot: Snapshot | None
    outs: tuple[TickOutput, ...]
    """The ticks since the last one, as far as somebody watches them: what is made of them is made by the parent."""
    late_us: float
    """The most since the last one."""
    slipped_ticks: int
    missing: tuple[str, ...]


class PortNote(NamedTuple):
    """A port, as the person should know it."""

    name: str
    where: str
    note: str


class ProcessLink:
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
        self._rescue = rescue
        self.bench = bench
        self.inputs = inputs
        self.ticks = ticks
        self.paused = False
        self.pacer = ChildsPacer()
        self.ports: tuple[PortNote, ...] = ()
        self.notices: list[tuple[int, str]] = []
        self.lateness: dict[str, float] = {}
        """How late the ticks were, known at the end; `counted` is the whole count."""
        self.counted: Lateness | None = None
        self.scheduling = ""
        """What priority the loop had, known at the end."""
        self.missing: tuple[str, ...] = ()
        self.result: object = None
        self.takers: list[Taker] = []
        self._operator = operator
        self._snapshot: Snapshot | None = None
        self._seen = Follower(bench.state_columns, bench.robot)
        self._tap = Tap(bench.robot, bench.state_columns)
        self._tick, self._tick_ns = 0, 0
        self._made_tick = 0
        self._lead_ticks, self._due_ns = LEAD_TICKS, 0
        self._error: BenchError | None = None
        self._over = False
        mine, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        for end in (mine, theirs):
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, MOST_BYTES)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # forking beside threads: the child uses none of theirs
            self._child = os.fork()
        if self._child == 0:
            mine.close()
            _child(prepare, _Live(theirs, inputs, ticks, operator, watched, with_priority))
        theirs.close()
        self._socket = mine
        self._await_ports()

    # --- the names of InlineLink -----------------------------------------------------------------------------------

    @property
    def now_tick(self) -> int:
        """How many ticks have run; of an operator's, up to which the inputs are made: keys act from there on."""
        return self._made_tick if self._operator else self._tick

    @property
    def lead_ticks(self) -> int:
        """How much later what an operator does now takes effect."""
        return self._lead_ticks if self._operator else 0

    @property
    def newest_tick(self) -> int:
        """The same."""
        return self.now_tick

    @property
    def has_begun(self) -> bool:
        """Whether all ports were there and ticks run."""
        return self._tick_ns > 0 or self._over

    @property
    def ended(self) -> bool:
        """Whether the run is over."""
        return self._over

    def latest(self) -> Snapshot:
        """The bench as the child last told."""
        return self._snapshot or self.bench.snapshot()

    @property
    def wires(self) -> Wires:
        """The last frames, as the child last told."""
        return self._seen.wires(self.latest().rc_frame)

    @property
    def trail(self) -> Sequence[tuple[float, float]]:
        """(x_m, y_m) of where the robot has been."""
        return self._seen.trail

    @property
    def slips(self) -> Sequence[tuple[float, float]]:
        """(x_m, y_m) of where a wheel slid over the floor."""
        return self._seen.slips

    def look(self, wanted: Look) -> Seen:
        """What was sampled of wires and signals until the last tick that was told."""
        return self._tap.look(wanted)

    def due(self) -> int:
        """How many ticks the operator should make inputs for now; takes what the child has told."""
        self.poll()
        if not self._operator or self.paused or not self._tick_ns:
            return 0
        now, now_tick = now_ns(), self._now_tick()
        frame_ticks = (now - self._due_ns) // TICK_NS if self._due_ns else 0
        self._due_ns = now
        self._lead_ticks = max(LEAD_TICKS, min(MOST_LEAD_TICKS, max(2 * frame_ticks, self._lead_ticks - 1)))
        if self._made_tick < now_tick:  # away for long: what nobody asked for in time is not made
            self._made_tick = now_tick
        return max(0, now_tick + self._lead_ticks - self._made_tick)

    def advance(self) -> int:
        """Take what the child tells, beat, make inputs; how many ticks that was. Raises what ended the run."""
        return self.run(self.due())

    def run(self, ticks: int) -> int:
        """Make the operator's inputs for so many ticks; never further ahead than the child can use."""
        self.poll()
        if self._over or not self._operator or self.paused:
            return 0
        while self._made_tick + ticks > self._now_tick() + MOST_LEAD_TICKS + LEAD_TICKS and not self._over:
            wait_ns(TICK_NS)
            self.poll()
        if ticks > 0 and not self._over:
            first = self._made_tick
            self._made_tick += ticks
            self._tell("inputs", (first, [self.inputs(tick) for tick in range(first, first + ticks)]))
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
        return [text for _, text in notices]

    def take_touches(self) -> list[Touch]:
        """They are in the child's recording."""
        return []

    def stop(self) -> None:
        """Ask the child to come to an end; `poll` tells when it has."""
        self._tell("stop", None)

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

    # --- beyond them -------------------------------------------------------------------------------------------------

    def poll(self) -> None:
        """Beat, and take what the child has told. Raises what ended its run."""
        if self._child:
            self._tell("beat", None)
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
            select.select([self._socket], [], [], 0.05)
            self.poll()
            notices, self.notices = self.notices, []
            for tick, text in notices:
                told(tick, text)
            stopping = stopping or asked()
            if stopping:
                self.stop()

    def _now_tick(self) -> int:
        return self._tick + ((now_ns() - self._tick_ns) // TICK_NS if self._tick_ns else 0)

    def _await_ports(self) -> None:
        while not self.ports and not self._over:
            select.select([self._socket], [], [], 0.1)
            self._receive()
            if self._ready:
                return
        if self._over:
            self._reap()
            if self._error is not None:
                raise self._error

    _ready = _is_speechless = False

    def _receive(self) -> None:
        while not self._over:
            try:
                data = self._socket.recv(MOST_BYTES, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            except ConnectionResetError:
                continue  # it left before it read all of ours; what it had said is still there
            except OSError:
                data = b""
            if not data:
                self._over = self._is_speechless = True
                if self._error is None:
                    self._error = SurroundingsError(
                        "the process of the real-time loop ended without a word; what it recorded stays"
                    )
                return
            self._take(*pickle.loads(data))

    def _take(self, kind: str, value: Any) -> None:
        if kind == "ready":
            self.ports, self._ready = value, True
        elif kind == "notice":
            self.notices.append(value)
        elif kind == "state":
            state: State = value
            gone = state.tick - self._tick
            if self._tick_ns and gone > 0:
                self.pacer.speed = gone * TICK_NS / max(1, state.at_ns - self._tick_ns)
            self._tick, self._tick_ns = state.tick, state.at_ns
            if state.snapshot is not None:
                self._snapshot = state.snapshot
            self.missing = state.missing
            for out in state.outs:
                self._seen.add(out)
                self._tap.add(out)
            self.pacer.late_ticks, self.pacer.slipped_ticks = int(state.late_us / 1000), state.slipped_ticks
        elif kind == "end":
            self._tick, self._error, self.result, self.counted, self.scheduling = value
            self.lateness = self.counted.facts() if self.counted is not None else {}
            self._over = True

    def _tell(self, kind: str, value: object) -> None:
        with suppress(OSError):  # full, or gone: the next look finds out
            self._socket.send(pickle.dumps((kind, value)), socket.MSG_DONTWAIT)

    def _reap(self, kill: bool = False) -> None:
        child, self._child = self._child, 0
        if child:
            if kill:
                os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            self._socket.close()
            if kill or self._is_speechless:
                self._rescue()


def _child(prepare: Callable[[], Prepared], live: _Live) -> None:
    """All that the child does; it never returns."""
    try:
        os.setpgrp()
        for number in (signal.SIGINT, signal.SIGTSTP, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        error: BenchError | None = None
        try:
            live.run(prepare)
        except BenchError as caught:
            error = caught
        except Exception as caught:
            where = traceback.extract_tb(caught.__traceback__)[-1]
            place = f"{where.filename.rpartition('/')[2]}:{where.lineno}"
            error = BenchStopped(f"stopped at tick {live.tick}: {type(caught).__name__} in {place}: {caught}")
        live.end(error)
    finally:
        os._exit(0)


class _Live:
    """The child's side."""

    def __init__(
        self,
        link_end: socket.socket,
        inputs: Callable[[int], TickInput],
        ticks: int | None,
        operator: bool,
        watched: bool,
        with_priority: bool,
    ) -> None:
        self._socket = link_end
        self._with_priority = with_priority
        self._inputs = self._operators_inputs if operator else inputs
        self._ticks, self._watched = ticks, watched
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

    def run(self, prepare: Callable[[], Prepared]) -> None:
        """Prepare, wait for the ports, run. Ports and recording are closed whatever happens."""
        made = prepare()
        rig = self._rig = made.rig
        self._every_look = made.every_look
        try:
            inputs = rig.gated(self._inputs) if rig is not None else self._inputs
            takers = [*made.takers, self] if self._watched else made.takers
            link = InlineLink(made.bench, inputs, _NoPacer(), takers=takers, ticks=self._ticks)
            self._link = link
            ports = rig.ports if rig is not None else []
            self._tell("ready", tuple(PortNote(port.name, port.where, port.note) for port in ports))
            try:
                if self._wait_for_ports():
                    self._scheduling = be_punctual(self._with_priority)
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
        self._socket.setblocking(True)
        with suppress(OSError):  # nobody may be there to hear it
            self._socket.send(
                pickle.dumps(("end", (self.tick, error, self._result, self._metronome.lateness, self._scheduling)))
            )

    def _wait_for_ports(self) -> bool:
        """Before the first tick nothing is lost yet: wait until all are there. False where the parent gives up."""
        rig, told = self._rig, ""
        while rig is not None and not rig.find():
            waiting = "; ".join(f"{port.name}: {port.lost}" for port in rig.ports if port.lost)
            if waiting != told:
                told = waiting
                self._tell("notice", (0, f"waiting: {waiting}"))
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
        now = now_ns()
        rig = self._rig
        if rig is not None:
            silent = now - self._beat_ns > OPERATOR_SILENCE_NS
            if silent != rig.operator_silent:
                rig.operator_silent = silent
                what = "the operator is silent: zero until that changes" if silent else "the operator is back"
                rig.notices.append((tick, what))
            self._send_notices(rig)
        if now - self._state_ns >= STATE_NS:
            self._state_ns = now
            self._send_state()
        return self._stop

    def _send_notices(self, rig: Rig) -> None:
        notices, rig.notices = rig.notices, []
        for notice in notices:
            self._tell("notice", notice)

    def _send_state(self) -> None:
        link, metronome = self._link, self._metronome
        assert link is not None
        outs: tuple[TickOutput, ...] = ()
        snapshot = None
        if self._watched:
            outs, snapshot = tuple(self._outs), link.latest()
            self._outs.clear()
        missing = self._rig.missing if self._rig is not None else ()
        late_us, metronome.window_us = metronome.window_us, 0.0
        self._tell("state", State(link.now_tick, now_ns(), snapshot, outs, late_us, metronome.slipped_ticks, missing))

    def _hear(self) -> None:
        while True:
            try:
                data = self._socket.recv(MOST_BYTES, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            except ConnectionResetError:
                continue  # it left before it read all of ours; what it had said is still there
            except OSError:
                data = b""
            if not data:  # the parent is gone
                self._stop = True
                return
            kind, value = pickle.loads(data)
            if kind == "stop":
                self._stop = True
                return
            self._beat_ns = now_ns()
            if kind == "inputs":
                first, inputs = value
                self._take_inputs(first, inputs)

    def _take_inputs(self, first: int, inputs: Sequence[TickInput]) -> None:
        """What comes too late is a frame that was lost, but what it told the core still holds."""
        tick, queue = self.tick, self._queue
        for at, given in enumerate(inputs, first):
            if at >= tick:
                queue[at] = given
            elif given.core_twist is not None:
                queue[tick] = queue.get(tick, _NOTHING)._replace(core_twist=given.core_twist)

    def _operators_inputs(self, tick: int) -> TickInput:
        return self._queue.pop(tick, _NOTHING)

    def _tell(self, kind: str, value: object) -> None:
        with suppress(OSError):  # the parent does not read, or is gone: the loop does not wait for it
            self._socket.send(pickle.dumps((kind, value)), socket.MSG_DONTWAIT)


_NOTHING = TickInput()


class ChildsPacer(WallPacer):
    """Tells how the child keeps time. Its rate is that of the wall; once the child is gone it is a pacer like any."""

    is_theirs = True

    def set_rate(self, rate: float) -> None:
        """Without effect while the child runs: real time has one rate."""
        if not self.is_theirs or rate == 1.0:
            super().set_rate(rate)


class _NoPacer:
    """The metronome grants each tick; nobody asks this."""

    rate = 1.0
    speed: float | None = None
    late_ticks = 0
    slipped_ticks = 0

    def due(self, done: int) -> int:
        """None."""
        return 0

    def restart(self) -> None:
        """Nothing to forget."""

    def set_rate(self, rate: float) -> None:
        """Nothing to set."""
