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

from collections.abc import Callable

from bench.config import SlamwareSettings
from bench.messages import TICK_US, ZERO_TWIST, BodyTwist
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
from bench.slamware.payloads import (
    BAD_CHECKSUM,
    BAD_FORMAT,
    CONNECT_BASE,
    NOT_SUPPORTED,
    NOT_SYNCHRONISED,
    PROTOCOL_VERSION,
    SET_V_AND_GET_DEADRECKON,
    SUB_COMMANDS,
    TOO_LONG,
    Identity,
    dead_reckon_answer,
    error_answer,
    identity_answer,
    twist_from_request,
)

MAX_REQUEST_BYTES = 513
"""What the reference base takes: its 512-byte buffer holds no checksum of a long frame (length 509, verified)."""

_ERROR_OF = {"flag": NOT_SYNCHRONISED, "oversize": TOO_LONG, "checksum": BAD_CHECKSUM, "length": BAD_FORMAT}


class _Refused(Exception):
    """A well-formed request that this base does not carry out."""

    def __init__(self, code: int) -> None:
        super().__init__(f"error 0x{code:04X}")
        self.code = code


class SlamwareBase:
    """The SLAMWARE slave of one base.

    `take_increment` returns the displacement (dx_m, dy_m, dtheta_rad) since its last call, in the robot's frame as it
    stood then. It is called for a 0x41 that is answered, and for no other reason. `settings` are what 0x10 answers;
    ValueError where they do not fit on the wire.
    """

    def __init__(
        self,
        settings: SlamwareSettings,
        take_increment: Callable[[], tuple[float, float, float]],
        core_timeout_ms: int = 1000,
    ) -> None:
        self.wanted_twist: BodyTwist = ZERO_TWIST
        """Velocity of the last 0x41. Means nothing while the core is not alive."""
        self.connected = False
        """Whether a core has shaken hands since boot. 0x41 is obeyed without, as the reference base does."""
        self.requests: dict[int, int] = {}
        """How many good 0xF8 frames came, by sub-command."""
        self.errors: dict[int, int] = {}
        """How many error answers left, by error code."""
        self._decoder = FrameDecoder(rescan=False, max_bytes=MAX_REQUEST_BYTES)
        self._take_increment = take_increment
        self._core_timeout_ticks = core_timeout_ms * 1000 // TICK_US
        self._life_tick: int | None = None
        self._stray_end = -1  # stream offset and tick behind the last stray byte
        self._stray_tick = 0
        self._has_reported_motion = False
        self._identity_answer = identity_answer(
            Identity(settings.model, settings.firmware_version, settings.hardware_version, settings.serial_number)
        )
        self._handlers: dict[int, Callable[[bytes], bytes]] = {
            CONNECT_BASE: self._connect,
            SET_V_AND_GET_DEADRECKON: self._set_velocity,
        }

    def alive(self, tick: int) -> bool:
        """Whether a good 0xF8 frame came within the core timeout: at 1000 ms it still drives, at 1001 ms it is dead."""
        return self._life_tick is not None and tick - self._life_tick <= self._core_timeout_ticks

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
            if not self.alive(tick):
                # The core is back from silence. Until it says so again, what it wanted before must not move the robot.
                self.wanted_twist = ZERO_TWIST
            self._life_tick = tick
            try:
                return encode_frame(OK, self._carry_out(frame.payload))
            except _Refused as refused:
                return self._error(refused.code)
        if frame.code in (SYNC, ECHO):
            return encode_frame(frame.code, frame.payload, frame.type)
        return self._error(NOT_SUPPORTED)

    def _carry_out(self, payload: bytes) -> bytes:
        if not payload:
            raise _Refused(BAD_FORMAT)
        sub_command = payload[0]
        self.requests[sub_command] = self.requests.get(sub_command, 0) + 1
        handler = self._handlers.get(sub_command)
        if handler is None:
            raise _Refused(NOT_SUPPORTED)
        if len(payload) - 1 != SUB_COMMANDS[sub_command].request_bytes:
            raise _Refused(BAD_FORMAT)
        return handler(payload[1:])

    def _error(self, code: int) -> bytes:
        self.errors[code] = self.errors.get(code, 0) + 1
        return encode_frame(ERROR, error_answer(code))

    def _connect(self, fields: bytes) -> bytes:
        if fields[0] != PROTOCOL_VERSION:
            raise _Refused(NOT_SUPPORTED)
        self.connected = True
        return self._identity_answer

    def _set_velocity(self, fields: bytes) -> bytes:
        increment = self._take_increment()
        self.wanted_twist = twist_from_request(fields)
        if not self._has_reported_motion:
            # The first answer after boot is zero and throws earlier motion away. A new handshake does not repeat that.
            self._has_reported_motion = True
            increment = (0.0, 0.0, 0.0)
        return dead_reckon_answer(*increment)
