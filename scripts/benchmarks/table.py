"""Lines of the benchmark's table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

Sample = dict[str, float]
"""What one round of a piece has measured."""


class Row(NamedTuple):
    """One line of the table. `verdict` is "ok", "MISSED", or empty for information."""

    figure: str
    value: str
    bar: str = ""
    verdict: str = ""


def verdict(is_met: bool) -> str:
    """The word for it."""
    return "ok" if is_met else "MISSED"


def table(rows: Sequence[Row]) -> str:
    """The rows in columns."""
    lines = [Row("figure", "measured", "bar"), *rows]
    widths = [max(len(line[column]) for line in lines) for column in range(4)]
    return "\n".join("   ".join(map(str.ljust, line, widths)).rstrip() for line in lines)
