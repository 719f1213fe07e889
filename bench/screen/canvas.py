"""A drawing surface of braille dots: two by four to a cell, one role to a cell. What is drawn later lies on top."""

from __future__ import annotations

import re
from codecs import charmap_decode
from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import accumulate
from math import floor
from operator import or_

from bench.screen.text import PLAIN, ROLES, Line, Span

_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # Unicode braille patterns, by row and column
_LEFT, _RIGHT = b"\x47", b"\xb8"
"""All dots of a cell's left column, and of its right one."""
_SIGNS = " " + "".join(chr(0x2800 + bits) for bits in range(1, 256))
_CODES = {role: code for code, role in enumerate(ROLES, 1)}
"""Roles as bytes; 0 is that of an empty cell, which has none."""
_RUN = re.compile(rb"\0*([^\0])(?:\1|\0)*", re.DOTALL)
"""Cells with one role, and the empty ones among them and behind them; before them only in front of all."""
_WITH = tuple(bytes(cell | 1 << bit for cell in range(256)) for bit in range(8))
"""For each bit: what every cell becomes with it."""
_NOT_EMPTY = b"\0" + b"\xff" * 255
OUTSIDE = -1


class Canvas:
    """`columns` by `rows` cells. Dots count from the upper left; what lies outside is left out."""

    def __init__(self, columns: int, rows: int) -> None:
        self.columns = columns
        self.rows = rows
        self.width = columns * 2
        self.height = rows * 4
        self._bits = bytearray(columns * rows)
        self._roles = bytearray(columns * rows)
        self._signs: dict[int, tuple[str, str]] = {}

    def dot(self, u: float, v: float, role: str) -> None:
        """One dot, u to the right and v down."""
        self.dots(((u, v),), role)

    def dots(self, points: Iterable[tuple[float, float]], role: str) -> None:
        """Many dots, each (u, v)."""
        self.mark(self.place(points), role)

    def place(self, points: Iterable[tuple[float, float]]) -> list[int]:
        """For each point a number that says where its dot is, for `mark` and `signs`; `OUTSIDE` for what lies there."""
        columns, width, height = self.columns, self.width, self.height
        numbers = []
        for u, v in points:
            x, y = floor(u), floor(v)
            if 0 <= x < width and 0 <= y < height:
                numbers.append(((y >> 2) * columns + (x >> 1)) << 8 | _BITS[y & 3][x & 1])
            else:
                numbers.append(OUTSIDE)
        return numbers

    def mark(self, numbers: Iterable[int], role: str) -> None:
        """Dots where `place` has put them."""
        bits, roles, code = self._bits, self._roles, _CODES[role]
        for number in set(numbers):
            if number != OUTSIDE:
                bits[number >> 8] |= number & 0xFF
                roles[number >> 8] = code

    def trace(self, spans: Iterable[tuple[int, int] | None], role: str) -> None:
        """A line: for each column of dots the first and the last one, joined to those of the column before.

        All lie inside the picture; None is a gap.
        """
        rows, count = self.rows, self.columns * self.rows
        since, until = _reaches(rows)
        masks = []
        start = end = 0
        for span in spans:
            if span is None:
                masks.append(0)
                start = end = 0
            else:
                first, last = span
                masks.append((since[first] | start) & (until[last] | end))
                start, end = since[last + 1], until[first - 1]
        left, right = int.from_bytes(_LEFT * rows), int.from_bytes(_RIGHT * rows)
        pairs = zip(masks[::2], masks[1::2], strict=True)
        cells = b"".join([(one & left | other & right).to_bytes(rows) for one, other in pairs])
        drawn = b"".join([cells[row::rows] for row in range(rows)])
        covered, codes = int.from_bytes(drawn.translate(_NOT_EMPTY)), int.from_bytes(bytes((_CODES[role],)) * count)
        self._bits[:] = (int.from_bytes(self._bits) | int.from_bytes(drawn)).to_bytes(count)
        self._roles[:] = (int.from_bytes(self._roles) & ~covered | codes & covered).to_bytes(count)

    def stipple(self, role: str, *, x: int | None = None, y: int | None = None) -> None:
        """A dotted line down column x, or along row y: a dot a cell."""
        if x is not None and 0 <= x < self.width:
            cells, bit = slice(x >> 1, None, self.columns), _BITS[0][x & 1]
        elif y is not None and 0 <= y < self.height:
            cells, bit = slice((y >> 2) * self.columns, ((y >> 2) + 1) * self.columns), _BITS[y & 3][0]
        else:
            return
        before = self._bits[cells]
        self._bits[cells] = before.translate(_WITH[bit.bit_length() - 1])
        self._roles[cells] = bytes((_CODES[role],)) * len(before)

    def copy(self) -> Canvas:
        """One of its own with the same dots."""
        other = Canvas(self.columns, self.rows)
        other._bits[:] = self._bits
        other._roles[:] = self._roles
        other._signs |= self._signs
        return other

    def line(self, u0: float, v0: float, u1: float, v1: float, role: str) -> None:
        """A straight line of dots."""
        steps = max(1, round(max(abs(u1 - u0), abs(v1 - v0))))
        du, dv = u1 - u0, v1 - v0
        self.dots([(u0 + du * i / steps, v0 + dv * i / steps) for i in range(steps + 1)], role)

    def sign(self, u: float, v: float, sign: str, role: str) -> None:
        """A character in place of the dots of the cell where the point lies."""
        self.signs(self.place(((u, v),)), sign, role)

    def signs(self, numbers: Iterable[int], sign: str, role: str) -> None:
        """The same where `place` has put them."""
        for number in set(numbers):
            if number != OUTSIDE:
                self._signs[number >> 8] = (sign, role)

    def lines(self, before: Sequence[Span] = (), after: Sequence[Span] = ()) -> list[Line]:
        """The picture, one line a row between what stands before and after it, not to be changed.

        An empty cell is a blank, which takes any role.
        """
        columns, bits, roles = self.columns, bytes(self._bits), bytes(self._roles)
        lines = []
        signs = self._signs_by_row()
        for row in range(self.rows):
            start, end = row * columns, (row + 1) * columns
            lines.append(_line(bits[start:end], roles[start:end], signs.get(row, ()), before, after))
        return lines

    def _signs_by_row(self) -> dict[int, tuple[tuple[int, str, int], ...]]:
        """(column, sign, code of its role) of each row that has any."""
        signs: dict[int, tuple[tuple[int, str, int], ...]] = {}
        for cell, (sign, role) in self._signs.items():
            row, column = divmod(cell, self.columns)
            signs[row] = (*signs.get(row, ()), (column, sign, _CODES[role]))
        return signs


