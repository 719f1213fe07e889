"""The text of SLCAN adapters: CAN frames as lines, after the LAWICEL CAN232 manual, version 3. No port, no clock.

    t iii l dd..   standard data frame      \\r ends each line; digits are read in either case
    T iiiiiiii l   extended                 z\\r  Z\\r   the adapter has sent our frame
    r iii l        standard remote          \\r        done
    R iiiiiiii l   extended remote          \\a        refused (BEL, without \\r)

Frames may carry four more digits, the adapter's time stamp. `SlcanReader` takes a stream in blocks of any size and
finds every whole frame in it, whatever stands in front of it: a frame's first letter is no hexadecimal digit, so the
last such letter of a line is where its frame begins.
"""

from __future__ import annotations

from binascii import unhexlify
from functools import cache

from bench.messages import CanFrame

MOST_LINE_BYTES = 64
"""Longer than any line of an adapter: `T`, 8 + 1 + 16 digits, a time stamp."""
BITRATES = {
    10_000: 0, 20_000: 1, 50_000: 2, 100_000: 3, 125_000: 4, 250_000: 5, 500_000: 6, 800_000: 7, 1_000_000: 8,
}  # fmt: skip
"""Bitrate -> n of the command Sn."""
STAMP_DIGITS = 4
REFUSED = b"\a"

_OTHER_KINDS = {b"T": 8, b"r": 3, b"R": 8}
_NOT_FRAMES = (b"", b"z", b"Z")


@cache
def _heads() -> dict[bytes, tuple[int, int]]:
    """The first five bytes of a standard data frame, in upper case -> identifier, length of the whole line.

    18,432 of them: made for the first reader, and not at the start of programs that have none.
    """
    return {
        f"t{can_id:03X}{length}".encode(): (can_id, 5 + 2 * length) for can_id in range(0x800) for length in range(9)
    }


class SlcanReader:
    """Text of an adapter -> standard data frames. `feed` never raises, in bounded memory.

    `other_frames` counts extended and remote frames, which no motor of ours sends; `noise_lines` what is neither a
    frame nor an answer; `refusals` the adapter's BELs.
    """

    def __init__(self) -> None:
        self.other_frames = 0
        self.noise_lines = 0
        self.refusals = 0
        self._rest = b""
        self._heads = _heads()

    def feed(self, data: bytes) -> list[CanFrame]:
        """The frames that these bytes complete, in order."""
        lines = (self._rest + data).split(b"\r")
        rest = lines.pop()
        # What could still become a frame is short; anything before it is noise.
        self._rest = rest if len(rest) <= MOST_LINE_BYTES else rest[-MOST_LINE_BYTES:]
        frames: list[CanFrame] = []
        heads, odd = self._heads, self._odd
        for line in lines:
            head = heads.get(line[:5])
            if head is not None and len(line) == head[1]:
                try:
                    frames.append((head[0], unhexlify(line[5:])))
                except ValueError:
                    odd(line, frames)
            elif line not in _NOT_FRAMES:
                odd(line, frames)
        return frames

    def _odd(self, line: bytes, frames: list[CanFrame]) -> None:
        """A line that is not just a standard data frame: junk before it, a time stamp behind it, lower case, noise."""
        self.refusals += line.count(REFUSED)
        start = max(line.rfind(letter) for letter in (b"t", b"T", b"r", b"R"))
        if start >= 0:
            line = line[start:]
            head = self._heads.get(b"t" + line[1:5].upper()) if line[:1] == b"t" else None
            if head is not None and len(line) - head[1] in (0, STAMP_DIGITS) and _is_hex(line[5:]):
                frames.append((head[0], unhexlify(line[5 : head[1]])))
                return
            if self._is_other(line):
                self.other_frames += 1
                return
        if line.strip(b"\a\nzZ"):
            self.noise_lines += 1

    def _is_other(self, line: bytes) -> bool:
        digits = _OTHER_KINDS.get(line[:1])
        if digits is None or not _is_hex(line[1:]) or not line[digits + 1 : digits + 2].isdigit():
            return False
        length = int(line[digits + 1 : digits + 2])
        whole = digits + 2 + (2 * length if line[:1] == b"T" else 0)
        return length <= 8 and len(line) - whole in (0, STAMP_DIGITS)


def encode(frame: CanFrame) -> bytes:
    """One standard data frame as an adapter's line. Raises ValueError outside 11 bits and 8 bytes."""
    can_id, data = frame
    if not 0 <= can_id < 0x800 or len(data) > 8:
        raise ValueError(f"no standard data frame: identifier {can_id:#x}, {len(data)} bytes")
    return b"t%03X%d%b\r" % (can_id, len(data), data.hex().upper().encode())


def opening(bitrate: int) -> bytes:
    """What opens an adapter in whatever state it is: end a half line, close, set the bitrate, open. Raises ValueError
    for a bitrate that the S command has no digit for.
    """
    if bitrate not in BITRATES:
        raise ValueError(f"bitrate {bitrate} is none of {', '.join(map(str, BITRATES))}")
    return b"\r\r\rC\rS%d\rO\r" % BITRATES[bitrate]


CLOSING = b"C\r"


def _is_hex(text: bytes) -> bool:
    """Whether these are hexadecimal digits and nothing else: int() would take signs and underscores too."""
    return not text.strip(b"0123456789ABCDEFabcdef")
