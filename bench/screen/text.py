"""Lines made of words with a role, numbers that keep their width, and bars. A role is a meaning, not a colour.

Every meaning stands in the words or signs too, so that a picture without colour says the same.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import takewhile
from operator import itemgetter
from typing import TypeAlias

PLAIN, LABEL, TITLE, KEY = "plain", "label", "title", "key"
GOOD, WARN = "good", "warn"
GOOD_BADGE, WARN_BADGE, BAD_BADGE = "good badge", "warn badge", "bad badge"
TAB = "tab"
"""The page that is open, in the title."""
ROBOT, GHOST, TRAIL, GRID = "robot", "ghost", "trail", "grid"
TRACE, OTHER_TRACE = "trace", "other trace"
ROLES = (
    PLAIN, LABEL, TITLE, TAB, KEY, GOOD, WARN, GOOD_BADGE, WARN_BADGE, BAD_BADGE, ROBOT, GHOST, TRAIL, GRID,
    TRACE, OTHER_TRACE,
)  # fmt: skip

Span: TypeAlias = tuple[str, str]
"""Text and its role. Only characters that are one cell wide."""
Line: TypeAlias = list[Span]

BLOCKS = " ▏▎▍▌▋▊▉█"
_WORDS = itemgetter(0)
ELLIPSIS, NO_BREAK = "…", "\N{NO-BREAK SPACE}"
NAME_WIDTH = 12
"""Of a wheel's name."""
TALLER = "a taller terminal shows them"
LONGEST_WORD = 20
"""What is longer is no word, and may be cut: a path, bytes."""


def plain(line: Line) -> str:
    """The words alone."""
    return "".join(map(_WORDS, line))


def width_of(line: Line) -> int:
    """How many cells the line takes."""
    return len("".join(map(_WORDS, line)))


def fit(line: Line, width: int, fill: str = PLAIN) -> Line:
    """Exactly so wide: padded with blanks; or as many whole words as there is room for, and an ellipsis."""
    have = width_of(line)
    if have <= width:
        return [*line, (" " * (width - have), fill)] if have < width else line
    room = _whole_words(plain(line), width - len(ELLIPSIS))
    blanks, end = width - room - len(ELLIPSIS), ELLIPSIS * min(1, width)
    out: Line = []
    for text, role in line:
        if len(text) >= room:
            out.append((text[:room] + end, role))
            break
        out.append((text, role))
        room -= len(text)
    return [*out, (" " * blanks, fill)] if blanks > 0 else out


def _whole_words(text: str, room: int) -> int:
    """How many characters to keep of a text that is too long, so that no word is cut, nor looks as if it were."""
    room = max(0, room)
    begins = text.rfind(" ", 0, room) + 1
    return begins if room < begins + LONGEST_WORD else room


def first_that_fits(lines: Iterable[Line], width: int) -> Line:
    """Of several ways to say it, from many words to few, the first that there is room for; else nothing."""
    return next((line for line in lines if width_of(line) <= width), [])


@lru_cache(maxsize=8)
def short_names(names: tuple[str, ...], width: int = NAME_WIDTH) -> tuple[str, ...]:
    """Names for one column: where one is too long, without the words with which all begin or end, and cut at last."""
    if max(map(len, names), default=0) > width:
        first, last = _shared(names), _shared([name[::-1] for name in names])
        own = tuple(name[first : len(name) - last] for name in names)
        names = own if all(own) else names
    return tuple(name if len(name) <= width else name[: width - 1] + ELLIPSIS for name in names)


def _shared(names: Sequence[str]) -> int:
    """How many characters the words take with which all of them begin."""
    same = sum(1 for _ in takewhile(lambda letters: len(set(letters)) == 1, zip(*names, strict=False)))
    found = re.match(r".*[\W_]", names[0][:same])
    return found.end() if found is not None else 0


def both_ends(left: Line, right: Line, width: int, fill: str = PLAIN) -> Line:
    """Left and right, two blanks between at least; where there is no room for both, the left is cut."""
    room = width - width_of(right) - 2
    if room < 0:
        return fit(right, width, fill)
    return [*fit(left, room, fill), ("  ", fill), *right]


def cut_rows(lines: list[Line], height: int, elsewhere: str) -> list[Line]:
    """As many as there is room for; the last one then says how many more there are, and what shows them."""
    if len(lines) <= height:
        return lines
    return [*lines[: height - 1], [(f" … {len(lines) - height + 1} more lines: {elsewhere}", WARN)]]


def counted(count: int, thing: str) -> str:
    """So many of them."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"


def age(milliseconds: int) -> str:
    """How long ago, in at most seven cells."""
    if milliseconds < 1000:
        return f"{milliseconds} ms"
    return f"{milliseconds / 1000:.1f} s" if milliseconds < 100_000 else f"{milliseconds // 1000} s"


def hexed(data: bytes) -> str:
    """Bytes as people read them."""
    return data.hex(" ").upper()


def signed(value: float, width: int, decimals: int) -> str:
    """A number with its sign, right-aligned; what rounds to zero has a plus; what does not fit is cut to `>`."""
    text = f"{value:+.{decimals}f}"
    if text[0] == "-" and float(text) == 0.0:
        text = "+" + text[1:]
    return text.rjust(width) if len(text) <= width else (text[0] + ">" * (width - 1))


def swing_bar(value: float, wanted: float, limit: float, width: int) -> str:
    """A bar from the middle to either side, with a mark where it should be: `·····│███▍··◆·`. Odd widths are even."""
    half = max(1, (width - 1) // 2)
    length = round(min(1.0, abs(value) / limit) * half)
    bar, rest, empty = "█" * length, "·" * (half - length), "·" * half
    cells = f"{empty}│{bar}{rest}" if value >= 0 else f"{rest}{bar}│{empty}"
    place = half + round(max(-1.0, min(1.0, wanted / limit)) * half)
    return f"{cells[:place]}◆{cells[place + 1 :]}" if place != half else cells


def fill_bar(share: float, width: int) -> str:
    """A bar from the left, in eighths of a cell, on dots."""
    eighths = round(max(0.0, min(1.0, share)) * width * 8)
    full, part = divmod(eighths, 8)
    bar = "█" * full + (BLOCKS[part] if part else "")
    return bar + "·" * (width - len(bar))
