"""A drawing surface of braille dots: two by four to a cell, one role to a cell. What is drawn later lies on top."""

from __future__ import annotations

from bench.screen.text import PLAIN, Line

_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # Unicode braille patterns, by row and column
_BRAILLE = 0x2800


class Canvas:
    """`columns` by `rows` cells. Dots count from the upper left; what lies outside is left out."""

    def __init__(self, columns: int, rows: int) -> None:
        self.columns = columns
        self.rows = rows
        self.width = columns * 2
        self.height = rows * 4
        self._bits = [0] * (columns * rows)
        self._roles = [PLAIN] * (columns * rows)
        self._signs: dict[int, tuple[str, str]] = {}

    def dot(self, u: float, v: float, role: str) -> None:
        """One dot, u to the right and v down."""
        x, y = int(u // 1), int(v // 1)
        if 0 <= x < self.width and 0 <= y < self.height:
            cell = (y >> 2) * self.columns + (x >> 1)
            self._bits[cell] |= _BITS[y & 3][x & 1]
            self._roles[cell] = role

    def column(self, x: int, first: int, last: int, role: str) -> None:
        """Dots below each other in one column, `first` to `last`, cell by cell: a trace has thousands."""
        if not 0 <= x < self.width:
            return
        first, last = max(first, 0), min(last, self.height - 1)
        side = x & 1
        for row in range(first >> 2, (last >> 2) + 1):
            bits = 0
            for y in range(max(first - 4 * row, 0), min(last - 4 * row, 3) + 1):
                bits |= _BITS[y][side]
            cell = row * self.columns + (x >> 1)
            self._bits[cell] |= bits
            self._roles[cell] = role

    def line(self, u0: float, v0: float, u1: float, v1: float, role: str) -> None:
        """A straight line of dots."""
        steps = max(1, round(max(abs(u1 - u0), abs(v1 - v0))))
        for i in range(steps + 1):
            self.dot(u0 + (u1 - u0) * i / steps, v0 + (v1 - v0) * i / steps, role)

    def sign(self, u: float, v: float, sign: str, role: str) -> None:
        """A character in place of the dots of the cell where the point lies."""
        x, y = int(u // 2), int(v // 4)
        if 0 <= x < self.columns and 0 <= y < self.rows:
            self._signs[y * self.columns + x] = (sign, role)

    def lines(self) -> list[Line]:
        """The picture, one line a row; an empty cell is a blank."""
        out = []
        for start in range(0, self.columns * self.rows, self.columns):
            line: Line = []
            text, role = "", PLAIN
            for cell in range(start, start + self.columns):
                bits = self._bits[cell]
                sign, own = self._signs.get(cell) or (chr(_BRAILLE + bits) if bits else " ", self._roles[cell])
                if own != role and text:
                    line.append((text, role))
                    text = ""
                text, role = text + sign, own
            out.append([*line, (text, role)])
        return out
