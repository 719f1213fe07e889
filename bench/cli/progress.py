"""One live line on stderr for many runs: a bar, how many are done, which run and how far, how long it will take."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from bench.errors import spelt
from bench.io.clock import now_ns

BAR_WIDTH = 24
DRAW_EVERY_NS = 100_000_000
LEAST_SHARE = 0.02
"""Before so much is done, how long it will take is a guess."""


class Progress:
    """Draws where there is a terminal, and nothing elsewhere. `failed` is counted by whoever sees the results."""

    def __init__(self, names: Sequence[str], is_shown: bool) -> None:
        self.failed = 0
        self._names = [spelt(name) for name in names]
        self._is_shown = is_shown and sys.stderr.isatty()
        self._began_ns = now_ns()
        self._drawn_ns = 0

    def draw(self, shares: Sequence[float]) -> None:
        """Draw it anew, where the last picture is old enough."""
        now = now_ns()
        if not self._is_shown or now - self._drawn_ns < DRAW_EVERY_NS:
            return
        self._drawn_ns = now
        elapsed_s = (now - self._began_ns) / 1e9
        text = progress_line(self._names, shares, self.failed, elapsed_s, _columns() - 1)
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Take it away, before a line is printed and at the end."""
        if self._is_shown and self._drawn_ns:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
            self._drawn_ns = 0


def progress_line(names: Sequence[str], shares: Sequence[float], failed: int, elapsed_s: float, width: int) -> str:
    """`[####....] 3 of 12 done, 1 failed; about 12 s left; ice 40 %, push 10 %`, cut to the width."""
    total = sum(shares) / len(shares)
    done = sum(share >= 1.0 for share in shares)
    filled = int(total * BAR_WIDTH)
    text = f"[{'#' * filled}{'.' * (BAR_WIDTH - filled)}] {done} of {len(names)} done"
    if failed:
        text += f", {failed} failed"
    if total >= LEAST_SHARE:
        text += f"; about {elapsed_s * (1.0 - total) / total:.0f} s left"
    running = [f"{name} {100 * share:.0f} %" for name, share in zip(names, shares, strict=True) if 0.0 < share < 1.0]
    return "; ".join([text, ", ".join(running)])[:width] if running else text[:width]


def _columns() -> int:
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except OSError:
        return 80
