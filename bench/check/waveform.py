"""Two traces as characters: braille dots, one trace above the other on the same scale."""

from __future__ import annotations

from collections.abc import Sequence

COLUMNS, ROWS = 66, 3
DOTS = 2 * COLUMNS
_HEIGHT = 4 * ROWS
_BITS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))
"""Of a braille character: left and right column, from the top."""


def drawn(values: Sequence[float | None], low: float, high: float) -> list[str]:
    """`DOTS` values from left to right as `ROWS` lines; None leaves a gap. A step is drawn as an upright stroke."""
    cells = [[0] * COLUMNS for _ in range(ROWS)]
    before: int | None = None
    for x, value in enumerate(values[:DOTS]):
        if value is None:
            before = None
            continue
        y = _dot(value, low, high)
        start, end = sorted((y, y if before is None else before + (y > before) - (y < before)))
        for dot in range(start, end + 1):
            cells[dot // 4][x // 2] |= _BITS[x % 2][dot % 4]
        before = y
    return ["".join(chr(0x2800 + cell) for cell in row).rstrip("\u2800") for row in cells]


def _dot(value: float, low: float, high: float) -> int:
    """From the top; a trace that never moves runs through the middle."""
    if high <= low:
        return _HEIGHT // 2
    share = min(1.0, max(0.0, (value - low) / (high - low)))
    return round((1.0 - share) * (_HEIGHT - 1))
