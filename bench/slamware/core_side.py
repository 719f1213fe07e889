"""A SLAMWARE core: the master's end of the control bus. It asks, reads what comes back and believes it.

    searching    0x10 CONNECT_BASE at once, then every `connect_ms`           OK -> connected, silence -> lost
    lost         the procedure of `resync`                                    done or in vain -> searching
    connected    the velocity every `poll_ms`, between them the `schedule`    no answer in time -> searching
    either       three requests in a row came damaged, says the base          -> lost

One request is outstanding at a time; an answer is matched to it by order, size and status, because it names no command.
After an error answer the next request leaves on schedule. An OK that still comes before the next request is taken, late
or behind an error: what the base refused may have been a stray byte in front of the request. Before each request stale
input is thrown away. The deadline is longer than the 100 ms after which a base drops a partial frame, so that a request
cut on its way is followed by the silence that mends it. Three damaged in a row may be a base that is out of step: the
reference base can take the tail of each request for the start of the next, and would do so for ever. What no vendor
document gives (periods, deadline) is ours.

No clock: `step` once a tick, ticks count from 0.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench.messages import TICK_US, ZERO_TWIST, BodyTwist, Pose
from bench.slamware import commands as bus
from bench.slamware.answer_table import reads
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
from bench.slamware.health import fault_in_words, fault_request
from bench.slamware.knowledge import Knowledge
from bench.slamware.ledger import Ledger
from bench.slamware.payloads import (
    Identity,
    connect_request,
    error_from_answer,
    meaning_of,
    twist_request,
    wheels_request,
)
from bench.slamware.resync import DONE, RUNNING, Resync
from bench.slamware.schedule import MOST_WAITING, VELOCITY_ONLY, Schedule, Timetable, check_request

MOST_FAULTS = 16
"""Faults whose text is asked for after a summary that counts any."""
OUT_OF_STEP_AFTER = 3
"""Requests in a row that the base has called damaged."""

_CONNECT = connect_request()


class SlamwareCore(Ledger):
    """The master of one base. Sends standard frames, which every base must understand, and accepts both types."""

    def __init__(
        self,
        poll_ms: int = 50,
        connect_ms: int = 1000,
        answer_timeout_ms: int = 200,
        schedule: Schedule = VELOCITY_ONLY,
    ) -> None:
        super().__init__()
        self.connected = False
        self.known = Knowledge()
        """The latest of everything that the base has told."""
        for name, value in (("poll_ms", poll_ms), ("connect_ms", connect_ms), ("answer_timeout_ms", answer_timeout_ms)):
            if value * 1000 < TICK_US:
                raise ValueError(f"{name} {value} is less than one tick")
        self._poll_ticks = poll_ms * 1000 // TICK_US
        self._connect_ticks = connect_ms * 1000 // TICK_US
        self._timetable = Timetable(twist_request(ZERO_TWIST), self._poll_ticks, schedule)
        self._timeout_ticks = answer_timeout_ms * 1000 // TICK_US
        self._decoder = FrameDecoder()
        self._resync: Resync | None = None
        self._outstanding = b""  # the last request, until its OK comes
        self._is_waiting = False
        self._is_damaged = False  # the last request, as far as the base has said
        self._damaged_in_a_row = 0
        self._send_tick = 0
        self._connect_tick = 0  # before this tick no handshake is tried
        self.act_tick = 0
        """Before this tick there is nothing to do but to read: a step without bytes changes nothing."""

    @property
    def pose(self) -> Pose:
        """Where the core believes the robot is."""
        return self.known.pose

    @property
    def status(self) -> int:
        """Status bits of the last dead-reckoning answer."""
        return self.known.status

    @property
    def identity(self) -> Identity | None:
        """What the base last said of itself."""
        return self.known.identity

    def ask(self, twist: BodyTwist) -> None:
        """Want this velocity from the next poll on. Raises ValueError where it does not fit on the wire."""
        self._timetable.velocity = twist_request(twist)

    def ask_wheels(self, speeds_mps: Sequence[float]) -> None:
        """Want these rim speeds from the next poll on: 0x40 in place of 0x41, so no displacements come."""
        self._timetable.velocity = wheels_request(speeds_mps)

    def request(self, payload: bytes) -> None:
        """Send this request once, when the line is free. Raises ValueError for none of 0xF8's, or for the 65th."""
        check_request(payload)
        if self._timetable.is_full:
            raise ValueError(f"{MOST_WAITING} requests are waiting already")
        self._timetable.add(payload)
        self._plan()

    def step(self, tick: int, answer_bytes: bytes) -> bytes:
        """Read what came from the base; return what leaves in this tick, nothing most of the time."""
        if answer_bytes:
            events = self._decoder.feed(answer_bytes, tick)
            if self._resync is not None:
                return self._bring_back(tick, True, events)
            self._read(events, tick)
        if tick < self.act_tick:
            return b""
        return self._act(tick) if self._resync is None else self._bring_back(tick, False, ())

    def _act(self, tick: int) -> bytes:
        # Looking again at the deadline may still find the answer, behind a false start of a frame.
        self._read(self._decoder.finish(), tick)
        if self._is_waiting:
            self._give_up_waiting(tick)
        if tick < self.act_tick:
            return b""
        if self._damaged_in_a_row >= OUT_OF_STEP_AFTER:
            self.connected = False
            self._connect_tick = tick
            self._lose(tick, f"the base called {OUT_OF_STEP_AFTER} requests in a row damaged")
        if self._resync is not None:
            return self._bring_back(tick, False, ())
        request = self._timetable.take(tick) if self.connected else _CONNECT
        self.count(self.requests, request[0])
        self._outstanding = request
        self._is_waiting = True
        self._is_damaged = False
        self._send_tick = tick
        self.act_tick = tick + self._timeout_ticks
        return encode_frame(CONTROL_BUS, request, STANDARD)

    def _give_up_waiting(self, tick: int) -> None:
        self._is_waiting = False
        self.timeouts += 1
        self.log(tick, "timeout", f"no answer to 0x{self._outstanding[0]:02X}")
        self.connected = False
        if self._outstanding == _CONNECT:
            self._connect_tick = self._send_tick + self._connect_ticks
            self._lose(tick, "the base does not answer")
        else:
            self._connect_tick = tick

    def _lose(self, tick: int, why: str) -> None:
        self.log(tick, "lost", f"{why}; ending its open frame, if it has one")
        self._resync = Resync(tick, self.resyncs)
        self.resyncs += 1
        self._damaged_in_a_row = 0
        self.act_tick = tick

    def _bring_back(self, tick: int, heard: bool, events: Sequence[SlamwareEvent]) -> bytes:
        for event in events:
            if not isinstance(event, SlamwareFrame):
                self.refused(event, tick)
            elif self._is_answer(event, tick):  # late, but what the line was waiting for
                self._resync = None
                self._plan()
                return b""
        resync = self._resync
        assert resync is not None
        out = resync.step(tick, heard, events)
        if out:
            self._decoder.finish()
        if resync.state != RUNNING:
            self._resync = None
            if resync.state == DONE:
                self.log(tick, "in step", "SYNC came back")
                self._connect_tick = tick + 1
            self._plan()
        return out

    def _plan(self) -> None:
        """When there is something to do next, unless something is under way."""
        if not self._is_waiting and self._resync is None:
            self.act_tick = self._timetable.next_tick() if self.connected else self._connect_tick

    def _read(self, events: Sequence[SlamwareEvent], tick: int) -> None:
        for event in events:
            if not isinstance(event, SlamwareFrame):
                self.refused(event, tick)
            elif self._is_error(event, tick) or self._is_answer(event, tick):
                self._is_waiting = False
                self._plan()
            else:
                self.unexpected += 1
                self.log(tick, "unexpected", f"code 0x{event.code:02X} with {len(event.payload)} bytes")

    def _is_error(self, frame: SlamwareFrame, tick: int) -> bool:
        """Note an error answer to the outstanding request; False where the frame is something else."""
        if frame.code != ERROR or len(frame.payload) != 2 or not self._outstanding:
            return False
        code = error_from_answer(frame.payload)
        self.count(self.errors, code)
        self.log(tick, "error", f"0x{code:04X} to 0x{self._outstanding[0]:02X}: {meaning_of(code)}")
        if code == bus.NOT_SUPPORTED:
            self._timetable.rest(self._outstanding)
        # What was damaged on its way is worth another try soon; what was refused is not.
        is_damaged = code < bus.NOT_SUPPORTED
        self._connect_tick = self._send_tick + (self._poll_ticks if is_damaged else self._connect_ticks)
        self._damaged_in_a_row += is_damaged and not self._is_damaged
        self._is_damaged = self._is_damaged or is_damaged
        return True

    def _is_answer(self, frame: SlamwareFrame, tick: int) -> bool:
        """Use the OK to the outstanding request; False where the frame cannot be that."""
        request = self._outstanding
        kind = reads(request, frame.payload) if frame.code == OK else None
        if kind is None:
            return False
        self._outstanding = b""
        self._damaged_in_a_row = 0
        self.count(self.answers, request[0])
        self.known.take(kind, request, frame.payload)
        if request == _CONNECT and self.known.identity is not None:
            self.connected = True
            self.log(tick, "connected", self.known.identity.model)
            self._timetable.begin(tick, self._send_tick)
        elif kind == (bus.POLL_BASE_CMD, 0) and self.known.base_request is not None:
            asked = self.known.base_request
            self.log(tick, "asked", f"0x{asked:02X} {bus.BASE_REQUEST_NAMES.get(asked, 'unknown')}")
            self._timetable.add(bytes((bus.POLL_BASE_ANS_CMD,)), first=True)
        elif kind == (bus.HEALTH_MGMT, bus.GET_HEALTH) and self.known.health is not None:
            for index in range(min(self.known.health.number, MOST_FAULTS)):
                self._timetable.add(fault_request(index))
        elif kind == (bus.HEALTH_MGMT, bus.GET_FAULT):
            self.log(tick, "fault", fault_in_words(self.known.faults[request[2]].code))
        return True
