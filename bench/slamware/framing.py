"""Inter-chip frames of the SLAMWARE control bus: bytes <-> frames, incremental, no port, no clock.

    standard   10 | length, 1 byte  | code | payload, 0 to 254 bytes   | checksum
    long       50 | length, 2 bytes | code | payload, 0 to 65534 bytes | checksum

`length` counts the code byte and the payload, low byte first; `checksum` is the XOR of every byte before it, so that
the XOR over a whole good frame is 0. Source: SLAMTEC's base reference
firmware of 2018-11-20, read and executed, and the vendor's wiki.

A damaged stream can be read in two ways, and both are right somewhere:

    rescan=True    refuse one byte and look again from the next. No good frame is ever missed, wherever it starts. For a
                   core that reads answers and for `wheelbench decode`. Refused bytes are reported as one count before
                   the next good frame (or by `finish`), with the reason of the first refusal.
    rescan=False   refuse what was announced, whole and at once. Nothing inside a damaged frame can be taken for a
                   request, and every fault is reported when its byte arrives. For a base, which must answer it.

Reasons of refusal: "flag" (a byte that starts no frame), "length" (length 0), "checksum", "oversize" (longer than this
receiver takes), "stalled" (the rest did not come within 100 ms, or before the end).
"""

from __future__ import annotations

import re
from typing import NamedTuple, TypeAlias

from bench.messages import TICK_US

STANDARD, LONG = "standard", "long"
STANDARD_FLAG, LONG_FLAG = 0x10, 0x50
STANDARD_MAX_PAYLOAD, LONG_MAX_PAYLOAD = 254, 65534

SYNC, ECHO, OK, ERROR, CONTROL_BUS, INVALID = 0x00, 0x01, 0x02, 0x03, 0xF8, 0xFF
"""Codes. SYNC and ECHO both ways, CONTROL_BUS in requests, the rest in answers (INVALID: defined, but never seen)."""

IDLE_TICKS = 100_000 // TICK_US
"""A partial frame is dropped after 100 ms without a byte; less would cut what serial adapters deliver in bursts."""

DEFAULT_MAX_BYTES = 1024
"""Longest frame that is waited for: the buffer of the vendor's master driver, twice that of the reference base."""

_FLAG_BYTE = re.compile(rb"[\x10\x50]")


class SlamwareFrame(NamedTuple):
    """One frame with a good checksum."""

    offset: int
    """Bytes from the start of the stream to the flag byte."""
    length: int
    """Bytes of the whole frame, flag to checksum."""
    type: str
    """"standard" or "long"."""
    code: int
    """Command of a request, status of an answer."""
    payload: bytes


class SlamwareNoise(NamedTuple):
    """Bytes that are no frame: a count and the reason of the first refusal, never an exception."""

    offset: int
    length: int
    """Bytes refused; for an oversize frame that is refused whole, what it announced."""
    reason: str


SlamwareEvent: TypeAlias = SlamwareFrame | SlamwareNoise


