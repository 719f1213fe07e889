"""Document 003: a textbook page on mobile robots, equations 3.32 to 3.34. What it prints is right; its scan is not.

Frame: x forward, y left, counter-clockwise positive; three wheels at 60, 180 and -60 degrees, clockwise positive.
"""

from __future__ import annotations

import math

Matrix = tuple[tuple[float, float, float], ...]

BEARINGS_DEG = (60.0, 180.0, -60.0)
EXAMPLE_WHEELS = (4.0, 1.0, 2.0)
EXAMPLE_RESULT = (2.0 / math.sqrt(3.0), -4.0 / 3.0, -7.0 / 3.0)
"""Equation 3.34, in numbers of the book."""


def j1f_as_printed(l_m: float = 1.0) -> Matrix:
    """Equation 3.32: twist -> rim speeds. Right. Row 21."""
    s, c = math.sin(math.pi / 3), math.cos(math.pi / 3)
    return (s, -c, -l_m), (0.0, -math.cos(math.pi), -l_m), (-s, -c, -l_m)


def inverse_j1f_as_printed(l_m: float = 1.0) -> Matrix:
    """Equation 3.33: rim speeds -> twist, with the signs that the book's own example demands. Right. Row 21."""
    return (
        (1 / math.sqrt(3), 0.0, -1 / math.sqrt(3)),
        (-1 / 3, 2 / 3, -1 / 3),
        (-1 / (3 * l_m), -1 / (3 * l_m), -1 / (3 * l_m)),
    )


def inverse_j1f_scan_as_printed(l_m: float = 1.0) -> Matrix:
    """Equation 3.33 as the scan's line reads: the minus of the last row's middle stands on another line. Row 21."""
    return (
        (1 / math.sqrt(3), 0.0, -1 / math.sqrt(3)),
        (-1 / 3, 2 / 3, -1 / 3),
        (-1 / (3 * l_m), 1 / (3 * l_m), -1 / (3 * l_m)),
    )
