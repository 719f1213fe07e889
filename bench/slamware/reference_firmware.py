"""The vendor's base as it really behaves, its defects included: what a core must survive, and what nobody should copy.

Set against `base_side` (every difference was seen in SLAMTEC's base reference firmware of 2018-11-20, executed):

    no timeout         a frame that was cut stays open for ever and eats the next ones until its length is satisfied
    stray bytes        each one is answered, 0x0010
    bad checksum       0x00C0: its own bit 0x80, "a frame is complete", stays in the code
    oversize           seen when the first byte of the body comes; the rest of the frame counts as stray bytes
    length 0           the byte in the code's place is taken as the checksum, and the code left over from the previous
                       frame is executed; right after boot that is a SYNC
    payload sizes      are never looked at: missing bytes are those of earlier frames, further ones are left alone
    ECHO of 508 bytes  comes back with a wrong checksum: the 512 bytes of the answer's buffer have no room for it
    busy sending       faults and frames that arrive meanwhile are merged, or overwritten (`bytes_per_look`)
    0x41               worked out in single precision: long ways move in steps, too long ones overflow to -2^31

A fault wins over a frame that completes in the same look: that request is lost.
"""

from __future__ import annotations

import math
import struct

from bench.slamware.answers import Refused
from bench.slamware.base_side import SlamwareBase
from bench.slamware.commands import BAD_CHECKSUM, NOT_SUPPORTED, NOT_SYNCHRONISED, SUB_COMMANDS, TOO_LONG
from bench.slamware.facts import BaseFacts
from bench.slamware.framing import CONTROL_BUS, ECHO, LONG_FLAG, OK, STANDARD_FLAG, SYNC, encode_frame, xor_of
from bench.slamware.payloads import Q16, Displacement, dead_reckon_answer
from bench.slamware.senses import Motion, Senses

BUFFER_BYTES = 512
FRAME_PENDING = 0x80
_RAW = struct.Struct("<3i")
_SINGLE = struct.Struct("f")
_FAULTS = NOT_SYNCHRONISED | TOO_LONG | BAD_CHECKSUM


class ReferenceReceiver:
    """Bytes in, a state of fault bits out; the frame itself stays in a buffer that nobody ever clears."""

    def __init__(self) -> None:
        self.state = 0
        """Faults and FRAME_PENDING since the last look."""
        self.buffer = bytearray(BUFFER_BYTES)
        """The last frame from its flag on, without its checksum; behind it, what earlier ones left."""
        self._received = 0
        """Bytes of the open frame; 0 between frames."""
        self._end = 0
        """Where its checksum stands."""
        self._checksum = 0

    def put(self, byte: int) -> None:
        """Take one byte from the line."""
        at = self._received
        if at == 0 and byte not in (STANDARD_FLAG, LONG_FLAG):
            self.state |= NOT_SYNCHRONISED
            return
        head = self.code_at
        if at == head and self._is_too_long():
            self.state |= TOO_LONG
            self._received = 0
            return
        if at >= head and at == self._end:
            self.state |= FRAME_PENDING if byte == self._checksum else FRAME_PENDING | BAD_CHECKSUM
            self._received = 0
            return
        self.buffer[at] = byte
        self._checksum = byte if at == 0 else self._checksum ^ byte
        self._received = at + 1
        if at + 1 == self.code_at:
            self._end = self.code_at + self.length

    def look(self) -> int:
        """The state, which starts anew; a pending frame is not protected from the bytes that follow."""
        state, self.state = self.state, 0
        return state

    @property
    def code_at(self) -> int:
        """Where the code of the frame in the buffer stands."""
        return 3 if self.buffer[0] == LONG_FLAG else 2

    @property
    def length(self) -> int:
        """The length field of the frame in the buffer: code and payload."""
        return self.buffer[1] | self.buffer[2] << 8 if self.code_at == 3 else self.buffer[1]

    def _is_too_long(self) -> bool:
        return self.code_at + self.length > BUFFER_BYTES


class ReferenceFirmware(SlamwareBase):
    """A slave with the vendor's receiver and the vendor's trust in what it receives.

    Its main loop looks at the receiver after every `bytes_per_look` bytes and at the end of every read. 1 is the real
    one as long as no answer is under way; more shows what is merged and lost while one is.
    """

    def __init__(
        self,
        facts: BaseFacts,
        motion: Motion,
        senses: Senses | None = None,
        core_timeout_ms: int = 1000,
        *,
        bytes_per_look: int = 1,
    ) -> None:
        super().__init__(facts, motion, senses, core_timeout_ms)
        if bytes_per_look < 1:
            raise ValueError(f"bytes_per_look {bytes_per_look} is less than 1")
        self._receiver = ReferenceReceiver()
        self._bytes_per_look = bytes_per_look

    def receive(self, data: bytes, tick: int) -> bytes:
        """Answers to what these bytes complete, in order."""
        receiver, answers = self._receiver, []
        for number, byte in enumerate(data, 1):
            receiver.put(byte)
            if receiver.state and (number % self._bytes_per_look == 0 or number == len(data)):
                state = receiver.look()
                answers.append(self._error(state) if state & _FAULTS else self._serve(tick))
        return b"".join(answers)

    def _serve(self, tick: int) -> bytes:
        buffer, code_at = self._receiver.buffer, self._receiver.code_at
        code = buffer[code_at]
        if code in (SYNC, ECHO):
            return self._copy(bytes(buffer[: code_at + self._receiver.length]))
        if code != CONTROL_BUS:
            return self._error(NOT_SUPPORTED)
        self._live(tick)
        # Whatever the frame's length said: a sub-command and all of its fields are read, new bytes or old ones.
        sub_command = buffer[code_at + 1]
        self.requests[sub_command] = self.requests.get(sub_command, 0) + 1
        known = SUB_COMMANDS.get(sub_command)
        size = max(known.request_bytes) if known else 0
        try:
            return encode_frame(OK, self.carry_out(sub_command, bytes(buffer[code_at + 2 : code_at + 2 + size]), tick))
        except Refused as refused:
            return self._error(refused.code)

    def _dead_reckoned(self, increment: Displacement, uptime_ms: int | None) -> bytes:
        dx_m, dy_m, dtheta_rad = map(single, increment)
        values = (single(dx_m * 1000.0), single(dy_m * 1000.0), single(single(dtheta_rad * 180.0) / single(math.pi)))
        rest = dead_reckon_answer(0.0, 0.0, 0.0, self.motion.status(), uptime_ms)[_RAW.size :]
        return _RAW.pack(*map(_raw_q16, values)) + rest

    def _copy(self, frame: bytes) -> bytes:
        checksum = xor_of(frame)
        if len(frame) == BUFFER_BYTES:
            checksum ^= 0xFF  # whatever stands behind the buffer; that it is wrong is all that is known of it
        return frame + bytes((checksum,))


def _raw_q16(value: float) -> int:
    raw = int(single(value * Q16))
    return raw if -(2**31) <= raw < 2**31 else -(2**31)  # what an x86-64 build of the vendor's C makes of both ways


def single(value: float) -> float:
    """The nearest number that single precision holds."""
    rounded: float = _SINGLE.unpack(_SINGLE.pack(value))[0]
    return rounded