@lru_cache(maxsize=8)
def _reaches(rows: int) -> tuple[list[int], list[int]]:
    """For each row of dots in a column of cells: the dots from there on, and those up to there.

    Cells are bytes of a number, the uppermost first. Behind the last row there are none, nor before the first (-1).
    """
    dots = [sum(_BITS[y & 3]) << 8 * (rows - 1 - (y >> 2)) for y in range(4 * rows)]
    until = list(accumulate(dots, or_))
    since = [*(until[-1] & ~upper for upper in (0, *until))]
    return since, [*until, 0]


@lru_cache(maxsize=512)
def _line(
    bits: bytes,
    roles: bytes,
    signs: tuple[tuple[int, str, int], ...],
    before: Sequence[Span],
    after: Sequence[Span],
) -> Line:
    """As few spans as can be: each one costs the terminal, and the screen more than its cells do. Most rows stand."""
    text, codes = charmap_decode(bits, "strict", _SIGNS)[0], roles
    if signs:
        cells, own = list(text), bytearray(roles)
        for column, sign, code in signs:
            cells[column], own[column] = sign, code
        text, codes = "".join(cells), bytes(own)
    if not any(codes):
        return [*before, (text, PLAIN), *after]
    runs = [(text[run.start() : run.end()], ROLES[run[1][0] - 1]) for run in _RUN.finditer(codes)]
    return [*before, *runs, *after]
