"""What a terminal is sent so that one line becomes another: only the spans that are new. No Textual, no clock.

Most of the cost of a frame was what a toolkit does for widgets that may overlap, scroll and be styled. Panels do not:
where nothing lies over them, their changes go to the terminal as they are.
"""

from __future__ import annotations

from typing import TypeAlias

from bench.screen.text import Line

RESET = "\x1b[0m"
"""Whatever was set before counts no more (ECMA-48, SGR 0)."""
Inks: TypeAlias = dict[str, str]
"""Role -> what sets its colours, whatever was set before."""


def rewrite(x: int, y: int, old: Line, new: Line, inks: Inks) -> str:
    """Turn a line that begins in cell (x, y), counted from 0, into another one of the same width."""
    first, end = 0, len(new)
    if len(old) == end:
        for before, after in zip(old, new, strict=True):
            if before != after:
                break
            x += len(after[0])
            first += 1
        while end > first and old[end - 1] == new[end - 1]:
            end -= 1
    return f"\x1b[{y + 1};{x + 1}H" + "".join([inks[role] + words for words, role in new[first:end]])
