"""Panels that take the room of others for a while: the keys, a run's summary, a terminal that is too small."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from bench.screen.layout import SMALLEST
from bench.screen.palette import WORK_KEYS
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
    ("M", "sticks for the mouse, or none"),
    ("I", "next: keys, gamepad, receiver"),
)
SEE_KEYS = (
    ("Tab 1-4", "drive, wires, scope, checks"),
    ("H", "hold the page still, let go"),
    ("/", "wires: filter the frames"),
    ("V", "scope: choose its signals"),
    ("N", "scope: trigger and time"),
)
SIGNS = (
    ("↗ ring", "robot, a line to its front"),
    ("+ ×", "odometry; here a wheel slid"),
    ("arc, dots", "pressed bumper; sensor beams"),
    ("◆ █", "wanted speed, a wheel's own"),
)
RUN_KEYS = (
    ("P", "pause, go on"),
    ("[ ]", "slower, faster"),
    ("Z", "follow the robot"),
    ("?", "this page; Esc, Ctrl-Q quit"),
)
LEASE_NOTE = "A key drives as long as it repeats: let go, and the sticks are at rest 120 ms later. A tap nudges."
HOLD_NOTE = "This terminal tells when a key is let go: it drives until then, as long as the terminal answers."
DRIVE_NOTES = (
    "Sticks at rest for half a second hand over to the core, if it is alive. A lost link disarms: arm again by hand.",
)
REPLAY_NOTES = ("This is a replay: what was recorded runs through the bench again, and no key changes it.",)
_KEY_WIDTH, _MEANING_WIDTH = 10, 30


def help_page(scene: Scene, width: int, height: int) -> list[Line]:
    """What the keys do, in two columns where there is room."""
    driving = scene.hands is not None
    sections: list[tuple[str, Sequence[tuple[str, str]]]] = [("driving", DRIVE_KEYS)] if driving else []
    sections += [("the run", RUN_KEYS), ("working", WORK_KEYS), ("looking", SEE_KEYS), ("signs", SIGNS)]
    cells = [cell for name, entries in sections for cell in _section(name, entries)]
    columns = max(1, min(len(sections), width // (_KEY_WIDTH + _MEANING_WIDTH)))
    each = -(-len(cells) // columns)
    lines: list[Line] = []
    for row in range(each):
        line: Line = []
        for column in range(columns):
            line += cells[column * each + row] if column * each + row < len(cells) else []
        lines.append(line)
    hands = scene.hands
    first = HOLD_NOTE if hands is not None and hands.releases else LEASE_NOTE
    for note in (first, *DRIVE_NOTES) if driving else REPLAY_NOTES:
        lines.append([("", PLAIN)])
        lines += [[(" " + part, LABEL)] for part in textwrap.wrap(note, width - 2)]
    return lines


def _section(name: str, entries: Sequence[tuple[str, str]]) -> list[Line]:
    """A heading and a line an entry, all of one width."""
    width = _KEY_WIDTH + _MEANING_WIDTH
    head: Line = [(f" {name}".ljust(width), TITLE)]
    return [
        head,
        *([(f" {key:{_KEY_WIDTH}}", KEY), (f"{meaning:{_MEANING_WIDTH - 1}}", PLAIN)] for key, meaning in entries),
    ]


def summary(scene: Scene, width: int, height: int) -> list[Line]:
    """What a run says of itself after its end."""
    assert scene.replay is not None
    lines: list[Line] = []
    for sentence in scene.replay.summary:
        parts = textwrap.wrap(sentence, width - 2, subsequent_indent=" " * 10, break_on_hyphens=False)
        lines += [[(" " + part, PLAIN)] for part in parts]
    return lines


def small(scene: Scene, width: int, height: int) -> list[Line]:
    """For a terminal that is too small to show everything that matters: as much of this as it has room for."""
    columns, rows = SMALLEST
    state = "armed" if scene.snapshot.armed else "disarmed"
    stop = "Space stops it, " if scene.hands is not None else ""
    short = "Space stops, " if scene.hands is not None else ""
    size = f"The dashboard needs {columns}x{rows}; this terminal is {width}x{height}."
    sentences = (
        f"{size} The robot is {state}; {stop}Esc quits.",
        f"Needs {columns}x{rows}, has {width}x{height}. Robot {state}. {short}Esc quits.",
        f"Needs {columns}x{rows}. {state.upper()}.",
    )
    parts = [textwrap.wrap(sentence, max(1, width)) for sentence in sentences]
    fitting = next((part for part in parts if len(part) <= height), parts[-1])
    return [[(part, PLAIN)] for part in fitting]
