"""Who asked what on the SLAMWARE bus, and which answer belongs to it: by order, as a core has to do it.

Requests are those that reached the base, answers what it sent. Where the requests hold bytes that are no frame, nobody
outside knows what the base made of them: until the line has been quiet for a partial frame to be dropped and an answer
to come, requests and answers are `excused`.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from bench.check.crosswire.block import Block
from bench.slamware.answer_table import reads
from bench.slamware.framing import CONTROL_BUS, ECHO, ERROR, IDLE_TICKS, OK, SYNC, FrameDecoder, SlamwareFrame

MOST_KNOWN = 64


class Request(NamedTuple):
    """One frame of the core."""

    tick: int
    code: int
    payload: bytes
    excused: bool

    @property
    def name(self) -> str:
        """For people: the sub-command, or the frame's code."""
        is_control = self.code == CONTROL_BUS and self.payload
        return f"0x{self.payload[0] if is_control else self.code:02X}"


class Answer(NamedTuple):
    """One frame of the base. `request` is None where nobody has asked."""

    tick: int
    frame: SlamwareFrame
    request: Request | None
    excused: bool
    fits: bool = True
    """Whether status and size are those of an answer to its request."""


class Exchanged(NamedTuple):
    """What happened in a block, each list in order of time."""

    requests: list[Request]
    answers: list[Answer]
    lost: list[Request]
    """Requests that had no answer in their time."""
    noise: list[tuple[int, int]]
    """(tick, bytes) from the base that are no frame."""


class Ledger:
    """Follows both directions, block by block."""

    def __init__(self, within_ticks: int) -> None:
        self._within = within_ticks
        self._from_core, self._from_base = FrameDecoder(), FrameDecoder()
        self._open: deque[Request] = deque()
        self._overdue = 0  # answers that may still come, to requests that count as lost
        self._undecoded = 0  # bytes of requests that have made no frame yet, and when bytes came last
        self._fed_tick = 0
        # A core repeats itself: what one frame was, alone, it is again.
        self._asked_before: dict[bytes, Request] = {}
        self._clear_tick = -1

    def take(self, block: Block) -> Exchanged:
        """The next block."""
        found = Exchanged([], [], [], [])
        for place in sorted({*block.places(block.requests), *block.places(block.answers)}):
            tick, request, answer = block.first + place, block.requests[place], block.answers[place]
            if request:
                self._ask(tick, request, found)
            if answer:
                self._answer(tick, answer, found)
        self._give_up(block.ticks[-1], found)
        return found

    def _ask(self, tick: int, data: bytes, found: Exchanged) -> None:
        if not self._undecoded:
            known = self._asked_before.get(data)
            if known is not None:
                self._fed_tick = tick
                self._open.append(known._replace(tick=tick, excused=tick <= self._clear_tick))
                found.requests.append(self._open[-1])
                return
        events = self._from_core.feed(data, tick)
        for event in events:
            if not isinstance(event, SlamwareFrame):
                # Reported when something follows: it came with the bytes before these, if all of it did.
                came = self._fed_tick if event.length <= self._undecoded else tick
                self._clear_tick = max(self._clear_tick, came + IDLE_TICKS + self._within)
        for event in events:
            self._undecoded -= event.length
        self._undecoded += len(data)
        self._fed_tick = tick
        for event in events:
            if isinstance(event, SlamwareFrame):
                request = Request(tick, event.code, event.payload, self._is_muddled(tick))
                found.requests.append(request)
                self._open.append(request)
                if len(data) == event.length and len(self._asked_before) < MOST_KNOWN:
                    self._asked_before[data] = request

    def _answer(self, tick: int, data: bytes, found: Exchanged) -> None:
        for event in self._from_base.feed(data, tick):
            if not isinstance(event, SlamwareFrame):
                found.noise.append((tick, event.length))
                continue
            self._give_up(tick, found)
            excused = self._is_muddled(tick)
            if self._open:
                request = self._open.popleft()
                found.answers.append(Answer(tick, event, request, excused or request.excused, _fits(request, event)))
            elif self._overdue:
                self._overdue -= 1
            else:
                found.answers.append(Answer(tick, event, None, excused))

    def _is_muddled(self, tick: int) -> bool:
        if self._undecoded:
            self._clear_tick = max(self._clear_tick, self._fed_tick + IDLE_TICKS + self._within)
        return tick <= self._clear_tick

    def _give_up(self, tick: int, found: Exchanged) -> None:
        while self._open and tick - self._open[0].tick > self._within:
            request = self._open.popleft()
            self._overdue += 1
            found.lost.append(request._replace(excused=request.excused or self._is_muddled(tick)))


def _fits(request: Request, frame: SlamwareFrame) -> bool:
    if frame.code == ERROR:
        return True
    if request.code in (SYNC, ECHO):
        return (frame.code, frame.payload) == (request.code, request.payload)
    return frame.code == OK and (request.code != CONTROL_BUS or reads(request.payload, frame.payload) is not None)
