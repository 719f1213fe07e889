"""What a core asks, and when. No vendor document tells the real core's order or rates: these are ours."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from bench.messages import TICK_US
from bench.slamware.answer_table import kind_of
from bench.slamware.commands import (
    DOCK_BEACONS,
    GET_AUTO_HOME_DATA,
    GET_BASE_BUMPER_DATA,
    GET_BASE_CONF,
    GET_BASE_MOTOR_DATA,
    GET_BASE_SENSOR_DATA,
    GET_BASE_STATUS,
    GET_BINARY_CONF,
    POLL_BASE_CMD,
    SYSTEM_UP,
    well_sized,
)
from bench.slamware.health import health_request
from bench.slamware.payloads import event_request

MOST_WAITING = 64


class Poll(NamedTuple):
    """A request that is repeated. One that the base refuses as not supported rests until it connects again."""

    request: bytes
    period_ms: int


class Schedule(NamedTuple):
    """Requests once after each handshake, and polls that share the line with the velocity, which comes first."""

    on_connect: tuple[bytes, ...] = ()
    polls: tuple[Poll, ...] = ()


VELOCITY_ONLY = Schedule()
FULL = Schedule(
    on_connect=(bytes((GET_BINARY_CONF,)), bytes((GET_BASE_CONF,)), event_request(SYSTEM_UP)),
    polls=(
        Poll(bytes((GET_BASE_BUMPER_DATA,)), 100),
        Poll(bytes((GET_BASE_SENSOR_DATA,)), 100),
        Poll(bytes((POLL_BASE_CMD,)), 200),
        Poll(bytes((GET_BASE_MOTOR_DATA,)), 500),
        Poll(bytes((GET_AUTO_HOME_DATA, DOCK_BEACONS)), 500),
        Poll(bytes((GET_BASE_STATUS,)), 1000),
        Poll(health_request(), 1000),
    ),
)
SCHEDULES = {"velocity": VELOCITY_ONLY, "full": FULL}
"""By the `polls` of a robot file."""


class Timetable:
    """Which request leaves next on a connected line: the velocity when it is due, then those once, then the polls."""

    def __init__(self, velocity: bytes, poll_ticks: int, schedule: Schedule) -> None:
        self.velocity = velocity
        """The request that tells the wheels what to do: 0x41, or 0x40."""
        for request in (*schedule.on_connect, *(poll.request for poll in schedule.polls)):
            check_request(request)
        self._poll_ticks = poll_ticks
        self._on_connect = schedule.on_connect
        self._periods = {poll.request: max(1, poll.period_ms * 1000 // TICK_US) for poll in schedule.polls}
        self._due: dict[bytes, int] = {}
        self._velocity_tick = 0
        self._waiting: deque[bytes] = deque()

    def begin(self, tick: int, connected_tick: int) -> None:
        """The base is there since a request of `connected_tick`: everything starts anew."""
        self._velocity_tick = connected_tick + self._poll_ticks
        for request in reversed(self._on_connect):
            self.add(request, first=True)
        self._due = dict.fromkeys(self._periods, tick)

    def add(self, request: bytes, *, first: bool = False) -> None:
        """Let this request leave once; not twice where it waits already. One too many is left out."""
        if request in self._waiting or self.is_full:
            return
        if first:
            self._waiting.appendleft(request)
        else:
            self._waiting.append(request)

    @property
    def is_full(self) -> bool:
        """Whether no further request can wait."""
        return len(self._waiting) >= MOST_WAITING

    def rest(self, request: bytes) -> None:
        """Poll this no more, until the base connects again."""
        self._due.pop(request, None)

    def take(self, tick: int) -> bytes:
        """What leaves now, `next_tick` having come."""
        if tick < self._velocity_tick:
            if self._waiting:
                return self._waiting.popleft()
            for request, due_tick in self._due.items():
                if tick >= due_tick:
                    # Behind those that are as late: nobody waits for ever.
                    del self._due[request]
                    self._due[request] = tick + self._periods[request]
                    return request
        self._velocity_tick = tick + self._poll_ticks
        return self.velocity

    def next_tick(self) -> int:
        """When something leaves next; a tick that has passed means at once."""
        if self._waiting:
            return 0
        return min(self._velocity_tick, *self._due.values()) if self._due else self._velocity_tick


def check_request(payload: bytes) -> None:
    """Raises ValueError where a payload is no request of 0xF8 that a base could answer."""
    if kind_of(payload) is None or not well_sized(payload[0], payload[1:]):
        raise ValueError(f"{payload.hex() or 'nothing'} is no request of the control bus")
