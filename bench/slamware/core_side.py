"""A SLAMWARE core: the master's end of the control bus. It asks, reads what comes back and believes it.

    searching    0x10 CONNECT_BASE at once, then every `connect_ms`              OK -> connected
    connected    0x41 SET_V_AND_GET_DEADRECKON every `poll_ms`                   no answer in time -> searching

One request is outstanding at a time; an answer is matched to it by order, size and status, because it names no command.
After an error answer the next request leaves on schedule. An OK that still comes before the next request is taken, late
or behind an error: what the base refused may have been a stray byte in front of the request. Before each request stale
input is thrown away. The deadline is longer than the 100 ms after which a base drops a partial frame, so that a request
cut on its way is followed by the silence that mends it. What no vendor document gives (periods, deadline) is ours.

No clock: `step` once a tick, ticks count from 0.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from bench.messages import TICK_US, ZERO_TWIST, BodyTwist, Pose
from bench.odometry import wrap
from bench.slamware.framing import (
    CONTROL_BUS,
    ERROR,
    OK,
    STANDARD,
    FrameDecoder,
    SlamwareEvent,
    SlamwareFrame,
    encode_frame,
)
from bench.slamware.payloads import (
    CONNECT_BASE,
    DEAD_RECKON_BYTES,
    IDENTITY_BYTES,
    SET_V_AND_GET_DEADRECKON,
    Identity,
    connect_request,
    dead_reckon_from_answer,
    error_from_answer,
    identity_from_answer,
    meaning_of,
    twist_request,
)

EVENT_LOG_LENGTH = 200

NOTHING = -1
"""No request is outstanding."""

_LEAST_ANSWER_BYTES = {CONNECT_BASE: IDENTITY_BYTES, SET_V_AND_GET_DEADRECKON: DEAD_RECKON_BYTES}


class CoreEvent(NamedTuple):
    """Something a user wants to know of: "connected", "timeout", "error", "noise" or "unexpected", and the details."""

    tick: int
    kind: str
    detail: str


class SlamwareCore:
    """The master of one base. Sends standard frames, which every base must understand, and accepts both types."""

    def __init__(self, poll_ms: int = 50, connect_ms: int = 1000, answer_timeout_ms: int = 200) -> None:
        self.connected = False
        self.identity: Identity | None = None
        """What the base last said of itself."""
        self.pose = Pose(0.0, 0.0, 0.0)
        """Where the core believes the robot is: the increments of all answers that arrived, composed."""
        self.status = 0
        """Status bits of the last dead-reckoning answer."""
        self.requests: dict[int, int] = {}
        """How many requests left, by sub-command."""
        self.answers: dict[int, int] = {}
        """How many OK answers came, by the sub-command that they answer."""
        self.errors: dict[int, int] = {}
        """How many error answers came, by error code."""
        self.timeouts = 0
        self.noise_bytes = 0
        self.unexpected = 0
        """Good frames that answer nothing which was asked."""
        self.events: deque[CoreEvent] = deque(maxlen=EVENT_LOG_LENGTH)
        for name, value in (("poll_ms", poll_ms), ("connect_ms", connect_ms), ("answer_timeout_ms", answer_timeout_ms)):
            if value * 1000 < TICK_US:
                raise ValueError(f"{name} {value} is less than one tick")
        self._poll_ticks = poll_ms * 1000 // TICK_US
        self._connect_ticks = connect_ms * 1000 // TICK_US
        self._timeout_ticks = answer_timeout_ms * 1000 // TICK_US
        self._decoder = FrameDecoder()
        self._connect_frame = encode_frame(CONTROL_BUS, connect_request(), STANDARD)
        self._outstanding = NOTHING  # sub-command of the last request, until its OK comes
        self._is_waiting = False
        self._send_tick = 0
        self._act_tick = 0  # before this tick there is nothing to do but to read
        self.ask(ZERO_TWIST)

    def ask(self, twist: BodyTwist) -> None:
        """Want this velocity from the next poll on. Raises ValueError where it does not fit on the wire."""
        self._velocity_frame = encode_frame(CONTROL_BUS, twist_request(twist), STANDARD)

    def step(self, tick: int, answer_bytes: bytes) -> bytes:
        """Read what came from the base; return what leaves in this tick, nothing most of the time."""
        if answer_bytes:
            self._read(self._decoder.feed(answer_bytes, tick), tick)
        if tick < self._act_tick:
            return b""
        return self._act(tick)

    def _act(self, tick: int) -> bytes:
        # Looking again at the deadline may still find the answer, behind a false start of a frame.
        self._read(self._decoder.finish(), tick)
        if self._is_waiting:
            self._is_waiting = False
            self.timeouts += 1
            self._log(tick, "timeout", f"no answer to 0x{self._outstanding:02X}")
            self.connected = False
            if self._outstanding == CONNECT_BASE:
                self._act_tick = self._send_tick + self._connect_ticks
        if tick < self._act_tick:
            return b""
        sub_command, frame = SET_V_AND_GET_DEADRECKON, self._velocity_frame
        if not self.connected:
            sub_command, frame = CONNECT_BASE, self._connect_frame
        self.requests[sub_command] = self.requests.get(sub_command, 0) + 1
        self._outstanding = sub_command
        self._is_waiting = True
        self._send_tick = tick
        self._act_tick = tick + self._timeout_ticks
        return frame

    def _read(self, events: list[SlamwareEvent], tick: int) -> None:
        for event in events:
            if not isinstance(event, SlamwareFrame):
                self.noise_bytes += event.length
                self._log(tick, "noise", f"{event.length} bytes refused: {event.reason}")
            elif self._is_error(event, tick) or self._is_answer(event, tick):
                self._is_waiting = False
                self._act_tick = self._send_tick + (self._poll_ticks if self.connected else self._connect_ticks)
            else:
                self.unexpected += 1
                self._log(tick, "unexpected", f"code 0x{event.code:02X} with {len(event.payload)} bytes")

    def _is_error(self, frame: SlamwareFrame, tick: int) -> bool:
        """Note an error answer to the outstanding request; False where the frame is something else."""
        if frame.code != ERROR or len(frame.payload) != 2 or self._outstanding == NOTHING:
            return False
        code = error_from_answer(frame.payload)
        self.errors[code] = self.errors.get(code, 0) + 1
        self._log(tick, "error", f"0x{code:04X} to 0x{self._outstanding:02X}: {meaning_of(code)}")
        return True

    def _is_answer(self, frame: SlamwareFrame, tick: int) -> bool:
        """Use the OK to the outstanding request; False where the frame cannot be that."""
        sub_command = self._outstanding
        if frame.code != OK or sub_command == NOTHING or len(frame.payload) < _LEAST_ANSWER_BYTES[sub_command]:
            return False
        self._outstanding = NOTHING
        self.answers[sub_command] = self.answers.get(sub_command, 0) + 1
        if sub_command == CONNECT_BASE:
            self.identity = identity_from_answer(frame.payload)
            self.connected = True
            self._log(tick, "connected", self.identity.model)
        else:
            self._move(frame.payload)
        return True

    def _move(self, payload: bytes) -> None:
        # An increment is a displacement, not a twist: it is turned into the frame and added, without the exponential.
        dx_m, dy_m, dtheta_rad, self.status = dead_reckon_from_answer(payload)
        x_m, y_m, heading_rad = self.pose
        c, s = math.cos(heading_rad), math.sin(heading_rad)
        self.pose = Pose(x_m + c * dx_m - s * dy_m, y_m + s * dx_m + c * dy_m, wrap(heading_rad + dtheta_rad))

    def _log(self, tick: int, kind: str, detail: str) -> None:
        self.events.append(CoreEvent(tick, kind, detail))
