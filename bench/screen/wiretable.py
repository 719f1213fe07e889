"""Every wire, every kind of frame on it: how many, how often, how old, what it says. Then the newest frames.

A row a CAN identifier, a SLAMWARE sub-command, a kind of RC frame. What the filter does not find is left out.
"""

from __future__ import annotations

from bench.io.wires.table import CAN, CORE, RC, Logged, WireRow, WireSum, WireTable
from bench.screen.scene import Scene
from bench.screen.text import (
    BAD_BADGE,
    GOOD,
    KEY,
    LABEL,
    PLAIN,
    TITLE,
    WARN,
    WARN_BADGE,
    Line,
    age,
    both_ends,
    counted,
    fill_bar,
    first_that_fits,
    fit,
    hexed,
    width_of,
)

NAMES = {RC: "rc", CAN: "can bus", CORE: "control bus"}
CROWDED = 0.8
"""From this load on a wire is said to be full: what comes at the same time must wait."""
WIDE_FROM = 110
"""From this width on there is room for bytes and counts."""
LEAST_LOG_ROWS = 4
LEAST_ABOUT = 17
FULL = " full"
SUM_WIDTH = 14 + 10 + 8 + 2 + 17
"""Of a wire's own line what always stands: its name, rate, load, a gap, and refused bytes by the thousand."""


def wiretable(scene: Scene, width: int, height: int) -> list[Line]:
    """Head, rows and newest frames."""
    table, shown = scene.seen.wires, scene.shown
    if table is None:
        return [[(" no tick has run yet", LABEL)]]
    wide = width >= WIDE_FROM
    lines = [_head(scene, wide, width)]
    about, bar = _room_for_sums(table, width)
    for one in table.sums:
        lines.append(_sum(scene, one, about, bar))
        rows = [row for row in table.rows if row.wire == one.wire and passes(shown.filter, row)]
        lines += [_row(row, table.tick, wide) for row in rows]
    room = max(height - LEAST_LOG_ROWS - 1, 1)
    if len(lines) > room:
        hidden = len(lines) - room + 1
        lines = [*lines[: room - 1], [(f" … {hidden} more rows: / filters, a taller terminal shows them", WARN)]]
    rest = height - len(lines) - 1
    if rest > 0:
        lines.append([(" newest frames, the last one lowest", LABEL)])
        lines += [_logged(one, wide) for one in table.log[-rest:]]
    return lines


def passes(filter: str, row: WireRow) -> bool:
    """Whether a row has one of the filter's words, which commas part."""
    words = [word for word in filter.lower().split(",") if word]
    text = f"{row.wire} {row.key} {row.name} {row.said}".lower()
    return not words or any(word in text for word in words)


def _head(scene: Scene, wide: bool, width: int) -> Line:
    shown = scene.shown
    columns = f" {'id':8} {'what':13} {'rate':>6} {'age':>6}"
    columns += f" {'load':>6} {'frames':>8}  {'bytes':23}  says" if wide else "  says"
    line: Line = [(columns, LABEL)]
    typing = shown.menu is not None and shown.menu.kind == "filter"
    if typing or shown.filter:
        line = [(" filter ", TITLE), (f" {shown.filter}", KEY), ("▏" if typing else "", KEY)]
        words = "  commas mean or; Enter keeps it, Esc shows all" if typing else "  / changes it"
        line.append((words, LABEL))
    if shown.held:
        badge, ways = (" HELD ", WARN_BADGE), (f" at {_at(scene.seen.wires)}, H lets go ", "H lets go", "")
        helds: list[Line] = [[badge, (words, WARN)] for words in ways]
        held = first_that_fits(helds, width - 2 - width_of(line)) or helds[-1]
        line = both_ends(line, held, width)  # behind the columns' names, so that they stand over their columns
    elif scene.seen.building is not None:
        line = building(scene)
    return line


def building(scene: Scene) -> Line:
    """What is shown is not of the instant in the title: its ticks are being run again."""
    assert scene.seen.building is not None
    words = f" BUILDING {scene.snapshot.tick / 1000:.3f} s AGAIN {100 * scene.seen.building:3.0f} % "
    return [(" ", PLAIN), (words, WARN_BADGE), (" below is what was shown before", WARN)]


def _at(table: WireTable | None) -> str:
    return f"{table.tick / 1000:.3f} s" if table is not None else ""


def _room_for_sums(table: WireTable, width: int) -> tuple[int, int]:
    """How wide what all wires are called and their bars may be, so that errors have room: bars go, then the words."""
    about = max([LEAST_ABOUT, *(len(one.about) for one in table.sums)]) + 1
    bar = 20 if width >= WIDE_FROM else 8
    rest = width - SUM_WIDTH - (len(FULL) if width >= WIDE_FROM else 0)
    return (about, bar) if about + bar <= rest else (about, 0) if about <= rest else (0, bar)


def _sum(scene: Scene, one: WireSum, about: int, bar: int) -> Line:
    full = one.load >= CROWDED
    line: Line = [
        (f" {NAMES[one.wire]:13}", KEY),
        (f"{one.about:{about}}" if about else "", LABEL),
        (f"{one.rate_hz:6.0f}/s  ", PLAIN),
        (fill_bar(one.load, bar), WARN if full else GOOD),
        (f" {100.0 * one.load:5.1f} %{FULL if bar > 8 else ''}", WARN if full else PLAIN),
    ]
    return [*line, ("  ", PLAIN), _errors(scene, one)]


def _errors(scene: Scene, one: WireSum) -> tuple[str, str]:
    strangers = len(scene.snapshot.bus_findings) if one.wire == CAN else 0
    if strangers or (one.wire == CAN and one.errors):
        more = f", {counted(one.errors, 'frame')} too many to list" if one.errors else ""
        return f" {strangers} strange{more} ", BAD_BADGE
    if one.errors:
        return f"{counted(one.errors, 'byte')} refused", WARN
    return "no errors", LABEL


def _row(row: WireRow, now: int, wide: bool) -> Line:
    line: Line = [
        (f" {row.key:8.8}", PLAIN),
        (f" {row.name:13.13}", LABEL),
        (f" {row.rate_hz:4.0f}/s {age(now - row.last_tick):>6}", PLAIN),
    ]
    if wide:
        line.append((f" {100.0 * row.load:4.1f} % {row.frames:8d}  ", PLAIN))
        line.append((f"{_bytes(row.data):23}", LABEL))
    return [*line, (f"  {row.said}", PLAIN)]


def _logged(one: Logged, wide: bool) -> Line:
    line: Line = [(f" {one.tick / 1000:9.3f}", LABEL), (f" {one.wire:4} {one.key:8.8}", PLAIN)]
    if wide:
        line.append((f" {_bytes(one.data):23}", LABEL))
    return [*line, (f"  {one.said}", PLAIN)]


def _bytes(data: bytes) -> str:
    return hexed(data) if len(data) <= 8 else hexed(data[:7]) + " …"


def loads(scene: Scene, width: int) -> list[Line]:
    """A line a wire, for a glance."""
    table = scene.seen.wires
    if table is None:
        return []
    return [
        fit(
            [
                (f" {one.wire:7}", LABEL),
                (f"{100.0 * one.load:5.1f} % full {one.rate_hz:5.0f}/s  ", PLAIN),
                _errors(scene, one),
            ],
            width,
        )
        for one in table.sums
    ]
