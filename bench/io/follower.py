"""What a screen sees of a run beside the bench itself: the last frame of each wire, and where the robot has been."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from bench.config import Robot
from bench.kinematics import Kinematics
from bench.messages import CanFrame, RcFrame, Snapshot, StateRow, TickOutput
from bench.slamware import FrameDecoder, SlamwareEvent

TRAIL_PERIOD_TICKS = 50
TRAIL_STEP_M = 0.005
TRAIL_POINTS = 1200
SLIPS, SLIP_MPS = 200, 0.05
"""So many places are kept where a wheel slid over the floor. Slower, it only creeps under load."""
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


class Followed(ABC):
    """What a link says to a screen through its follower (`_seen`)."""

    _seen: Follower

    @abstractmethod
    def latest(self) -> Snapshot:
        """The bench as it is after the last tick that is shown."""

    @property
    def wires(self) -> Wires:
        """The last frames, as they are after that tick."""
        return self._seen.wires(self.latest().rc_frame)

    @property
    def trail(self) -> Sequence[tuple[float, float]]:
        """(x_m, y_m) of where the robot has been."""
        return self._seen.trail

    @property
    def slips(self) -> Sequence[tuple[float, float]]:
        """(x_m, y_m) of where a wheel slid over the floor, the newest last."""
        return self._seen.slips


class Follower:
    """Takes every tick by `add`. `trail`: (x_m, y_m) of where the robot has been; `slips`: of where a wheel slid."""

    def __init__(self, state_columns: Sequence[str], robot: Robot) -> None:
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL_POINTS)
        self.slips: deque[tuple[float, float]] = deque(maxlen=SLIPS)
        self._kinematics = Kinematics(robot.wheels)
        self._x, self._vx = state_columns.index("x_m"), state_columns.index("vx_mps")
        self._wheels = [state_columns.index(f"wheel{number}_radps") for number in range(1, len(robot.wheels) + 1)]
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
            self._follow(out.state)

    def _follow(self, state: StateRow) -> None:
        trail = self.trail
        x_m, y_m = float(state[self._x]), float(state[self._x + 1])
        if self._slides(state):
            self.slips.append((x_m, y_m))
        if not trail or abs(x_m - trail[-1][0]) + abs(y_m - trail[-1][1]) > TRAIL_STEP_M:
            trail.append((x_m, y_m))

    def _slides(self, state: StateRow) -> bool:
        """Whether the floor moves under a wheel, along its roller axis, other than the wheel rolls."""
        rolled = self._kinematics.wheel_speeds([float(value) for value in state[self._vx : self._vx + 3]])
        wheels = zip(self._wheels, rolled, self._kinematics.radii, strict=True)
        return any(abs(radius * (floor - float(state[place]))) > SLIP_MPS for place, floor, radius in wheels)
