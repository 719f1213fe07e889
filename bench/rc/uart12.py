"""uart12, the M2006 robot's own frame (document 004): 115200 baud, 8E2, not inverted, 12 bytes, no checksum.

    byte  0     1 2    3 4    5 6    7 8    9     10    11
          AA    ADC1   ADC2   ADC3   ADC4   AUX1  AUX2  55
                ch 0   ch 1   ch 2   ch 3   ch 4  ch 5

The ADC words are big-endian, 0 to 4095 with the middle at 2048; of the buttons only zero and non-zero are safe to tell
apart. No counter and no loss flag: the line can only fall silent.

Header, trailer and four zero nibbles are 32 bits of evidence. With buttons of 0 or 1, as every published frame has
them, it is 46, and the frame is believed at once. Other button values wait for the next header, or for silence.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from bench.messages import RcEvent, RcFrame
from bench.rc.framing import Decoder, check_channels

HEADER, FOOTER = 0xAA, 0x55
_FRAME = struct.Struct(">B4H3B")
_LENGTH = 12
LIMITS = (*((0, 4095),) * 4, *((0, 255),) * 2)
# A named tuple's own constructor costs twice as much; this one makes the same value.
_new_frame = tuple.__new__


class Uart12Decoder(Decoder):
    """uart12 bytes to frames. Reasons of noise: header, footer, range, successor, cut."""

    byte_us = 12 / 115_200 * 1e6

    def _scan(self, buf: bytes, closed: bool, out: list[RcEvent]) -> int:
        base, size, at = self._offset, len(buf), 0
        while at < size:
            if buf[at] != HEADER:
                found = buf.find(HEADER, at)
                found = size if found < 0 else found
                self._refuse(base + at, base + found, "header", out)
                at = found
                continue
            end = at + _LENGTH
            if end > size:
                if not closed:
                    return at
                reason = "cut"
            else:
                _, a, b, c, d, aux1, aux2, footer = _FRAME.unpack_from(buf, at)
                if footer != FOOTER:
                    reason = "footer"
                elif (a | b | c | d) > 4095:
                    reason = "range"
                else:
                    if (aux1 | aux2) > 1:
                        if end == size and not closed:
                            return at
                        if end < size and buf[end] != HEADER:
                            self._refuse(base + at, base + at + 1, "successor", out)
                            at += 1
                            continue
                    if self._noise_length:
                        self._end_noise(out)
                    channels = (a, b, c, d, aux1, aux2)
                    out.append(_new_frame(RcFrame, (base + at, _LENGTH, channels, False, False, ())))
                    self.counters.frames += 1
                    at = end
                    continue
            # No checksum: 0xAA is also legal stick data, so go on at the very next byte.
            self._refuse(base + at, base + at + 1, reason, out)
            at += 1
        return at


def encode(channels: Sequence[int]) -> bytes:
    """One frame from four sticks (0 to 4095) and two buttons (0 to 255). Raises ValueError outside of that."""
    check_channels("uart12", channels, LIMITS)
    return _FRAME.pack(HEADER, *channels, FOOTER)
