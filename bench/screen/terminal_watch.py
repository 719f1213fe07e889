"""Is somebody there? What a terminal's answers prove about its keys. Pure: times come in, what to write goes out.

A terminal on a dead connection says nothing, and neither does one on which a key is simply held. So the watch asks, in
every frame, where the cursor stands, having put it in a column that numbers the question. The answer comes in the same
stream as the keys, behind all that were pressed or released before it. So it proves three things:

* the terminal was alive, and what was held then was held: a held key may go on;
* whatever comes behind it was typed after its question left: a key behind a fresh answer is a fresh key;
* no fresh answer for `STALL_MS` means that nobody knows what the hands do: everything is let go.

The key releases of Kitty's protocol are asked for only where the terminal has said that it knows them, in time, and
used only where it has said that they are on. Programs that answer for a terminal that may be gone (tmux, screen,
zellij, wezterm's multiplexer) get no such trust: there, a key lives by its repeats.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from bench.screen.terminal_input import FLAG_EVENT_TYPES

STALL_MS = 400
"""An answer older than this, counted from its question, proves nothing any more."""
DETECTION_MS = 1000
"""So long a terminal has to say that it knows Kitty's protocol; one that takes longer is asked again."""
GIVE_UP_MS = 3000
"""A terminal that has answered nothing for so long since the start never will; it is asked no more."""
TAGS = 40
"""Questions that can be told apart: two seconds of them."""
TAG_ROW = 2
FLAG_ALL_KEYS = 8
FLAGS_WANTED = 27
"""All but alternate keys: unambiguous codes, event types, every key, the text that it types."""
ASK_KITTY = "\x1b[?u"
SET_KITTY = f"\x1b[={FLAGS_WANTED};1u"
IN_BETWEEN = ("TMUX", "STY", "ZELLIJ", "WEZTERM_PANE")
"""Environment variables of programs that answer in the terminal's place."""
_MS = 1_000_000


class TerminalWatch:
    """One terminal from the moment when the app takes it. Times are monotonic nanoseconds.

    `releases`: key releases are reported. `answers`: it has ever answered. `trusted`: it is not known that something
    else answers in its place. `round_trip_ms` is the last answer's.
    """

    def __init__(self, now_ns: int, environment: Mapping[str, str]) -> None:
        self.releases = False
        self.answers = False
        self.round_trip_ms: int | None = None
        self._started_ns = now_ns
        in_between = environment.get("TERM", "").startswith(("screen", "tmux"))
        self.trusted = not in_between and not any(environment.get(name) for name in IN_BETWEEN)
        self._kitty_asked = self._kitty_set = False
        self._kitty_since_ns = self._proven_ns = now_ns
        self._asked: deque[tuple[int, int]] = deque(maxlen=TAGS - 1)
        self._next_tag = 1

    def ask(self, now_ns: int, width: int) -> str:
        """What to write in this frame to a terminal of so many columns; empty where nothing is to be asked."""
        if not self.answers and now_ns - self._started_ns > GIVE_UP_MS * _MS:
            return ""
        kitty = ""
        if self.trusted and not self._kitty_asked:
            self._kitty_asked = True
            kitty = ASK_KITTY
        if self._asked and self.stalled(now_ns) and now_ns - self._asked[-1][1] < STALL_MS * _MS:
            return kitty  # a stalled connection is not filled with questions
        self._next_tag = self._next_tag % max(1, min(TAGS, width)) + 1
        self._asked.append((self._next_tag, now_ns))
        return f"{kitty}\x1b7\x1b[{TAG_ROW};{self._next_tag}H\x1b[6n\x1b8"  # the cursor is put back where it was

    def answered(self, row: int, column: int, now_ns: int) -> bool:
        """The cursor stands there. True if this answers one of our questions and is fresh."""
        if row != TAG_ROW:
            return False
        asked_ns = next((at for tag, at in self._asked if tag == column), None)
        if asked_ns is None:
            return False
        while self._asked[0][1] <= asked_ns:
            self._asked.popleft()
            if not self._asked:
                break
        self.answers = True
        self._proven_ns = asked_ns
        self.round_trip_ms = (now_ns - asked_ns) // _MS
        return not self.stalled(now_ns)

    def kitty(self, flags: int, now_ns: int) -> str:
        """The terminal knows Kitty's protocol; `flags` are on. What to write now."""
        if not self._kitty_asked:
            return ""
        if now_ns - self._kitty_since_ns > DETECTION_MS * _MS:  # perhaps this machine was busy just then
            self._kitty_asked, self._kitty_since_ns = False, now_ns
            return ""
        wanted = FLAG_EVENT_TYPES | FLAG_ALL_KEYS
        self.releases = flags & wanted == wanted
        if self.releases or self._kitty_set:
            return ""
        self._kitty_set = True
        return SET_KITTY + ASK_KITTY

    def age_ms(self, now_ns: int) -> int:
        """The oldest that a key can be which comes now, if the terminal answers at all."""
        return (now_ns - self._proven_ns) // _MS

    def stalled(self, now_ns: int) -> bool:
        """Whether a terminal that used to answer has fallen silent."""
        return self.answers and now_ns - self._proven_ns > STALL_MS * _MS
