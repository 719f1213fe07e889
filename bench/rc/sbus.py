"""SBUS and SBUS2 (Futaba, and most other makers): 100000 baud, 8E2, inverted on the wire, 25 bytes, no checksum.

    byte  0     1 ... 22                             23      24
          0F    16 channels x 11 bit, lowest first   flags   footer
                                                     |       00 SBUS; 04 14 24 34 SBUS2, by telemetry slot group
                                                     bit 0, 1 digital channels 16 and 17; bit 2 frame lost;
                                                     bit 3 failsafe; bits 4-7 undefined (a DJI Lightbridge 2 sends 5)

After an SBUS2 frame up to eight sensors answer on the same wire, 3 bytes each: slot number with its bits reversed
(03 83 43 C3 23 ...: the low three bits are always 011), then two bytes of data. They are no frames, and no noise.

The middle of most transmitters, 992, puts a 0F *inside* the payload, so header and footer alone lock on wrong places.
A frame must also be followed by the next header, by silence, by answers that lead to one of these, or by a frame that
has lost nothing but its header (its footer and the header after that stand where they belong).

Where bytes were lost or added, two overlapping places can look like a frame: one that begins where the last frame ended
(but nothing follows it), and one that ends where the next begins. The latter is believed only if its channels are by
far the closer ones to those of the last frame.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench.messages import RcEvent, RcFrame, RcOther
from bench.rc.framing import Decoder, pack_channels, unpack_channels

HEADER = 0x0F
FOOTERS = frozenset((0x00, 0x04, 0x14, 0x24, 0x34))
FRAME_LOST, FAILSAFE = 0x04, 0x08
_DIGITAL = ((False, False), (True, False), (False, True), (True, True))
_LENGTH = 25
_ANSWERS, _ANSWER_LENGTH = 8, 3
# Of two places that overlap, a shifted one moves most channels by hundreds of counts, the true one a few by tens.
_FAR_CLOSER = 8
# A named tuple's own constructor costs twice as much; this one makes the same value.
_new_frame = tuple.__new__


class SbusDecoder(Decoder):
    """SBUS and SBUS2 bytes to frames. Reasons of noise: header, footer, successor, cut."""

    byte_us = 12 / 100_000 * 1e6

    def __init__(self, pause_us: float | None = None) -> None:
        super().__init__(pause_us)
        # All of these are stream offsets.
        self._expected_at = -1  # the end of the last frame
        self._answer_at = -1  # where a sensor may answer
        self._answers_left = 0
        self._rival_end = -1  # a candidate at `_expected_at` that nothing follows ends here
        self._rival_distance = 0
        self._last_channels: tuple[int, ...] = ()

    def _scan(self, buf: bytes, closed: bool, out: list[RcEvent]) -> int:
        base, size, at = self._offset, len(buf), 0
        while at < size:
            if buf[at] == HEADER:
                end = at + _LENGTH
                if end > size:
                    if not closed:
                        return at
                    reason = "cut"
                elif (footer := buf[end - 1]) not in FOOTERS:
                    reason = "footer"
                else:
                    believed: bool | None = True
                    # The usual case first; everything else that may follow a frame is rare.
                    if end == size or buf[end] != HEADER:
                        believed = _followed(buf, end, footer, closed)
                        if believed is None:
                            return at
                    channels = unpack_channels(buf[at + 1 : at + 23])
                    # What overlaps a candidate must be by far the closer one.
                    if believed and (
                        base + at >= self._rival_end or self._distance(channels) * _FAR_CLOSER <= self._rival_distance
                    ):
                        if self._noise_length:
                            self._end_noise(out)
                        self._accept(base + at, channels, buf[at + 23], footer, out)
                        at = end
                        continue
                    reason = "successor"
                    if base + at == self._expected_at:
                        self._rival_end, self._rival_distance = base + end, self._distance(channels)
            elif self._answers_left and base + at == self._answer_at and _is_slot(buf[at]):
                answered = _answered(buf, at, closed)
                if answered:
                    out.append(RcOther(base + at, _ANSWER_LENGTH, f"slot {_slot_number(buf[at])}"))
                    self.counters.others += 1
                    at += _ANSWER_LENGTH
                    self._answer_at = base + at
                    self._answers_left -= 1
                    continue
                if answered is None:
                    return at
                reason = "cut"
            else:
                found = buf.find(HEADER, at)
                found = size if found < 0 else found
                self._refuse(base + at, base + found, "header", out)
                at = found
                continue
            # No checksum: 0x0F is also legal stick data, so go on at the very next byte.
            self._refuse(base + at, base + at + 1, reason, out)
            at += 1
        return at

    def _accept(self, offset: int, channels: tuple[int, ...], flags: int, footer: int, out: list[RcEvent]) -> None:
        counters = self.counters
        counters.frames += 1
        digital = _DIGITAL[flags & 3]
        if flags & (FAILSAFE | FRAME_LOST):
            failsafe, frame_lost = flags & FAILSAFE != 0, flags & FRAME_LOST != 0
            counters.failsafe += failsafe
            counters.frame_lost += frame_lost
            out.append(_new_frame(RcFrame, (offset, _LENGTH, channels, failsafe, frame_lost, digital)))
        else:
            out.append(_new_frame(RcFrame, (offset, _LENGTH, channels, False, False, digital)))
        self._expected_at = offset + _LENGTH
        self._last_channels = channels
        if footer:
            self._answer_at, self._answers_left = offset + _LENGTH, _ANSWERS

    def _distance(self, channels: tuple[int, ...]) -> int:
        """How far the sticks would have moved since the last frame: the sum over all channels, in raw counts."""
        return sum(abs(raw - last) for raw, last in zip(channels, self._last_channels, strict=True))


def _followed(buf: bytes, end: int, footer: int, closed: bool) -> bool | None:
    """Whether what stands at `end`, no header, may follow a frame with this footer; None while that is not known."""
    size = len(buf)
    if end == size:
        return True if closed else None
    # A frame without its header: 24 bytes, the last of them a footer, then the header of the frame after it.
    next_end = end + _LENGTH - 1
    unknown = next_end >= size
    if not unknown and buf[next_end] == HEADER and buf[next_end - 1] in FOOTERS:
        return True
    if footer:
        at = end
        for _ in range(_ANSWERS):
            if not _is_slot(buf[at]):
                break
            at += _ANSWER_LENGTH
            if at >= size:
                return True if closed else None
            if buf[at] == HEADER:
                return True
    return None if unknown and not closed else False


def _answered(buf: bytes, at: int, closed: bool) -> bool | None:
    """Whether the bytes at `at` are a sensor's answer: three, and then a header, another answer, or silence."""
    end = at + _ANSWER_LENGTH
    if end < len(buf):
        return buf[end] == HEADER or _is_slot(buf[end])
    if closed:
        return end == len(buf)
    return None


