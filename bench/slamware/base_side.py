"""The base's end of the control bus: request bytes in, answer bytes out. It never speaks first.

What arrives                                     what leaves                            counts as life of the core
    SYNC, ECHO                                   the same bytes                         no
    0xF8, known sub-command, right size          OK with its data, or 0x8000            yes
    0xF8, unknown sub-command                    error 0x8000, not supported            yes
    0xF8, wrong size                             error 0x8001, format error             yes
    any other code                               error 0x8000                           no
    bad checksum                                 error 0x0040                           no
    length 0                                     error 0x8001                           no
    longer than 513 bytes                        error 0x0020, as its length arrives    no
    a run of bytes that start no frame           error 0x0010, at its first byte        no
    a frame whose rest does not come in 100 ms   nothing                                no

A refused frame is refused whole: what was announced is passed over (at most until the line is idle for 100 ms), so that
nothing inside a damaged frame is ever executed. One fault gets one answer: of stray bytes in a row only the first is
answered, because a core whose request came in pieces must read one answer, not seventeen.

Each answer is a long frame, except the copies of SYNC and ECHO, which keep their type.
"""

from __future__ import annotations

from bench.messages import TICK_US
from bench.slamware.answers import Answers, Refused
from bench.slamware.commands import (
    BAD_CHECKSUM,
    BAD_FORMAT,
    NOT_SUPPORTED,
    NOT_SYNCHRONISED,
    SUB_COMMANDS,
    TOO_LONG,
    well_sized,
)
from bench.slamware.facts import BaseFacts
from bench.slamware.framing import (
    CONTROL_BUS,
    ECHO,
    ERROR,
    IDLE_TICKS,
    OK,
    SYNC,
    FrameDecoder,
    SlamwareFrame,
    SlamwareNoise,
    encode_frame,
)
from bench.slamware.payloads import error_answer
from bench.slamware.senses import Motion, Senses

MAX_REQUEST_BYTES = 513
"""What the reference base takes: its 512-byte buffer holds no checksum of a long frame (length 509, verified)."""

_ERROR_OF = {"flag": NOT_SYNCHRONISED, "oversize": TOO_LONG, "checksum": BAD_CHECKSUM, "length": BAD_FORMAT}


class SlamwareBase(Answers):
    """The SLAMWARE slave of one base, as ours is: strict. `receive` is all that a wire needs.

    `motion` and `senses` are asked while a request is answered, and at no other time. ValueError where the facts do not
    fit on the wire.
    """

    def __init__(
        self, facts: BaseFacts, motion: Motion, senses: Senses | None = None, core_timeout_ms: int = 1000
    ) -> None:
        super().__init__(facts, motion, senses)
        self.requests: dict[int, int] = {}
        """How many good 0xF8 frames came, by sub-command."""
        self.errors: dict[int, int] = {}
        """How many error answers left, by error code."""
        self._decoder = FrameDecoder(rescan=False, max_bytes=MAX_REQUEST_BYTES)
        self._core_timeout_ticks = core_timeout_ms * 1000 // TICK_US
        self.last_alive_tick = -1
        """The core counts as alive up to this tick, unless it says something more."""
        self._stray_end = -1  # stream offset and tick behind the last stray byte
        self._stray_tick = 0

    def alive(self, tick: int) -> bool:
        """Whether a good 0xF8 frame came within the core timeout: at 1000 ms it still drives, at 1001 ms it is dead."""
        return tick <= self.last_alive_tick

    def receive(self, data: bytes, tick: int) -> bytes:
        """Answers to what these bytes complete, in order; empty while there is nothing to answer."""
        if not data:
            return b""
        answers = []
        for event in self._decoder.feed(data, tick):
            if isinstance(event, SlamwareFrame):
                answers.append(self._answer(event, tick))
            elif event.reason in _ERROR_OF and not self._continues_stray_run(event, tick):
                answers.append(self._error(_ERROR_OF[event.reason]))
        return b"".join(answers)

    def _continues_stray_run(self, noise: SlamwareNoise, tick: int) -> bool:
        if noise.reason != "flag":
            return False
        is_next = noise.offset == self._stray_end and tick - self._stray_tick < IDLE_TICKS
        self._stray_end = noise.offset + noise.length
        self._stray_tick = tick
        return is_next

    def _answer(self, frame: SlamwareFrame, tick: int) -> bytes:
        if frame.code == CONTROL_BUS:
            self._live(tick)
            try:
                return encode_frame(OK, self._checked(frame.payload, tick))
            except Refused as refused:
                return self._error(refused.code)
        if frame.code in (SYNC, ECHO):
            return encode_frame(frame.code, frame.payload, frame.type)
        return self._error(NOT_SUPPORTED)

    def _live(self, tick: int) -> None:
        if not self.alive(tick):
            # The core is back from silence. Until it says so again, what it wanted before must not move the robot.
            self.stop()
        self.last_alive_tick = tick + self._core_timeout_ticks

    def _checked(self, payload: bytes, tick: int) -> bytes:
        if not payload:
            raise Refused(BAD_FORMAT)
        sub_command, fields = payload[0], payload[1:]
        self.requests[sub_command] = self.requests.get(sub_command, 0) + 1
        if sub_command in SUB_COMMANDS and not well_sized(sub_command, fields):
            raise Refused(BAD_FORMAT)
        return self.carry_out(sub_command, fields, tick)

    def _error(self, code: int) -> bytes:
        self.errors[code] = self.errors.get(code, 0) + 1
        return encode_frame(ERROR, error_answer(code))
