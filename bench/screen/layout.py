"""Which panel stands where, for every size of terminal. Panels never overlap, whatever the size.

title
progress                      (a replay only)
arena        status
wheels
wires
footer
"""

from __future__ import annotations

from typing import NamedTuple

SMALLEST = (60, 16)
STATUS_WIDTH = 45
STATUS_ROWS = 12
"""So many rows the status gets before the wires get any: all but its least important one."""
WIRES_ROWS = 5
ROOMY_FROM = 30
"""From this height on, sections stand apart and have headings."""
LEAST_ARENA_COLUMNS = 8

LIVE, HELP, ENDED = "live", "help", "ended"


class Place(NamedTuple):
    """A rectangle of cells."""

    x: int
    y: int
    width: int
    height: int


def arrange(
    width: int, height: int, *, wheels: int, aspect: float, replay: bool = False, page: str = LIVE
) -> dict[str, Place]:
    """Panel -> place. `aspect` is the field's length by its width; `page` is LIVE, HELP, or ENDED (a run's summary)."""
    if width < SMALLEST[0] or height < SMALLEST[1]:
        return {"small": Place(0, 0, width, height)}
    places = {"title": Place(0, 0, width, 1), "footer": Place(0, height - 1, width, 1)}
    y = 1
    if replay:
        places["progress"] = Place(0, y, width, 1)
        y += 1
    rows = height - 1 - y
    if page == HELP:
        places["help"] = Place(0, y, width, rows)
        return places
    gap = 1 if height >= ROOMY_FROM else 0
    wheel_rows = min(wheels + 1, rows // 2)
    wire_rows = max(0, min(WIRES_ROWS + gap, rows - wheel_rows - STATUS_ROWS))
    top = rows - wheel_rows - wire_rows - 2 * gap
    arena = _arena(width, y, top, aspect)
    if arena.width >= LEAST_ARENA_COLUMNS:
        places["arena"] = arena
    left = arena.width if "arena" in places else 0
    places["status"] = Place(left, y, width - left, top)
    y += top + gap
    if page == ENDED:
        places["summary"] = Place(0, y, width, height - 1 - y)
        return places
    places["wheels"] = Place(0, y, width, wheel_rows)
    y += wheel_rows + gap
    if wire_rows:
        places["wires"] = Place(0, y, width, wire_rows)
    return places


def _arena(width: int, y: int, rows: int, aspect: float) -> Place:
    """As large as height and the status beside it leave; a cell is twice as high as it is wide."""
    inner_rows = max(0, rows - 2)
    inner_columns = min(round(inner_rows * 2 * aspect), width - STATUS_WIDTH - 2)
    inner_rows = min(inner_rows, round(inner_columns / (2 * aspect)))
    return Place(0, y, inner_columns + 2, inner_rows + 2)
