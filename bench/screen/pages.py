"""Panels that take the room of others for a while: the keys, a run's summary."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from itertools import product

from bench.screen.palette import WORK_KEYS
from bench.screen.scene import Scene
from bench.screen.text import KEY, LABEL, PLAIN, TALLER, TITLE, Line, cut_rows

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
    ("Z", "follow the robot"),
    ("H", "hold the page still, let go"),
    ("/", "wires: filter the frames"),
    ("V N", "scope: signals; trigger, time"),
)
SIGNS = (
    ("↗ ring", "robot, a line to its front"),
    ("+ ×", "odometry; here a wheel slid"),
    ("arc, dots", "pressed bumper; sensor beams"),
    ("◆ █", "wanted speed, a wheel's own"),
)
RUN_KEYS = (("P", "pause, go on"), ("[ ]", "slower, faster"))
LAST_KEYS = (("?", "this page; Esc, Ctrl-Q quit"),)
LEASE_NOTE = "A key drives while it repeats. Let go: 120 ms later the sticks are at rest."
HOLD_NOTE = "This terminal tells when a key is let go: it drives until then."
DRIVE_NOTES = (
    "Sticks at rest for half a second hand over to the core, if it is alive.",
    "A lost link disarms, and stays disarmed until you arm again.",
)
REPLAY_NOTES = ("A replay: what was recorded runs through the bench again; no key changes it.",)
_KEY_WIDTH, _MEANING_WIDTH = 10, 30
_BLANK: Line = [(" " * (_KEY_WIDTH + _MEANING_WIDTH), PLAIN)]
KEYS_SIZE = (80, 24)
"""From this size on the page of keys is whole."""


def help_page(scene: Scene, width: int, height: int) -> list[Line]:
    """What the keys do, each section whole, in as many columns as there is room for; then what is worth knowing."""
    driving = scene.hands is not None
    sections = [_section("driving", DRIVE_KEYS)] if driving else []
    sections += [
        _section("looking", SEE_KEYS),
        _section("the run", (*RUN_KEYS, *WORK_KEYS, *LAST_KEYS)),
        _section("signs", SIGNS),
    ]
    columns = _columns(sections, max(1, width // (_KEY_WIDTH + _MEANING_WIDTH)))
    lines: list[Line] = []
    for row in range(max(map(len, columns))):
        lines.append([span for column in columns for span in (column[row] if row < len(column) else _BLANK)])
    first = HOLD_NOTE if scene.hands is not None and scene.hands.releases else LEASE_NOTE
    notes: list[Line] = [[("", PLAIN)]]
    for note in (first, *DRIVE_NOTES) if driving else REPLAY_NOTES:
        notes += [[(" " + part, LABEL)] for part in textwrap.wrap(note, width - 2)]
    lines += notes
    return cut_rows(lines, height, f"{KEYS_SIZE[0]}x{KEYS_SIZE[1]} shows them")


def _columns(sections: Sequence[list[Line]], most: int) -> list[list[Line]]:
    """The sections in their order, shared out so that the longest column is as short as can be."""
    best: list[list[Line]] = []
    for places in product(range(most), repeat=len(sections)):
        columns: list[list[Line]] = [[] for _ in range(most)]
        for place, section in zip(places, sections, strict=True):
            columns[place] += section
        if not best or max(map(len, columns)) < max(map(len, best)):
            best = columns
    return best


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
    return cut_rows(lines, height, TALLER)
