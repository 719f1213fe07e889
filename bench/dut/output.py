"""What a firmware prints: each line with the tick in which it ended, in bounded memory, safe to show in a terminal.

It prints into a file in memory that it shares with the bench. A tick's answer says whether something lies there; it is
taken out then, so the file is empty again before the firmware goes on.
"""

from __future__ import annotations

import os
import re
from collections import deque

from bench.check.firmware_log import ENDED, PRINTED, PrintedLine

LOG_CHARACTERS = 1 << 20
"""So much of a run goes into its log; beyond that only its last lines, when it is over."""
TAIL_CHARACTERS = 1 << 16
"""So much is told after a run. A line counts `LINE_COSTS` more than its text, so that empty ones are bounded too."""
TAKEN_BYTES = 1 << 16
"""The most that is taken of what one tick has printed; of more, the end."""
LONGEST_LINE, LINE_COSTS = 1000, 24
_REPORT = re.compile(r"={60,}|==\d+==ERROR: |\S+:\d+:\d+: runtime error: ")
_CONTROL = {code: f"\\x{code:02x}" for code in (*range(9), *range(10, 32), *range(127, 160))}


def shown(line: bytes) -> str:
    """A line as text: what is no UTF-8, and what would steer a terminal, as \\x1b and the like."""
    return line.removesuffix(b"\r").decode("utf-8", "backslashreplace").translate(_CONTROL)


class Output:
    """The output of one firmware. `watches_reports`: a sanitizer's report is told, but is no line of the firmware's own
    (it holds process numbers and paths of this machine).
    """

    def __init__(self, watches_reports: bool = False) -> None:
        self.file = os.memfd_create("output")
        self._watches_reports = watches_reports
        self._in_report = False
        self._rest = b""
        self._tick = 0  # of what was taken last
        self._tail: deque[PrintedLine] = deque()
        self._tail_characters = 0
        self._new: list[PrintedLine] = []
        self._room = LOG_CHARACTERS
        self._left_out = 0
        """Lines that found no more room in the log."""

    def take(self, tick: int) -> None:
        """Take what has been printed; the firmware must not be running."""
        size = os.fstat(self.file).st_size
        if not size:
            return
        self._tick = tick
        skipped = max(0, size - TAKEN_BYTES)
        data = os.pread(self.file, TAKEN_BYTES, skipped)
        os.ftruncate(self.file, 0)
        os.lseek(self.file, 0, os.SEEK_SET)
        if skipped:
            self._add(tick, f"... {skipped} bytes of one millisecond are left out")
            self._rest = b""
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            self._add(tick, shown(line))
        if len(self._rest) > LONGEST_LINE:
            self._add_rest(tick)

    def end(self) -> None:
        """The run is over: what has not come to the end of a line is one, and the last lines are in the log."""
        if self._rest:
            self._add_rest(self._tick)
        if self._left_out:
            last = [line for line in self._tail if line[1] == PRINTED][-self._left_out :]
            if between := self._left_out - len(last):
                self._new.append((self._tick, PRINTED, f"... {between} lines are left out"))
            self._new += last
            self._left_out = 0

    def died(self, tick: int, how: str) -> None:
        """The firmware is gone: the end, and a line that says how."""
        self.end()
        self._new.append((tick, ENDED, shown(how.encode())))

    def new_lines(self) -> list[PrintedLine]:
        """What is new in the log since the last call."""
        new, self._new = self._new, []
        return new

    def text(self) -> str:
        """The last that was printed, at most `TAIL_CHARACTERS`."""
        return "".join(f"{line}\n" for _, _, line in self._tail) + shown(self._rest)

    def close(self) -> None:
        """Let the file go."""
        os.close(self.file)

    def _add_rest(self, tick: int) -> None:
        rest, self._rest = self._rest, b""
        self._add(tick, shown(rest))

    def _add(self, tick: int, text: str) -> None:
        if self._watches_reports and _REPORT.match(text):
            self._in_report = True
        line, costs = (tick, "" if self._in_report else PRINTED, text), len(text) + LINE_COSTS
        self._tail.append(line)
        self._tail_characters += costs
        while self._tail_characters > TAIL_CHARACTERS:
            self._tail_characters -= len(self._tail.popleft()[2]) + LINE_COSTS
        if self._in_report:
            return
        if self._left_out or costs > self._room:
            self._left_out += 1
            return
        self._room -= costs
        self._new.append(line)
