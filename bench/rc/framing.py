"""What every RC decoder shares: bytes wait for a verdict, silence ends a piece, and noise is a counted event.

A protocol's own file says how a frame looks, nothing here does. The rules that hold for all of them:

* A refused candidate costs its first byte only; the search goes on at the second one.
* The events are a function of the bytes (and of the pauses, where times are given), never of how reads cut the stream.
* Times are used when they exist and never required: a pause longer than `pause_us` ends what came before it, exactly
  as the end of a file does.
* Whatever arrives, for however long, the decoder keeps at most a few frame lengths, and reports noise every
  `NOISE_RUN_BYTES` at the latest.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from bench.messages import RcEvent, RcNoise

NOISE_RUN_BYTES = 1024
"""A longer run of noise is reported in pieces of this many bytes: 0.1 s of a 115200 baud line."""

PAUSE_BYTES = 5
"""A silence longer than this many byte times ends a frame (PX4, Betaflight and ArduPilot use 4 to 30 of them)."""

ELEVEN_BIT_LIMITS = ((0, 2047),) * 16
"""Lowest and highest raw value of the sixteen channels of SBUS and CRSF."""

_NUMBER = (int, float)  # as a tuple: `int | float` would be made anew in every feed


@dataclass(slots=True)
class Counters:
    """What a decoder has seen so far. The reasons are a closed set per protocol, so this cannot grow."""

    frames: int = 0
    failsafe: int = 0
    """Frames with the failsafe flag; they count as frames too."""
    frame_lost: int = 0
    """Frames with the frame-lost flag; they count as frames too."""
    link_statistics: int = 0
    others: int = 0
    noise_events: dict[str, int] = field(default_factory=dict)
    """Runs of noise by the reason of their first refusal."""
    noise_bytes: dict[str, int] = field(default_factory=dict)


class Decoder(ABC):
    """Finds the frames of one protocol in a byte stream. No port, no clock, no logging; never raises on bytes.

    `pause_us` is the silence that ends a frame, by default five byte times. Give more where times are coarse: the bench
    stamps bytes with 1 ms ticks and passes 2000.
    """

    byte_us: ClassVar[float]
    """How long one byte takes on the line at the protocol's usual speed, start, parity and stop bits included."""

    def __init__(self, pause_us: float | None = None) -> None:
        if pause_us is None:
            pause_us = PAUSE_BYTES * self.byte_us
        if not pause_us > 0:
            raise ValueError(f"pause_us is {pause_us}; expected more than 0")
        self.pause_us = pause_us
        self.counters = Counters()
        self._waiting = b""
        self._offset = 0  # of the first waiting byte, from the start of the stream
        self._last_us: float | None = None
        self._noise_start = 0
        self._noise_length = 0
        self._noise_reason = ""

    def feed(self, data: bytes, at_us: int | float | Sequence[int | float] | None = None) -> list[RcEvent]:
        """Take bytes as they come, in any pieces, and return what they complete, in stream order.

        `at_us` is when the whole piece had arrived, or one time for each byte, or None where nothing is known.
        Without bytes, a time lets silence speak: a frame that only waits for its successor is accepted. Raises
        ValueError where times and bytes differ in number.
        """
        out: list[RcEvent] = []
        if at_us is None:
            if data:
                self._last_us = None
                self._push(data, out)
        elif isinstance(at_us, _NUMBER):
            last_us = self._last_us
            if last_us is not None:
                gap_us = at_us - last_us
                if data:
                    # The first byte of a piece came earlier than its last one, which is the one that has a time.
                    gap_us -= self.byte_us * (len(data) - 1)
                if gap_us > self.pause_us:
                    self._end(out)
            if data:
                self._last_us = at_us
                self._push(data, out)
        else:
            self._push_timed(data, at_us, out)
        return out

    def finish(self) -> list[RcEvent]:
        """The stream ends here: decide everything that still waits. Later bytes count as coming after a pause."""
        out: list[RcEvent] = []
        self._end(out)
        return out

    @property
    def pending(self) -> bool:
        """Whether anything waits for more bytes or for silence; if not, a feed without bytes changes nothing."""
        return bool(self._waiting) or self._noise_length > 0

    @abstractmethod
    def _scan(self, buf: bytes, closed: bool, out: list[RcEvent]) -> int:
        """Judge `buf`, which starts at stream offset `self._offset`, and return how many bytes are settled.

        `closed` says that silence follows the last byte; then all of them must be settled.
        """

    def _push(self, data: bytes, out: list[RcEvent]) -> None:
        buf = self._waiting + data if self._waiting else bytes(data)
        used = self._scan(buf, False, out)
        self._waiting = buf[used:]
        self._offset += used

    def _push_timed(self, data: bytes, times_us: Sequence[int | float], out: list[RcEvent]) -> None:
        if len(times_us) != len(data):
            raise ValueError(f"{len(times_us)} times for {len(data)} bytes; expected one time a byte")
        start, last_us = 0, self._last_us
        for i, at_us in enumerate(times_us):
            if last_us is not None and at_us - last_us > self.pause_us:
                self._push(data[start:i], out)
                self._end(out)
                start = i
            last_us = at_us
        self._push(data[start:], out)
        self._last_us = last_us

    def _end(self, out: list[RcEvent]) -> None:
        if self._waiting:
            self._offset += self._scan(self._waiting, True, out)
            self._waiting = b""
        if self._noise_length:
            self._end_noise(out)

    def _refuse(self, start: int, end: int, reason: str, out: list[RcEvent]) -> None:
        """Bytes `start` to `end` (stream offsets, following on from the last ones settled) are noise."""
        if not self._noise_length:
            self._noise_start, self._noise_reason = start, reason
        self._noise_length = end - self._noise_start
        while self._noise_length >= NOISE_RUN_BYTES:
            rest = self._noise_length - NOISE_RUN_BYTES
            self._noise_length = NOISE_RUN_BYTES
            self._end_noise(out)
            self._noise_start, self._noise_length, self._noise_reason = end - rest, rest, reason

    def _end_noise(self, out: list[RcEvent]) -> None:
        """Report the run of noise. Protocols call it before every frame, so that events stay in stream order."""
        length, reason = self._noise_length, self._noise_reason
        out.append(RcNoise(self._noise_start, length, reason))
        counters = self.counters
        counters.noise_events[reason] = counters.noise_events.get(reason, 0) + 1
        counters.noise_bytes[reason] = counters.noise_bytes.get(reason, 0) + length
        self._noise_length = 0


