"""Lines of the benchmark's table."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import NamedTuple

from benchmarks.empty_call import REFERENCE_NS

Sample = dict[str, float]
"""What one round of a piece has measured."""
_TOLD_FOR = tuple(f"if a call took {ns:g} ns" for ns in REFERENCE_NS.values())
LEGEND = (
    f'"{_TOLD_FOR[0]}", "{_TOLD_FOR[1]}": calculated, not measured. The measured number by the empty Python call\n'
    "of the same round, for the reference machine with a warm clock and with a cold one. Waiting for a busy core is\n"
    "not in that call: wall figures keep it."
)


class Row(NamedTuple):
    """One line of the table. `verdict` is "ok", "MISSED", or empty for information."""

    figure: str
    value: str
    bar: str = ""
    verdict: str = ""
    told_for_reference: tuple[str, ...] = ("",) * len(REFERENCE_NS)


def verdict(is_met: bool) -> str:
    """The word for it."""
    return "ok" if is_met else "MISSED"


def row_at_least(figure: str, values: Sequence[float], bar: float) -> Row:
    """A figure that must reach its bar: the median of the rounds."""
    value = median(values)
    return Row(figure, f"{value:.1f}", f"at least {bar:.3g}", verdict(value >= bar))


def table(rows: Sequence[Row]) -> str:
    """The rows in columns; those for the reference machine where a row has them, with a line on what they are."""
    lines = [(row.figure, row.value, *row.told_for_reference, row.bar, row.verdict) for row in rows]
    lines = [("figure", "measured", *_TOLD_FOR, "bar", ""), *lines]
    is_told = any("".join(row.told_for_reference) for row in rows)
    if not is_told:
        lines = [(*line[:2], *line[-2:]) for line in lines]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = "\n".join("   ".join(map(str.ljust, line, widths)).rstrip() for line in lines)
    return f"{text}\n\n{LEGEND}" if is_told else text
