"""i-BUS, FlySky's servo output: 115200 baud, 8N1, not inverted, 32 bytes, a weak checksum.

    byte  0   1    2 ... 29                       30 31
          20  40   14 words, low byte first       FFFF minus the sum of bytes 0 to 29, low byte first

The lower 12 bits of a word are the channel, in microseconds. What the upper four say is a matter of the transmitter:

* a failsafe mark: 0xC in the words of those channels for which a failsafe is set up (the usual reading here);
* four more channels, 14 to 17, built of three words' nibbles each, lowest first (`eighteen=True`).

Most receivers repeat the last frame for ever when the radio goes, and nothing tells. On the sensor pin the receiver
polls with frames of 4 bytes, `04`, command, checksum: they are no channels, and no noise. The checksum decides.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence

from bench.messages import RcEvent, RcFrame, RcOther
from bench.rc.framing import Decoder, check_channels

_START = re.compile(rb"\x20(?:\x40|\Z)|\x04(?:[\x80-\xaf]|\Z)")
_HEADER = b"\x20\x40"
_LENGTH, _POLL_LENGTH = 32, 4
_WORDS = struct.Struct("<14H")
LIMITS = ((0, 4095),) * 14
_MARK = 0xC
# A named tuple's own constructor costs twice as much; this one makes the same value.
_new_frame = tuple.__new__


class IbusDecoder(Decoder):
    """i-BUS bytes to frames of 14 channels, or 18. Reasons of noise: header, checksum, cut."""

    byte_us = 10 / 115_200 * 1e6

    def __init__(self, pause_us: float | None = None, eighteen: bool = False) -> None:
        super().__init__(pause_us)
        self._eighteen = eighteen

    def _scan(self, buf: bytes, closed: bool, out: list[RcEvent]) -> int:
        base, size, at = self._offset, len(buf), 0
        while at < size:
            match = _START.match(buf, at)
            if match is None:
                match = _START.search(buf, at)
                found = match.start() if match else size
                self._refuse(base + at, base + found, "header", out)
                at = found
                continue
            length = _LENGTH if buf[at] == 0x20 else _POLL_LENGTH
            end = at + length
            if end > size:
                if not closed:
                    return at
                reason = "cut"
            elif sum(buf[at : end - 2]) + buf[end - 2] + (buf[end - 1] << 8) != 0xFFFF:
                reason = "checksum"
            else:
                if self._noise_length:
                    self._end_noise(out)
                if length == _LENGTH:
                    self._accept(base + at, _WORDS.unpack_from(buf, at + 2), out)
                else:
                    out.append(RcOther(base + at, length, f"poll 0x{buf[at + 1]:02x}"))
                    self.counters.others += 1
                at = end
                continue
            self._refuse(base + at, base + at + 1, reason, out)
            at += 1
        return at

    def _accept(self, offset: int, words: tuple[int, ...], out: list[RcEvent]) -> None:
        failsafe = False
        if self._eighteen:
            nibbles = [word >> 12 for word in words]
            more = [nibbles[i] | nibbles[i + 1] << 4 | nibbles[i + 2] << 8 for i in (0, 3, 6, 9)]
            words = (*(word & 0xFFF for word in words), *more)
        elif max(words) > 0xFFF:
            failsafe = any(word >> 12 == _MARK for word in words)
            words = tuple(word & 0xFFF for word in words)
        out.append(_new_frame(RcFrame, (offset, _LENGTH, words, failsafe, False, ())))
        self.counters.frames += 1
        self.counters.failsafe += failsafe


def encode(channels: Sequence[int], failsafe: bool = False) -> bytes:
    """One frame from 14 channels (0 to 4095); `failsafe` marks them all. Raises ValueError outside of that."""
    check_channels("ibus", channels, LIMITS)
    mark = _MARK << 12 if failsafe else 0
    body = _HEADER + _WORDS.pack(*(raw | mark for raw in channels))
    return body + (0xFFFF - sum(body)).to_bytes(2, "little")
