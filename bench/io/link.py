"""How a screen follows a bench. InlineLink runs the ticks that are due inside the caller's own timer.

What a screen needs of a link: `advance` from its timer, `latest` and `wires` to draw, `pause`, `run`, `close`. A bench
on real ports will live in a process of its own behind the same names; the screen shall not see the difference.
"""

from __future__ import annotations

import traceback
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from bench.errors import EXIT_FAILED, BenchError
from bench.io.clock import Pacer
from bench.loop import Bench
from bench.messages import CanFrame, Snapshot, TickInput, TickOutput
from bench.slamware import FrameDecoder, SlamwareEvent

TRAIL_PERIOD_TICKS = 50
TRAIL_STEP_M = 0.005
TRAIL_POINTS = 1200
RC_TAIL = 256
"""Bytes of the RC stream that are kept: more than the longest frame and what may follow it."""


class BenchStopped(BenchError):
    """A stage of the bench raised. The run ends there; its recording is closed and holds every tick before."""

    exit_status = EXIT_FAILED


class Taker(Protocol):
    """Whoever wants every tick: a recorder, a comparison, a summary. One that has a `close` is told of the end."""

    def add(self, out: TickOutput) -> None:
        """Take one tick."""
        ...


@runtime_checkable
class _Closing(Protocol):
    def close(self) -> None: ...


@dataclass(frozen=True, slots=True)
class Wires:
    """The last thing that crossed each wire, with its tick; None where nothing has yet."""

    rc: tuple[int, bytes] | None = None
    can_commands: tuple[int, tuple[CanFrame, ...]] | None = None
    can_feedback: tuple[int, tuple[CanFrame, ...]] | None = None
    core_to_base: tuple[int, SlamwareEvent] | None = None
    base_to_core: tuple[int, SlamwareEvent] | None = None


class InlineLink:
    """A bench in the caller's own process: `advance` runs what the pacer grants, never more than its burst.

    `inputs` gives what enters each tick, in order, each once. `ticks` ends the run (None: endless). Every output goes
    to the takers in their order. `trail` holds (x_m, y_m) of where the robot has been.
    """

    def __init__(
        self,
        bench: Bench,
        inputs: Callable[[int], TickInput],
        pacer: Pacer,
        *,
        takers: Sequence[Taker] = (),
        ticks: int | None = None,
    ) -> None:
        self.bench = bench
        self.pacer = pacer
        self.ticks = ticks
        self.paused = False
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL_POINTS)
        self._inputs = inputs
        self._takers = tuple(takers)
        self._closed = False
        self._snapshot = bench.snapshot()
        self._x = bench.state_columns.index("x_m")
        self._rc_tick = 0
        self._rc_total = 0
        self._rc_tail = bytearray()
        self._last: TickOutput | None = None
        self._requests, self._answers = FrameDecoder(), FrameDecoder()
        self._request: tuple[int, SlamwareEvent] | None = None
        self._answer: tuple[int, SlamwareEvent] | None = None
        self._feedback: tuple[int, tuple[CanFrame, ...]] | None = None

    @property
    def now_tick(self) -> int:
        """How many ticks have run."""
        return self.bench.now_tick

    @property
    def ended(self) -> bool:
        """Whether the run has come to its last tick."""
        return self.ticks is not None and self.bench.now_tick >= self.ticks

    def latest(self) -> Snapshot:
        """The bench as it is after the last tick."""
        if self._snapshot.tick != self.bench.now_tick:
            self._snapshot = self.bench.snapshot()
        return self._snapshot

    @property
    def wires(self) -> Wires:
        """The last frames, as they are after the last tick."""
        last = self._last
        commands = (last.tick, last.can_commands) if last is not None else None
        return Wires(self._last_rc(), commands, self._feedback, self._request, self._answer)

    def _last_rc(self) -> tuple[int, bytes] | None:
        """The bytes of the last good frame; while there is none, what came last."""
        frame, tail = self.latest().rc_frame, self._rc_tail
        if frame is not None:
            start = frame.offset - (self._rc_total - len(tail))
            tail = tail[start : start + frame.length] if start >= 0 else tail
        return (self._rc_tick, bytes(tail[-RC_TAIL:])) if self._rc_total else None

    def pause(self, paused: bool) -> None:
        """Stand still, or go on as if no time had passed."""
        self.paused = paused
        self.pacer.restart()

    def advance(self) -> int:
        """Run what is due; how many ticks that was. Raises BenchStopped, or what a taker raised, with all closed."""
        if self.paused or self.ended:
            return 0
        return self.run(self.pacer.due(self.bench.now_tick))

    def run(self, ticks: int) -> int:
        """Run so many ticks, due or not, but none after the end; how many that was. Raises like `advance`."""
        if self.ticks is not None:
            ticks = min(ticks, self.ticks - self.bench.now_tick)
        try:
            for _ in range(ticks):
                self._run_one()
        except BaseException as error:
            self.close()
            if isinstance(error, BenchError) or not isinstance(error, Exception):
                raise
            where = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{where.filename.rpartition('/')[2]}:{where.lineno}"
            tick = self.bench.now_tick
            raise BenchStopped(f"stopped at tick {tick}: {type(error).__name__} in {place}: {error}") from error
        return ticks

    def close(self) -> None:
        """End the recording, and whatever else was told every tick. A second call does nothing."""
        if not self._closed:
            self._closed = True
            for taker in self._takers:
                if isinstance(taker, _Closing):
                    taker.close()

    def _run_one(self) -> None:
        bench = self.bench
        out = self._last = bench.tick(self._inputs(bench.now_tick))
        for taker in self._takers:
            taker.add(out)
        tick = out.tick
        if out.rc:
            self._rc_tick = tick
            self._rc_total += len(out.rc)
            self._rc_tail += out.rc
            if len(self._rc_tail) > 4 * RC_TAIL:
                del self._rc_tail[:-RC_TAIL]
        if out.can_feedback:
            self._feedback = (tick, out.can_feedback)
        if out.core_to_base and (events := self._requests.feed(out.core_to_base, tick)):
            self._request = (tick, events[-1])
        if out.base_to_core and (events := self._answers.feed(out.base_to_core, tick)):
            self._answer = (tick, events[-1])
        if tick % TRAIL_PERIOD_TICKS == 0 and out.state is not None:
            self._follow(float(out.state[self._x]), float(out.state[self._x + 1]))

    def _follow(self, x_m: float, y_m: float) -> None:
        trail = self.trail
        if not trail or abs(x_m - trail[-1][0]) + abs(y_m - trail[-1][1]) > TRAIL_STEP_M:
            trail.append((x_m, y_m))
