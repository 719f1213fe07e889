"""Panels that take the room of others for a while: the keys, a run's summary, a terminal that is too small."""

from __future__ import annotations

import textwrap

from bench.screen.layout import SMALLEST
from bench.screen.scene import Scene
from bench.screen.text import KEY, LABEL, PLAIN, TITLE, Line

DRIVE_KEYS = (
    ("W S  ↑ ↓", "forward, back"),
    ("A D  ← →", "left, right"),
    ("Q E", "turn left, turn right"),
    ("+ -", "how far a key pushes"),
    ("Enter", "arm, disarm (AUX1)"),
    ("Space", "stop: sticks to rest, disarm"),
    ("F", "field-centric on, off (AUX2)"),
    ("T", "transmitter off, on"),
    ("C", "core asks for an arc, or not"),
)
RUN_KEYS = (
    ("P", "pause, go on"),
    ("[ ]", "slower, faster"),
    ("Z", "follow the robot"),
    ("?", "this page; Esc, Ctrl-Q quit"),
)
DRIVE_NOTES = (
    "A key drives as long as it repeats: let go, and the sticks are at rest 120 ms later. A tap nudges.",
    "Sticks at rest for half a second hand over to the core, if it is alive. A lost link disarms: arm again by hand.",
)
REPLAY_NOTES = ("This is a replay: what was recorded runs through the bench again, and no key changes it.",)
_KEY_WIDTH = 10


def help_page(scene: Scene, width: int, height: int) -> list[Line]:
    """What the keys do, in two columns where there is room."""
    driving = scene.hands is not None
    keys = (DRIVE_KEYS if driving else ()) + RUN_KEYS
    column = 1 + max(len(meaning) for _, meaning in keys)
    cells: list[Line] = [[(f" {key:{_KEY_WIDTH}}", KEY), (f"{meaning:{column}}", PLAIN)] for key, meaning in keys]
    if width >= 2 * (1 + _KEY_WIDTH + column):
        half = (len(cells) + 1) // 2
        right: list[Line] = [*cells[half:], []]
        cells = [one + other for one, other in zip(cells[:half], right, strict=False)]
    lines: list[Line] = [[(" keys", TITLE)], *cells]
    for note in DRIVE_NOTES if driving else REPLAY_NOTES:
        lines.append([("", PLAIN)])
        lines += [[(" " + part, LABEL)] for part in textwrap.wrap(note, width - 2)]
    return lines


def summary(scene: Scene, width: int, height: int) -> list[Line]:
    """What a run says of itself after its end."""
    assert scene.replay is not None
    lines: list[Line] = []
    for sentence in scene.replay.summary:
        parts = textwrap.wrap(sentence, width - 2, subsequent_indent=" " * 10, break_on_hyphens=False)
        lines += [[(" " + part, PLAIN)] for part in parts]
    return lines


def small(scene: Scene, width: int, height: int) -> list[Line]:
    """For a terminal that is too small to show everything that matters."""
    columns, rows = SMALLEST
    state = "armed" if scene.snapshot.armed else "disarmed"
    stop = "Space stops it, " if scene.hands is not None else ""
    size = f"The dashboard needs {columns}x{rows}; this terminal is {width}x{height}."
    text = f"{size} The robot is {state}; {stop}Esc quits."
    return [[(part, PLAIN)] for part in textwrap.wrap(text, max(1, width))]