class FrameDecoder:
    """Finds frames in a byte stream. What it reports does not depend on how reads cut the stream.

    Holds fewer than `max_bytes` bytes (at least 258, the longest standard frame) between two calls, for ever.
    """

    __slots__ = ("_at", "_last_tick", "_max_bytes", "_noise", "_rescan", "_rest", "_skip")

    def __init__(self, *, rescan: bool = True, max_bytes: int = DEFAULT_MAX_BYTES) -> None:
        self._rescan = rescan
        self._max_bytes = max_bytes
        self._rest = b""
        self._at = 0  # stream offset of the first byte of _rest
        self._skip = 0  # bytes still to come of an oversize frame that was refused whole
        self._noise: SlamwareNoise | None = None
        self._last_tick: int | None = None

    def feed(self, data: bytes, now_tick: int | None = None) -> list[SlamwareEvent]:
        """Frames and refusals that these bytes complete, in stream order. Without a time nothing ever stalls."""
        if not data:
            return []
        last_tick, self._last_tick = self._last_tick, now_tick
        if last_tick is not None and now_tick is not None and now_tick - last_tick >= IDLE_TICKS:
            events = self.finish()
        else:
            events = []
        if self._skip:
            skipped = min(self._skip, len(data))
            self._skip -= skipped
            self._at += skipped
            data = data[skipped:]
        self._scan(self._rest + data, events, at_end=False)
        return events

    def finish(self) -> list[SlamwareEvent]:
        """What is left at the end of a stream: refused bytes not yet reported, and a frame whose rest never came."""
        events: list[SlamwareEvent] = []
        self._skip = 0
        self._scan(self._rest, events, at_end=True)
        self._report_noise(events)
        return events

    def _scan(self, data: bytes, events: list[SlamwareEvent], *, at_end: bool) -> None:
        at, end = 0, len(data)
        while at < end:
            size, reason = _judge(data, at, self._max_bytes)
            if size == 0:
                if not at_end:
                    break
                size, reason = end - at, "stalled"
            if not reason:
                self._report_noise(events)
                header = 2 if data[at] == STANDARD_FLAG else 3
                events.append(
                    SlamwareFrame(
                        self._at + at,
                        size,
                        STANDARD if header == 2 else LONG,
                        data[at + header],
                        data[at + header + 1 : at + size - 1],
                    )
                )
                at += size
            elif self._rescan:
                found = _FLAG_BYTE.search(data, at + 1)
                after = found.start() if found else end
                self._add_noise(self._at + at, after - at, reason)
                at = after
            else:
                events.append(SlamwareNoise(self._at + at, size, reason))
                at += size
        if at > end:
            self._skip = at - end
            at = end
        self._rest = data[at:]
        self._at += at

    def _add_noise(self, offset: int, length: int, reason: str) -> None:
        noise = self._noise
        if noise is None:
            self._noise = SlamwareNoise(offset, length, reason)
        else:
            self._noise = SlamwareNoise(noise.offset, noise.length + length, noise.reason)

    def _report_noise(self, events: list[SlamwareEvent]) -> None:
        if self._noise is not None:
            events.append(self._noise)
            self._noise = None


def encode_frame(code: int, payload: bytes = b"", type: str = LONG) -> bytes:
    """The bytes of one frame. Raises ValueError with the limits where it cannot be built."""
    if not 0 <= code <= 0xFF:
        raise ValueError(f"code {code} outside 0..255")
    length = len(payload) + 1
    if type == STANDARD:
        if length > STANDARD_MAX_PAYLOAD + 1:
            raise ValueError(f"payload of {len(payload)} bytes; a standard frame takes 0..{STANDARD_MAX_PAYLOAD}")
        body = bytes((STANDARD_FLAG, length, code)) + payload
    elif type == LONG:
        if length > LONG_MAX_PAYLOAD + 1:
            raise ValueError(f"payload of {len(payload)} bytes; a long frame takes 0..{LONG_MAX_PAYLOAD}")
        body = bytes((LONG_FLAG, length & 0xFF, length >> 8, code)) + payload
    else:
        raise ValueError(f"frame type {type!r}; known: {STANDARD}, {LONG}")
    return body + bytes((xor_of(body),))


def xor_of(data: bytes) -> int:
    """XOR of all bytes: the bytes as one number, folded in halves (1 kB costs 5 times 17 bytes, not 60 times)."""
    folded = int.from_bytes(data, "little")
    bits = 4 << len(data).bit_length()
    while bits >= 8:
        folded ^= folded >> bits
        bits >>= 1
    return folded & 0xFF


def _judge(data: bytes, at: int, max_bytes: int) -> tuple[int, str]:
    """Size and fault of the frame that starts at `at`: (0, "") while bytes are missing, (size, "") where it is good."""
    have = len(data) - at
    flag = data[at]
    if flag == STANDARD_FLAG:
        if have < 2:
            return 0, ""
        length = data[at + 1]
        size = length + 3
    elif flag == LONG_FLAG:
        if have < 3:
            return 0, ""
        length = data[at + 1] | data[at + 2] << 8
        size = length + 4
    else:
        return 1, "flag"
    if size > max_bytes:
        return size, "oversize"
    if have < size:
        return 0, ""
    if xor_of(data[at : at + size]):
        return size, "checksum"
    # Length 0 is well framed but has no code. The reference base runs the previous command again; nobody should.
    return size, "" if length else "length"
