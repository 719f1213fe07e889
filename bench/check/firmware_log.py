"""firmware.log of a recording: what a firmware printed, a line each, and how it died. For people: no replay reads it.

(0.000000) | boot 7                               printed; the time is that of the tick in which the line ended
(0.321000) ! the firmware crashed: SIGILL, ...    the last line of a firmware that has died
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from bench.check.lines import stamp

FIRMWARE_LOG = "firmware.log"
PRINTED, ENDED = "|", "!"
PrintedLine = tuple[int, str, str]
"""Tick, mark, text."""

LAST_LINES = 8
_TAIL_BYTES = 1 << 14
_LINE = re.compile(r"\((\d+\.\d{3})000\) ([|!]) (.*)")


class Death(NamedTuple):
    """How a recorded firmware ended, and what it had printed last: (seconds, text) each."""

    at_s: str
    how: str
    last: tuple[tuple[str, str], ...]

    def lines(self) -> list[str]:
        """For people."""
        said = [f"          {at_s} s  {text}" for at_s, text in self.last]
        return [f"died      at {self.at_s} s {self.how}" + ("; its last output:" if said else ""), *said]

    def as_dict(self) -> dict[str, object]:
        """For programs."""
        last = [{"at_s": float(at_s), "text": text} for at_s, text in self.last]
        return {"at_s": float(self.at_s), "how": self.how, "last_output": last}


def printed_lines(lines: Sequence[PrintedLine]) -> str:
    """The text of these lines."""
    return "".join([f"{stamp(tick)} {mark} {text}\n" for tick, mark, text in lines])


def death(directory: Path) -> Death | None:
    """Of the firmware that this recording is of; None where it lived, or nothing is known of it."""
    try:
        with open(directory / FIRMWARE_LOG, "rb") as file:
            size = file.seek(0, 2)
            file.seek(max(0, size - _TAIL_BYTES))
            text = file.read().decode("utf-8", "replace")
    except OSError:
        return None
    found = [line.groups() for line in map(_LINE.fullmatch, text.split("\n")) if line]
    if not found or found[-1][1] != ENDED:
        return None
    *before, (at_s, _, how) = found
    return Death(at_s, how, tuple((each_s, said) for each_s, _, said in before[-LAST_LINES:]))