def _is_slot(byte: int) -> bool:
    return byte & 0x07 == 0x03


def _slot_number(byte: int) -> int:
    """03 -> 0, 83 -> 1, 43 -> 2 ...: the upper five bits, reversed."""
    return int(f"{byte >> 3:05b}"[::-1], 2)


def encode(
    channels: Sequence[int],
    failsafe: bool = False,
    frame_lost: bool = False,
    digital: Sequence[bool] = (),
    *,
    upper_flags: int = 0,
    footer: int = 0,
) -> bytes:
    """One frame from 16 channels (0 to 2047). Raises ValueError outside of that.

    `digital` are channels 16 and 17, off where nothing is said; `upper_flags` is the upper half of the flag byte, which
    nobody has defined.
    """
    packed = pack_channels("sbus", channels)
    if len(digital) not in (0, 2):
        raise ValueError(f"sbus: {len(digital)} digital channels; expected 2, or none to leave them off")
    if not 0 <= upper_flags <= 0xF:
        raise ValueError(f"sbus: upper_flags is {upper_flags:#x}; expected 0 to 0xf")
    if footer not in FOOTERS:
        raise ValueError(f"sbus: footer is {footer:#x}; expected one of 0x0, 0x4, 0x14, 0x24, 0x34")
    flags = upper_flags << 4 | (FAILSAFE if failsafe else 0) | (FRAME_LOST if frame_lost else 0)
    for bit, is_on in enumerate(digital):
        flags |= bool(is_on) << bit
    return b"\x0f" + packed + bytes((flags, footer))