def check_channels(protocol: str, channels: Sequence[int], limits: Sequence[tuple[int, int]]) -> None:
    """Raise ValueError unless there is one whole number for each of the `limits`, and between them."""
    if len(channels) != len(limits):
        raise ValueError(f"{protocol}: {len(channels)} channels; expected {len(limits)}")
    for i, (raw, (low, high)) in enumerate(zip(channels, limits, strict=True)):
        if not low <= raw <= high:
            raise ValueError(f"{protocol}: channel {i} is {raw}; expected {low} to {high}")


def unpack_channels(packed: bytes) -> tuple[int, ...]:
    """22 bytes to 16 channels of 11 bits, lowest bits first: the packing of SBUS and CRSF."""
    # One big number and sixteen shifts: the fastest of seven ways that were measured (CPython 3.11).
    n = int.from_bytes(packed, "little")
    return (
        n & 2047,
        n >> 11 & 2047,
        n >> 22 & 2047,
        n >> 33 & 2047,
        n >> 44 & 2047,
        n >> 55 & 2047,
        n >> 66 & 2047,
        n >> 77 & 2047,
        n >> 88 & 2047,
        n >> 99 & 2047,
        n >> 110 & 2047,
        n >> 121 & 2047,
        n >> 132 & 2047,
        n >> 143 & 2047,
        n >> 154 & 2047,
        n >> 165 & 2047,
    )


def pack_channels(protocol: str, channels: Sequence[int]) -> bytes:
    """16 channels of 11 bits to 22 bytes. Raises ValueError outside of 0 to 2047, or on another count."""
    packed = seen = 0
    for raw in reversed(channels):
        packed = packed << 11 | raw
        seen |= raw
    # One look at all bits together; only what is wrong is looked at again, to say what.
    if len(channels) != 16 or not 0 <= seen <= 2047:
        check_channels(protocol, channels, ELEVEN_BIT_LIMITS)
    return packed.to_bytes(22, "little")
