"""DBUS: DJI DR16 receiver, DT7 transmitter, RoboMaster. 100000 baud, 8E1, inverted on the wire, 18 bytes, no checksum.

    bits  0-10   11-21   22-32   33-43   44-45      46-47      bytes 6 ... 11    12, 13          14 15   16 17
          ch 0   ch 1    ch 2    ch 3    switch A   switch B   mouse x, y, z     mouse buttons   keys    wheel
          sticks, 364 to 1024 to 1684    1 up, 3 middle, 2 down

Thirteen values, in this order; mouse words are signed, everything is low byte first. There is no header, no trailer and
no flag: only silence and plausibility can align the frames. With times, what lies between two pauses is a frame if it
is 18 plausible bytes. Without them

* the first frame is believed where three plausible ones follow each other;
* from then on a plausible frame is believed where the last one ended, if another follows it, or if no two in a row
  begin inside it;
* of two places within one frame that all this allows, that one is taken whose sticks are nearer to those of the last
  frame (to the middle, if there was none).

That aligns, but it cannot tell a frame that lost a byte at rest from a good one: give times where there are any.

A transmitter that is off makes frames of zeros. Switches are never 0, so they are noise, and the link falls silent.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from bench.messages import RcEvent, RcFrame
from bench.rc.framing import Decoder, check_channels

_LENGTH = 18
_FIELDS, _REST = struct.Struct("<3H3h2B2H"), struct.Struct("<3h2B2H")
_LOW, _MIDDLE, _HIGH = 364, 1024, 1684
LIMITS = (
    *((_LOW, _HIGH),) * 4,
    *((1, 3),) * 2,
    *((-32768, 32767),) * 3,
    *((0, 1),) * 2,
    (0, 65535),
    (0, 2047),
)
# A named tuple's own constructor costs twice as much; this one makes the same value.
_new_frame = tuple.__new__


class DbusDecoder(Decoder):
    """DBUS bytes to frames. Reasons of noise: range (not plausible), successor, cut."""

    byte_us = 11 / 100_000 * 1e6

    def __init__(self, pause_us: float | None = None) -> None:
        super().__init__(pause_us)
        # Stream offsets at which a frame should begin: after silence (the beginning counts as such), after a frame.
        self._silence_at = 0
        self._frame_end = -1
        self._sticks: tuple[int, ...] = (_MIDDLE, _MIDDLE, _MIDDLE, _MIDDLE)

    def _end(self, out: list[RcEvent]) -> None:
        super()._end(out)
        self._silence_at = self._offset

    def _scan(self, buf: bytes, closed: bool, out: list[RcEvent]) -> int:
        base, size, at = self._offset, len(buf), 0
        while at < size:
            end = at + _LENGTH
            if end > size:
                if not closed:
                    return at
                reason = "cut"
            elif (values := _values(buf, at)) is None:
                reason = "range"
            else:
                believed = self._believed(buf, at, closed)
                if believed is None:
                    return at
                if believed:
                    if self._noise_length:
                        self._end_noise(out)
                    out.append(_new_frame(RcFrame, (base + at, _LENGTH, values, False, False, ())))
                    self.counters.frames += 1
                    self._frame_end = base + end
                    self._sticks = values[:4]
                    at = end
                    continue
                reason = "successor"
            self._refuse(base + at, base + at + 1, reason, out)
            at += 1
        return at

    def _believed(self, buf: bytes, at: int, closed: bool) -> bool | None:
        """Whether a plausible frame at `at` is one; None while that is not known."""
        offset, end, size = self._offset + at, at + _LENGTH, len(buf)
        if end == size and closed:
            return True
        if offset == self._silence_at and closed and size < end + _LENGTH:
            return False  # a burst of 19 to 35 bytes: some have come from nowhere, or are gone
        followed = _values(buf, end) is not None
        expected = offset in (self._silence_at, self._frame_end)
        if expected and followed:
            return True
        row = 2 if expected else 3
        if not closed and size < end + row * _LENGTH - 1:
            return None
        if not expected and not _row(buf, at, 3) and not (closed and followed and size < at + 3 * _LENGTH):
            return False
        distance = self._distance(buf, at)
        rivals = range(at + 1, end)
        return not any(_row(buf, rival, row) and self._distance(buf, rival) < distance for rival in rivals)

    def _distance(self, buf: bytes, at: int) -> int:
        """How far the sticks of a plausible frame have moved since the last one, all four together."""
        return sum(abs(raw - last) for raw, last in zip(_values(buf, at) or (), self._sticks, strict=False))


def _values(buf: bytes, at: int) -> tuple[int, ...] | None:
    """The thirteen values of the 18 bytes at `at`; None where they cannot be a frame, or are not there."""
    if at + _LENGTH > len(buf):
        return None
    low, middle, high, x, y, z, left, right, keys, wheel = _FIELDS.unpack_from(buf, at)
    if left > 1 or right > 1 or wheel > 2047:
        return None
    packed = low | middle << 16 | high << 32
    a, b, c, d = packed & 2047, packed >> 11 & 2047, packed >> 22 & 2047, packed >> 33 & 2047
    switch_a, switch_b = packed >> 44 & 3, packed >> 46
    if not (switch_a and switch_b) or min(a, b, c, d) < _LOW or max(a, b, c, d) > _HIGH:
        return None
    return a, b, c, d, switch_a, switch_b, x, y, z, left, right, keys, wheel


def _row(buf: bytes, at: int, count: int) -> bool:
    """Whether `count` plausible frames follow each other from `at` on."""
    return all(_values(buf, at + k * _LENGTH) is not None for k in range(count))


def encode(channels: Sequence[int]) -> bytes:
    """One frame from its thirteen values. Raises ValueError for what no transmitter sends."""
    check_channels("dbus", channels, LIMITS)
    packed = 0
    for i, raw in enumerate(channels[:5]):  # the first switch begins where a fifth stick would
        packed |= raw << 11 * i
    packed |= channels[5] << 46
    return packed.to_bytes(6, "little") + _REST.pack(*channels[6:])
