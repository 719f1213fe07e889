"""What stands at the upper and lower edge of the screen: the pages by their keys, how to stop and to leave."""

from __future__ import annotations

from bench.screen.layout import PAGES
from bench.screen.text import BAD_BADGE, GOOD_BADGE, KEY, LABEL, PLAIN, TAB, TITLE, WARN_BADGE, Line, Span

HELP_AND_QUIT: Line = [("  ?", KEY), (" help", LABEL), ("  Esc", KEY), (" quit", LABEL)]
STOP: Span = (" SPACE STOP ", BAD_BADGE)
"""On every page and in every mode, in the same place."""
_ENTER = {
    True: (" ENTER disarm ", WARN_BADGE),
    False: (" ENTER arm    ", GOOD_BADGE),
    None: (" ENTER AUX1   ", WARN_BADGE),
}
"""Of a robot that is armed, of one that is not, and of one of which only itself knows."""


def tabs(open_page: str, marks: dict[str, str], *, long: bool) -> Line:
    """The pages by their keys, the open one marked, each with what is to be said of it."""
    line: Line = []
    for number, page in enumerate(PAGES, 1):
        is_open, mark = page == open_page, marks.get(page, "")
        words = f" {number} {page}{mark} " if long else f" {number}{mark} "
        line.append((f"[{words.strip()}]" if is_open else words, TAB if is_open else TITLE))
    return line


def hands_always(armed: bool | None, arms: bool) -> Line:
    """Where somebody drives: what Enter does, as large as a line can say it, and how to stop, to learn, to leave."""
    return [enter_does(armed, arms), (" ", LABEL), STOP, *HELP_AND_QUIT]


def enter_does(armed: bool | None, arms: bool) -> Span:
    """What Enter would do, in so many cells whatever it is; `arms`: whether it works the switch that arms."""
    badge = _ENTER[armed]
    return badge if arms else (" " * len(badge[0]), PLAIN)
