"""Gives a terminal back when the program cannot: killed outright, it would leave a keyboard that types codes.

A shell waits at the end of a pipe. A word from us, and it goes in silence; an end without a word, and it writes what
sets the terminal right. It needs nothing of ours, so nothing of ours can break it.
"""

from __future__ import annotations

import subprocess
from contextlib import suppress

GIVE_BACK = "\x1b[<u\x1b[?1002l\x1b[?1006l\x1b[?2004l\x1b[?1004l\x1b[?7h\x1b[?25h\x1b[?1049l"
"""Keyboard protocol (its stack belongs to the screen, so it goes first), mouse, paste, focus, wrap, cursor, screen."""
_SCRIPT = """trap '' HUP INT QUIT TERM TSTP TTIN TTOU
read -r word || { printf %s "$1"; stty sane 0<&1; }"""
LAST_S = 1.0


class Guardian:
    """Watches over the terminal of that descriptor until told that all is well."""

    def __init__(self, descriptor: int) -> None:
        self._shell: subprocess.Popen[bytes] | None = None
        with suppress(OSError):  # no shell: then nobody watches
            self._shell = subprocess.Popen(
                ["sh", "-c", _SCRIPT, "sh", GIVE_BACK],
                stdin=subprocess.PIPE,
                stdout=descriptor,
                stderr=subprocess.DEVNULL,
            )

    def dismiss(self) -> None:
        """The terminal has been given back."""
        shell, self._shell = self._shell, None
        if shell is None:
            return
        with suppress(OSError, subprocess.TimeoutExpired):
            shell.communicate(b"well\n", timeout=LAST_S)
