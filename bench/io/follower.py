"""What a screen sees of a run beside the bench itself: the last frame of each wire, and where the robot has been."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from bench.messages import CanFrame, RcFrame, TickOutput
from bench.slamware import FrameDecoder, SlamwareEvent

TRAIL_PERIOD_TICKS = 50
TRAIL_STEP_M = 0.005
TRAIL_POINTS = 1200
RC_TAIL = 256
"""Bytes of the RC stream that are kept: more than the longest frame and what may follow it."""


@dataclass(frozen=True, slots=True)
class Wires:
    """The last thing that crossed each wire, with its tick; None where nothing has yet."""

    rc: tuple[int, bytes] | None = None
    can_commands: tuple[int, tuple[CanFrame, ...]] | None = None
    can_feedback: tuple[int, tuple[CanFrame, ...]] | None = None
    core_to_base: tuple[int, SlamwareEvent] | None = None
    base_to_core: tuple[int, SlamwareEvent] | None = None


class Follower:
    """Takes every tick by `add`. `trail` holds (x_m, y_m) of where the robot has been."""

    def __init__(self, state_columns: Sequence[str]) -> None:
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL_POINTS)
        self._x = state_columns.index("x_m")
        self._rc_tick = 0
        self._rc_total = 0
        self._rc_tail = bytearray()
        self._last: TickOutput | None = None
        self._requests, self._answers = FrameDecoder(), FrameDecoder()
        self._request: tuple[int, SlamwareEvent] | None = None
        self._answer: tuple[int, SlamwareEvent] | None = None
        self._feedback: tuple[int, tuple[CanFrame, ...]] | None = None

    def wires(self, rc_frame: RcFrame | None) -> Wires:
        """The last frames, as they are after the last tick; `rc_frame` is the last good one."""
        last = self._last
        commands = (last.tick, last.can_commands) if last is not None else None
        return Wires(self._last_rc(rc_frame), commands, self._feedback, self._request, self._answer)

    def _last_rc(self, frame: RcFrame | None) -> tuple[int, bytes] | None:
        """The bytes of the last good frame; while there is none, what came last."""
        tail = self._rc_tail
        if frame is not None:
            start = frame.offset - (self._rc_total - len(tail))
            tail = tail[start : start + frame.length] if start >= 0 else tail
        return (self._rc_tick, bytes(tail[-RC_TAIL:])) if self._rc_total else None

    def add(self, out: TickOutput) -> None:
        """Take one tick."""
        self._last = out
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
