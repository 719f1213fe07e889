"""A list to choose from, over the other panels: type to narrow it, Enter takes, Esc leaves. Space stays the stop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from bench.screen.layout import Place
from bench.screen.text import KEY, LABEL, PLAIN, TITLE, WARN, Line, both_ends, fit

if TYPE_CHECKING:
    from bench.screen.scene import Scene

MOST_WIDTH, MOST_ROWS = 74, 22
APART_FROM = 100
"""On a screen of this width the list leaves a margin; on a narrower one it would only cut the words beside it."""
AROUND_ROWS = 3
"""Those of the frame, and what is typed."""
PAGE = 10


@dataclass(frozen=True, slots=True)
class Item:
    """One line to choose: words, a key or a note at the right, and what it does; the answer is a sentence."""

    words: str
    note: str
    take: Callable[[], str]


@dataclass(frozen=True, slots=True)
class Shown:
    """A dialog as it is to be drawn: `rows` fit the filter, `cursor` is one of them."""

    title: str
    typed: str
    rows: tuple[tuple[str, str], ...]
    cursor: int
    foot: str


class Dialog:
    """The state of an open list. `adjust` is what Left and Right do, and gives the foot's words."""

    def __init__(
        self, title: str, items: Sequence[Item], foot: str = "", adjust: Callable[[int], str] | None = None
    ) -> None:
        self.title = title
        self.open = True
        self._items = tuple(items)
        self._fitting = self._items
        self._typed = ""
        self._cursor = 0
        self._foot = foot
        self._adjust = adjust

    @property
    def shown(self) -> Shown:
        """What is to be drawn."""
        rows = tuple((item.words, item.note) for item in self._fitting)
        return Shown(self.title, self._typed, rows, self._cursor, self._foot)

    def key(self, key: str) -> str:
        """A key while the list is open: every one is taken. Gives what is to be said."""
        if key in ("escape", "ctrl+p"):
            self.open = False
        elif key == "enter" and self._fitting:
            self.open = False
            return self._fitting[self._cursor].take()
        elif key in ("up", "down", "pageup", "pagedown", "home", "end", "tab"):
            self._move(key)
        elif key in ("left", "right") and self._adjust is not None:
            self._foot = self._adjust(1 if key == "right" else -1)
        elif key == "backspace":
            self._type(self._typed[:-1])
        elif len(key) == 1:
            self._type(self._typed + key)
        return ""

    def _move(self, key: str) -> None:
        count = len(self._fitting)
        steps = {"up": -1, "down": 1, "tab": 1, "pageup": -PAGE, "pagedown": PAGE, "home": -count, "end": count}
        self._cursor = max(0, min(count - 1, self._cursor + steps[key]))

    def _type(self, typed: str) -> None:
        self._typed, self._cursor = typed, 0
        scored = [(fits(typed, item.words), place, item) for place, item in enumerate(self._items)]
        kept = [(score, place, item) for score, place, item in scored if score is not None]
        self._fitting = tuple(item for _, _, item in sorted(kept, key=lambda one: one[:2]))


def fits(typed: str, words: str) -> int | None:
    """How well letters fit words, 0 best; None where they do not stand in them in this order."""
    words, typed = words.lower(), typed.lower().replace(" ", "")
    best: int | None = None
    for start in range(len(words)) if typed else ():
        if words[start] != typed[0]:
            continue
        at, gaps = start, 0
        for letter in typed[1:]:
            found = words.find(letter, at + 1)
            if found < 0:
                break
            begins_word = not words[found - 1].isalnum()
            gaps += 0 if found == at + 1 else 1 if begins_word else 2 + found - at
            at = found
        else:
            score = gaps * 4 + (0 if start == 0 or not words[start - 1].isalnum() else 3)
            best = score if best is None else min(best, score)
    return best if typed else 0


def dialog_place(width: int, height: int, rows: int) -> Place:
    """In the middle, over the other panels; title and keys stay in sight."""
    wide = MOST_WIDTH if width >= APART_FROM else width
    high = max(5, min(MOST_ROWS, rows + AROUND_ROWS, height - 4))
    return Place((width - wide) // 2, max(1, (height - high) // 2), wide, high)


def dialog(scene: Scene, width: int, height: int) -> list[Line]:
    """A frame with title, filter, as many rows as fit, and a foot."""
    shown = scene.dialog
    assert shown is not None
    inner, room = width - 2, height - AROUND_ROWS
    first = max(0, min(shown.cursor - room // 2, len(shown.rows) - room))
    body: list[Line] = [[(" > ", KEY), (shown.typed, PLAIN), ("▏", KEY)]]
    for number, (words, note) in list(enumerate(shown.rows))[first : first + room]:
        here = number == shown.cursor
        role = TITLE if here else PLAIN
        left: Line = [("▶ " if here else "  ", role), (words, role)]
        body.append(both_ends(left, [(note + " ", TITLE if here else KEY)], inner, role))
    if not shown.rows:
        body.append([("  nothing fits; Backspace takes a letter back", WARN)])
    body += [[]] * (height - 2 - len(body))
    title = f" {shown.title} "
    more = f" {shown.cursor + 1} of {len(shown.rows)} " if shown.rows else ""
    foot = _shortened(shown.foot or "Esc leaves · Enter takes · type to narrow", inner - 2)
    top = _edge("┌", (title, TITLE), more, "┐", inner)
    bottom = _edge("└", (f" {foot} ", LABEL), "", "┘", inner)
    return [top, *([("│", LABEL), *fit(line, inner), ("│", LABEL)] for line in body), bottom]


def _shortened(foot: str, room: int) -> str:
    """Without its last parts, where it is too long."""
    while len(foot) > room and " · " in foot:
        foot = foot.rpartition(" · ")[0]
    return foot


def _edge(left: str, words: tuple[str, str], right: str, corner: str, inner: int) -> Line:
    """A side of the frame. What it has to say is cut for want of room, its end left out before that."""
    if len(words[0]) + len(right) > inner:
        right = ""
    if len(words[0]) > inner:
        return [(left, LABEL), *fit([words], inner), (corner, LABEL)]
    return [(left, LABEL), words, ("─" * (inner - len(words[0]) - len(right)) + right + corner, LABEL)]
