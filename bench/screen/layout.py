"""Which panel stands where, for every page and size of terminal. Panels never overlap, whatever the size.

drive      title             wires, scope, checks      title
           progress*                                   progress*
           arena   status                              strip       armed, link, sticks: on every page
                   glance**                            wiretable, scope or checks
           wheels                                      footer
           wires
           footer

* a replay only    ** where there is room; and where there is still more, the scope and all the wires as well
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

PAD_ROWS = 9
SMALLEST = (60, 16)
STATUS_WIDTH = 45
STATUS_ROWS = 12
"""So many rows the status gets before the wires get any: all but its least important one."""
STATUS_FULL_ROWS = 16
"""With its groups apart; what is more goes to the glance."""
GLANCE_ROWS = 5
WIRES_ROWS = 5
ROOMY_FROM = 30
"""From this height on, sections stand apart and have headings."""
LEAST_ARENA_COLUMNS, LEAST_ARENA_ROWS = 8, 5
SMALL_ROWS = 11
"""So many rows the words of a small terminal get before there is an arena above them."""
LEAST_LIST = (30, 10)
"""A terminal as small as this has room for a list to choose from."""
WIDE = (170, 50)
"""From this size on, the drive page has everything."""
WIDE_TABLE_SHARE = 0.4

DRIVE, WIRES, SCOPE, CHECKS = "drive", "wires", "scope", "checks"
PAGES = (DRIVE, WIRES, SCOPE, CHECKS)
"""In the order of their keys, 1 first."""
_BODY = {WIRES: "wiretable", SCOPE: "scope", CHECKS: "checks"}

PANELS = (
    "title", "progress", "arena", "status", "glance", "wheels", "wires", "strip", "wiretable", "scope", "checks", "pad",
    "footer", "help", "summary", "small", "dialog", "notice",
)  # fmt: skip
"""All there are, in the order in which they are drawn."""
OVER = ("dialog", "notice")
"""Those that lie over others, and so come last."""

LIVE, HELP, ENDED = "live", "help", "ended"


class Place(NamedTuple):
    """A rectangle of cells."""

    x: int
    y: int
    width: int
    height: int


def is_wide(width: int, height: int) -> bool:
    """Whether the drive page has room for everything."""
    return width >= WIDE[0] and height >= WIDE[1]


def panes(page: str, width: int, height: int) -> set[str]:
    """What of the wires and signals a page shows at this size, and so has to be sampled."""
    if page != DRIVE:
        return {_BODY[page]}
    return {"wiretable", "scope", "glance"} if is_wide(width, height) else {"glance"}


@lru_cache(maxsize=8)
def arrange(
    width: int,
    height: int,
    *,
    wheels: int,
    aspect: float,
    replay: bool = False,
    state: str = LIVE,
    page: str = DRIVE,
    pad: bool = False,
    strip_rows: int = 1,
) -> Mapping[str, Place]:
    """Panel -> place. `aspect` is the field's length by its width; `state` is LIVE, HELP, or ENDED (with a summary).

    `pad`: the mouse's sticks take the foot of whatever page. `strip_rows`: what the line of every page takes.
    """
    if width < SMALLEST[0] or height < SMALLEST[1]:
        return _small(width, height, aspect)
    places = {"title": Place(0, 0, width, 1), "footer": Place(0, height - 1, width, 1)}
    y = 1
    if replay:
        places["progress"] = Place(0, y, width, 1)
        y += 1
    rest = Place(0, y, width, height - 1 - y)
    if pad and state == LIVE:
        rows = min(PAD_ROWS, rest.height // 2)
        places["pad"] = Place(0, rest.y + rest.height - rows, width, rows)
        rest = rest._replace(height=rest.height - rows)
        height -= rows
    if state == HELP:
        return places | {"help": rest}
    if page != DRIVE:
        body = rest._replace(y=y + strip_rows, height=rest.height - strip_rows)
        return places | {"strip": rest._replace(height=strip_rows), _BODY[page]: body}
    if is_wide(width, height) and state == LIVE:
        return places | _wide(rest, wheels, aspect)
    return places | _drive(rest, height, wheels, aspect, state)


def _small(width: int, height: int, aspect: float) -> dict[str, Place]:
    """The words, and the arena where they leave room for it: beside them, or above."""
    room = Place(0, 0, width, height)
    if width >= SMALLEST[0]:
        places = _arena_and_status(room, aspect)
        return {"small" if name == "status" else name: place for name, place in places.items()}
    rows = min(height - SMALL_ROWS, round((width - 2) / (2 * aspect)) + 2)
    if rows < LEAST_ARENA_ROWS or width < LEAST_ARENA_COLUMNS:
        return {"small": room}
    return {"arena": Place(0, 0, width, rows), "small": Place(0, rows, width, height - rows)}


def small_with_list(width: int, height: int) -> dict[str, Place]:
    """A list over the words of a small terminal, all but the first three rows and the last; {} where it has no room."""
    if width < LEAST_LIST[0] or height < LEAST_LIST[1]:
        return {}
    return {"small": Place(0, 0, width, height), "dialog": Place(0, 3, width, height - 4)}


def _drive(room: Place, height: int, wheels: int, aspect: float, state: str) -> dict[str, Place]:
    gap = 1 if height >= ROOMY_FROM else 0
    wheel_rows = min(wheels + 1, room.height // 2)
    wire_rows = max(0, min(WIRES_ROWS + gap, room.height - wheel_rows - STATUS_ROWS))
    top = room.height - wheel_rows - wire_rows - 2 * gap
    places = _arena_and_status(room._replace(height=top), aspect)
    y = room.y + top + gap
    if state == ENDED:
        return places | {"summary": Place(0, y, room.width, room.y + room.height - y)}
    places["wheels"] = Place(0, y, room.width, wheel_rows)
    y += wheel_rows + gap
    if wire_rows:
        places["wires"] = Place(0, y, room.width, wire_rows)
    return places


def _wide(room: Place, wheels: int, aspect: float) -> dict[str, Place]:
    """Arena and status above the wheels, the scope beside them; below, all the wires."""
    table_rows = round(room.height * WIDE_TABLE_SHARE)
    wheel_rows = min(wheels + 1, room.height // 4)
    top = room.height - table_rows - wheel_rows - 2
    places = _arena_and_status(room._replace(width=room.width * 2 // 3, height=top), aspect)
    left = places["status"].x + STATUS_WIDTH + 1
    for name in ("status", "glance"):
        if name in places:
            places[name] = places[name]._replace(width=STATUS_WIDTH)
    places["scope"] = Place(left, room.y, room.width - left, top + 1 + wheel_rows)
    y = room.y + top + 1
    places["wheels"] = Place(0, y, left - 1, wheel_rows)
    y += wheel_rows + 1
    places["wiretable"] = Place(0, y, room.width, room.y + room.height - y)
    return places


def _arena_and_status(room: Place, aspect: float) -> dict[str, Place]:
    """The arena as large as height and the status beside it leave; a cell is twice as high as it is wide."""
    inner_rows = max(0, room.height - 2)
    inner_columns = min(round(inner_rows * 2 * aspect), room.width - STATUS_WIDTH - 2)
    inner_rows = min(inner_rows, round(inner_columns / (2 * aspect)))
    places = {}
    arena = Place(0, room.y, inner_columns + 2, inner_rows + 2)
    if arena.width >= LEAST_ARENA_COLUMNS:
        places["arena"] = arena
    left = arena.width if "arena" in places else 0
    places["status"] = Place(left, room.y, room.width - left, room.height)
    if room.height >= STATUS_FULL_ROWS + 1 + GLANCE_ROWS:
        places["status"] = places["status"]._replace(height=STATUS_FULL_ROWS)
        y = room.y + STATUS_FULL_ROWS + 1
        places["glance"] = Place(left, y, room.width - left, room.y + room.height - y)
    return places
