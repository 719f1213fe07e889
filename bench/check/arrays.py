"""can.log as numpy arrays: a million lines in a fraction of a second, where a line at a time takes ten.

Lines of one length that have their `.` in one place are one table of characters, so each of their columns is taken at
once. Whatever is not written as we write it is not guessed at: then there are no arrays, and the caller goes line by
line, which also finds the words for what is wrong.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LINES_AT_ONCE = 1 << 17
"""Bounds the memory that the characters of a block take beside the text itself."""

_FIXED = np.frombuffer(b"000) can0 ", np.uint8)
"""Between the milliseconds and the identifier."""
_MOST_DIGITS = 7
"""Of the seconds: 115 days."""


class CanArrays(NamedTuple):
    """One entry a frame, in the order of the log."""

    tick: NDArray[np.int32]
    can_id: NDArray[np.uint16]
    length: NDArray[np.uint8]
    data: NDArray[np.uint64]
    """The bytes from the most significant one on; behind a short frame stand zeros."""

    def until(self, end_tick: int) -> CanArrays:
        """The frames before this tick; the log's ticks must not go back (`goes_back`)."""
        end = int(np.searchsorted(self.tick, end_tick))
        return self.rows(slice(0, end))

    def rows(self, rows: slice | NDArray[np.int64]) -> CanArrays:
        """Some of the frames."""
        return CanArrays(self.tick[rows], self.can_id[rows], self.length[rows], self.data[rows])

    @property
    def ids(self) -> list[int]:
        """The identifiers that occur, in order."""
        return [int(can_id) for can_id in np.flatnonzero(np.bincount(self.can_id, minlength=1))]

    def outside(self, ticks: NDArray[np.int32] | NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which frames are in none of these ticks."""
        size = 1 + max(int(self.tick[-1]) if len(self.tick) else 0, int(ticks.max()) if len(ticks) else 0)
        inside = np.zeros(size, bool)
        inside[ticks] = True
        return np.asarray(~inside[self.tick])

    @classmethod
    def of_size(cls, frames: int) -> CanArrays:
        """Room for so many frames."""
        return cls(
            np.zeros(frames, np.int32),
            np.zeros(frames, np.uint16),
            np.zeros(frames, np.uint8),
            np.zeros(frames, np.uint64),
        )

    @property
    def goes_back(self) -> bool:
        """Whether a frame has an earlier tick than the one before it."""
        return bool((np.diff(self.tick) < 0).any())


def can_arrays(content: bytes) -> CanArrays | None:
    """The whole lines of a can.log; None where one of them is not as our writer writes it."""
    text = np.frombuffer(content, np.uint8)
    ends = np.flatnonzero(text == ord("\n"))
    if not len(ends):
        return CanArrays.of_size(0)
    starts = np.empty_like(ends)
    starts[0] = 0
    starts[1:] = ends[:-1] + 1
    found = CanArrays.of_size(len(ends))
    for first in range(0, len(ends), LINES_AT_ONCE):
        block = slice(first, first + LINES_AT_ONCE)
        if not _read_block(text, starts[block], ends[block], found.rows(block)):
            return None
    return found


def _read_block(text: NDArray[np.uint8], starts: NDArray[np.int64], ends: NDArray[np.int64], into: CanArrays) -> bool:
    lengths = ends - starts
    first_length = int(lengths[0])
    if (lengths == first_length).all() and first_length:
        # All alike, as nearly always: the text itself is the table.
        table = text[starts[0] : ends[-1] + 1].reshape(len(starts), first_length + 1)
        return _read_lines(table[:, :first_length], np.arange(len(starts)), into)
    for length in np.unique(lengths).tolist():
        rows = np.flatnonzero(lengths == length)
        # A view with a line's width at every character, of which the wanted lines are copied out.
        lines = np.lib.stride_tricks.sliding_window_view(text, length)[starts[rows]] if length else None
        if lines is None or not _read_lines(lines, rows, into):
            return False
    return True


def _read_lines(lines: NDArray[np.uint8], rows: NDArray[np.int64], into: CanArrays) -> bool:
    """Lines of one length, by how many digits their seconds have."""
    left = np.ones(len(rows), bool)
    for digits in range(1, _MOST_DIGITS + 1):
        hexes = lines.shape[1] - digits - 19
        if hexes < 0:
            break
        if hexes > 16 or hexes % 2:
            continue
        these = left & (lines[:, digits + 1] == ord("."))
        if not these.any():
            continue
        everything = bool(these.all())
        if not _read_columns(lines if everything else lines[these], rows if everything else rows[these], digits, into):
            return False
        left &= ~these
        if everything:
            break
    return not left.any()


def _read_columns(lines: NDArray[np.uint8], rows: NDArray[np.int64], digits: int, into: CanArrays) -> bool:
    seconds, ok = _decimal(lines[:, 1 : digits + 1])
    millis, millis_ok = _decimal(lines[:, digits + 2 : digits + 5])
    at = digits + 5
    id_at = at + len(_FIXED)
    ok = ok and millis_ok and bool((lines[:, 0] == ord("(")).all() and (lines[:, at:id_at] == _FIXED).all())
    ok = ok and bool((lines[:, id_at + 3] == ord("#")).all())
    ok = ok and (digits == 1 or bool((lines[:, 1] != ord("0")).all()))
    if not ok:
        return False
    digit = _hex_digits()
    high, middle, low = (digit[lines[:, id_at + place]] for place in range(3))
    if high.max() > 7 or middle.max() > 15 or low.max() > 15:
        return False
    payload = lines[:, id_at + 4 :]
    count = payload.shape[1] // 2
    values = _hex_pairs()[np.ascontiguousarray(payload).view("<u2")] if count else np.empty((len(lines), 0), np.uint16)
    if count and values.max() > 255:
        return False
    data = values.astype(np.uint8) if count == 8 else np.zeros((len(lines), 8), np.uint8)
    data[:, :count] = values
    into.tick[rows] = seconds * 1000 + millis
    into.can_id[rows] = (high.astype(np.uint16) << 8) | (middle << 4) | low
    into.length[rows] = count
    into.data[rows] = data.view(">u8")[:, 0]
    return True


def _decimal(characters: NDArray[np.uint8]) -> tuple[NDArray[np.int32], bool]:
    value = np.zeros(len(characters), np.int32)
    ok = True
    for column in range(characters.shape[1]):
        digit = characters[:, column] - np.uint8(ord("0"))
        ok = ok and bool((digit <= 9).all())
        value = value * np.int32(10) + digit
    return value, ok


@cache
def _hex_digits() -> NDArray[np.uint8]:
    table = np.full(256, 255, np.uint8)
    for value, character in enumerate(b"0123456789ABCDEF"):
        table[character] = value
    return table


@cache
def _hex_pairs() -> NDArray[np.uint16]:
    """Two characters, read as a little-endian number, to their byte; 256 where they are none."""
    table = np.full(1 << 16, 256, np.uint16)
    for value in range(256):
        high, low = b"%02X" % value
        table[low << 8 | high] = value
    return table
