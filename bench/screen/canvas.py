"""A drawing surface of braille dots: two by four to a cell, one role to a cell. What is drawn later lies on top."""

from __future__ import annotations

import re
from codecs import charmap_decode
from collections.abc import Iterable
from functools import lru_cache, reduce
from operator import or_

from bench.screen.text import PLAIN, ROLES, Line

_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # Unicode braille patterns, by row and column
_SIGNS = " " + "".join(chr(0x2800 + bits) for bits in range(1, 256))
_CODES = {role: code for code, role in enumerate(ROLES, 1)}
"""Roles as bytes; 0 is that of an empty cell, which has none."""
_RUN = re.compile(rb"\0*([^\0])(?:\1|\0)*", re.DOTALL)
"""Cells with one role, and the empty ones among them and behind them; before them only in front of all."""
_SPANS = tuple(
    tuple(
        tuple(reduce(or_, (_BITS[y][side] for y in range(first, last + 1)), 0) for last in range(4))
        for first in range(4)
    )
    for side in range(2)
)
"""The dots from the first to the last of four, for the left and the right column of a cell."""


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
        bits, roles, columns, width, height = self._bits, self._roles, self.columns, self.width, self.height
        code = _CODES[role]
        for u, v in points:
            x, y = int(u // 1), int(v // 1)
            if 0 <= x < width and 0 <= y < height:
                cell = (y >> 2) * columns + (x >> 1)
                bits[cell] |= _BITS[y & 3][x & 1]
                roles[cell] = code

    def columns_of(self, spans: Iterable[tuple[int, int]], role: str) -> None:
        """Dots below each other, `first` to `last`, in one column after the other: cell by cell, a trace has thousands.

        (0, -1) is a column without a dot.
        """
        bits, roles, columns, code, bottom = self._bits, self._roles, self.columns, _CODES[role], self.height - 1
        for x, (first, last) in zip(range(self.width), spans, strict=False):
            if first < 0:
                first = 0
            if last > bottom:
                last = bottom
            masks, top = _SPANS[x & 1], first & ~3
            cell = (first >> 2) * columns + (x >> 1)
            while top <= last:
                bits[cell] |= masks[first - top if first > top else 0][last - top if last < top + 3 else 3]
                roles[cell] = code
                cell += columns
                top += 4

    def stipple(self, role: str, *, x: int | None = None, y: int | None = None) -> None:
        """A dotted line down column x, or along row y: a dot a cell."""
        if x is not None and 0 <= x < self.width:
            cells, bit = range(x >> 1, self.columns * self.rows, self.columns), _BITS[0][x & 1]
        elif y is not None and 0 <= y < self.height:
            start = (y >> 2) * self.columns
            cells, bit = range(start, start + self.columns), _BITS[y & 3][0]
        else:
            return
        code = _CODES[role]
        for cell in cells:
            self._bits[cell] |= bit
            self._roles[cell] = code

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
        x, y = int(u // 2), int(v // 4)
        if 0 <= x < self.columns and 0 <= y < self.rows:
            self._signs[y * self.columns + x] = (sign, role)

    def lines(self) -> list[Line]:
        """The picture, one line a row, not to be changed; an empty cell is a blank, which takes any role."""
        columns, bits, roles = self.columns, bytes(self._bits), bytes(self._roles)
        lines = []
        signs = self._signs_by_row()
        for row in range(self.rows):
            start, end = row * columns, (row + 1) * columns
            lines.append(_line(bits[start:end], roles[start:end], signs.get(row, ())))
        return lines

    def _signs_by_row(self) -> dict[int, tuple[tuple[int, str, int], ...]]:
        """(column, sign, code of its role) of each row that has any."""
        signs: dict[int, tuple[tuple[int, str, int], ...]] = {}
        for cell, (sign, role) in self._signs.items():
            row, column = divmod(cell, self.columns)
            signs[row] = (*signs.get(row, ()), (column, sign, _CODES[role]))
        return signs


@lru_cache(maxsize=512)
def _line(bits: bytes, roles: bytes, signs: tuple[tuple[int, str, int], ...]) -> Line:
    """As few spans as can be: each one costs the terminal, and the screen more than its cells do. Most rows stand."""
    text, codes = charmap_decode(bits, "strict", _SIGNS)[0], roles
    if signs:
        cells, own = list(text), bytearray(roles)
        for column, sign, code in signs:
            cells[column], own[column] = sign, code
        text, codes = "".join(cells), bytes(own)
    if not any(codes):
        return [(text, PLAIN)]
    return [(text[run.start() : run.end()], ROLES[run[1][0] - 1]) for run in _RUN.finditer(codes)]
