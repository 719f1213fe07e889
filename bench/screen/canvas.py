"""A drawing surface of braille dots: two by four to a cell, one role to a cell. What is drawn later lies on top."""

from __future__ import annotations

from functools import reduce
from operator import or_

from bench.screen.text import PLAIN, Line

_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # Unicode braille patterns, by row and column
_SIGNS = (" ", *(chr(0x2800 + bits) for bits in range(1, 256)))
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
        masks, columns, cell = _SPANS[x & 1], self.columns, (first >> 2) * self.columns + (x >> 1)
        top = first & ~3
        while top <= last:
            self._bits[cell] |= masks[max(first - top, 0)][min(last - top, 3)]
            self._roles[cell] = role
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
        for cell in cells:
            self._bits[cell] |= bit
            self._roles[cell] = role

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
        for i in range(steps + 1):
            self.dot(u0 + (u1 - u0) * i / steps, v0 + (v1 - v0) * i / steps, role)

    def sign(self, u: float, v: float, sign: str, role: str) -> None:
        """A character in place of the dots of the cell where the point lies."""
        x, y = int(u // 2), int(v // 4)
        if 0 <= x < self.columns and 0 <= y < self.rows:
            self._signs[y * self.columns + x] = (sign, role)

    def lines(self) -> list[Line]:
        """The picture, one line a row; an empty cell is a blank, which takes any role."""
        signs: dict[int, dict[int, tuple[str, str]]] = {}
        for cell, sign in self._signs.items():
            signs.setdefault(cell // self.columns, {})[cell % self.columns] = sign
        out = []
        for row in range(self.rows):
            start, end = row * self.columns, (row + 1) * self.columns
            out.append(_line(self._bits[start:end], self._roles[start:end], signs.get(row)))
        return out


def _line(bits: list[int], roles: list[str], signs: dict[int, tuple[str, str]] | None) -> Line:
    """As few spans as can be: each one costs the terminal, and the screen more than its cells do."""
    text = list(map(_SIGNS.__getitem__, bits))
    for place, (sign, role) in signs.items() if signs else ():
        text[place], roles[place], bits[place] = sign, role, 1
    if not any(bits):
        return [("".join(text), PLAIN)]
    line: Line = []
    start, role = 0, ""
    for place, own in enumerate(roles):
        if bits[place] and own != role:
            if role:
                line.append(("".join(text[start:place]), role))
                start = place
            role = own
    return [*line, ("".join(text[start:]), role)]
