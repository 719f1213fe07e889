"""The one-line panels: title, a replay's progress, the keys."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from bench.screen.checks import red_lamps
from bench.screen.edges import HELP_AND_QUIT, hands_always, tabs
from bench.screen.layout import CHECKS, DRIVE, WIRES
from bench.screen.scene import Hands, Scene
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
    fill_bar,
    short_names,
    width_of,
)

MOST_ROWS = 3
"""Of sentences above the foot."""
_LOOK = {DRIVE: (("Z", "follow"),), WIRES: (("/", "filter"),)}
"""A page's own key; the scope names its own above itself."""
LEAST_NAME = 10
"""So much of a name is shown before the pages are left out for it."""


def title(scene: Scene, width: int, height: int) -> list[Line]:
    """What runs, which page is open, and how time runs."""
    robot = scene.robot
    told = f" {scene.replay.title}" if scene.replay is not None else ""
    doing = f"  ● REC {scene.recording}" if scene.recording else ""
    doing += f"  SAVING {scene.saving}" if scene.saving else ""
    transmitter = robot.rc.name if robot.rc else "no RC"
    short = "  ● REC" * bool(scene.recording) + "  SAVING" * bool(scene.saving)
    name = f"{told} {robot.name}"
    names = (f"{name}, {transmitter}{doing}", f"{name}{doing}")
    return [_title(scene, names, width) or _cut_title(scene, name, short, width)]


def _title(scene: Scene, names: Sequence[str], width: int) -> Line:
    """Name, pages, time. Where there is no room lateness goes, then pages go to their numbers, then the transmitter;
    that time was left out matters more than the transmitter. Nothing where that is not enough.
    """
    times = _, slipped, bare = _times(scene)
    ways = [(name, long, right) for name in names for long in (True, False) for right in times]
    for long in (True, False) if slipped != bare else ():
        ways.insert(ways.index((names[0], long, bare)), (names[-1], long, slipped))
    for name, long, right in ways:
        line = [(name, TITLE), ("  ", TITLE), *_tabs(scene, long=long)]
        if width_of(line) + 2 + width_of(right) <= width:
            return both_ends(line, right, width, TITLE)
    return []


def _cut_title(scene: Scene, name: str, doing: str, width: int) -> Line:
    """What a recording is called goes, then the end of a long name; the pages where next to nothing of it is left."""
    pages, (*_, times) = _tabs(scene, long=False), _times(scene)
    room = width - len(doing) - 2 - width_of(pages) - 2 - width_of(times)
    if room < min(LEAST_NAME, len(name)):
        return both_ends([(name + doing, TITLE)], times, width, TITLE)
    (cut,) = short_names((name,), room)
    return both_ends([(f"{cut}{doing}  ", TITLE), *pages], times, width, TITLE)


def _tabs(scene: Scene, *, long: bool) -> Line:
    return tabs(scene.shown.page, {CHECKS: "✗"} if red_lamps(scene) else {}, long=long)


def _times(scene: Scene) -> tuple[Line, Line, Line]:
    """How time runs: with its lateness, with the time alone that was left out, without either."""
    pace = scene.pace
    rate = pace.rate if pace.speed is None else pace.speed
    speed = (f" ×{rate:.2f}".ljust(8), TITLE)
    if pace.behind_ticks:
        speed = (f" BACK {pace.behind_ticks / 1000:.3f} s ", WARN_BADGE)
    elif pace.paused:
        speed = (" PAUSED ", WARN_BADGE)
    elif scene.replay is not None and scene.replay.summary:
        speed = (" ENDED  ", WARN_BADGE)
    time = f"{scene.snapshot.tick / 1000:.3f} s "
    late = f" late {pace.late_ticks:3d} ms, slipped {pace.slipped_ticks} ms "
    slipped = f" slipped {age(pace.slipped_ticks)} " if pace.slipped_ticks else " "
    late_line, slipped_line, bare = ([(time, TITLE), speed, (words, TITLE)] for words in (late, slipped, " "))
    return late_line, slipped_line, bare


def progress(scene: Scene, width: int, height: int) -> list[Line]:
    """How far a replay has come, and what its golden says."""
    replay = scene.replay
    assert replay is not None
    done, all_of_it = scene.snapshot.tick, max(1, replay.ticks)
    # On a narrow screen the verdict needs the room.
    bar = fill_bar(done / all_of_it, width // 12 if width < 100 else width // 5)
    position = f"{done / 1000:.1f} of {all_of_it / 1000:.1f} s  "
    role, mark = _verdict(replay.verdict)
    verdict = (f"{mark} {replay.verdict} ", role) if replay.verdict else ("no golden to compare with", LABEL)
    return [[(f" {bar} ", PLAIN), (position, LABEL), verdict]]


def footer(scene: Scene, width: int, height: int) -> list[Line]:
    """The keys, or for a moment a sentence about the last one. How to stop is always there."""
    hands = scene.hands
    always = _always(scene)
    if scene.notice and not notice_rows(scene, width):
        return [both_ends([(" " + scene.notice, WARN)], always, width)]
    look = _LOOK.get(scene.shown.page, ())
    lines = _keys_of_time(scene) or (_watch_keys(look) if hands is None else _drive_keys(hands, look))
    room = width - 2 - width_of(always)
    return [both_ends(next((line for line in lines if width_of(line) <= room), lines[-1]), always, width)]


def _keys_of_time(scene: Scene) -> list[Line]:
    """Where it stands still: the keys of time that this run has, from many words to few."""
    if scene.replay is not None and scene.replay.summary:
        ways = ("drive on from here", "fork") if scene.pace.goes_back else ()
        return [_keys(("← →", "go back in it"), ("G", way)) for way in ways] or [[]]
    if not scene.pace.paused and not scene.pace.behind_ticks:
        return []
    step, on = [(".", "one tick on")] if scene.pace.steps else [], ("P", "go on")
    if not scene.pace.goes_back:
        return [_keys(*step, on), _keys(on)]
    long = _keys(("← →", "0.1 s"), ("↑ ↓", "1 s"), (", .", "tick"), ("G", "drive on from here"), on)
    return [long, _keys(("← → , .", "time"), ("G", "fork"), ("P", "on")), _keys(on)]


def _watch_keys(look: Sequence[tuple[str, str]]) -> list[Line]:
    return [_keys(("P", "pause"), ("[ ]", "slower, faster"), *look), _keys(("P", "pause"))]


def notice_rows(scene: Scene, width: int) -> int:
    """How many rows above the footer a sentence takes that is too long for it."""
    return len(_wrapped(scene, width))


def notice(scene: Scene, width: int, height: int) -> list[Line]:
    """A sentence that the footer has no room for."""
    return [[(" " + part, WARN)] for part in _wrapped(scene, width)]


def source_state(hands: Hands | None) -> str:
    """Why what has the sticks does not drive, in words."""
    return f"{hands.source}: {hands.source_state}" if hands and hands.source != "keys" and hands.source_state else ""


def _wrapped(scene: Scene, width: int) -> list[str]:
    """A notice goes by, so it may have more room than how a source is, which stays, and is told below it."""
    room = width - 3 - width_of(_always(scene))
    notice = scene.notice if len(scene.notice) > room else ""
    state = source_state(scene.hands) if not _keys_of_time(scene) and notice == scene.notice else ""
    state = state if len(state) > room - 2 else ""
    sentences = ((notice, MOST_ROWS - bool(state)), (state, 1))
    return [row for text, rows in sentences for row in _rows(text, width, rows)]


def _rows(text: str, width: int, most: int) -> list[str]:
    return textwrap.wrap(text, max(10, width - 2), max_lines=most, placeholder=" …", break_on_hyphens=False)


def _always(scene: Scene) -> Line:
    hands = scene.hands
    return HELP_AND_QUIT if hands is None else hands_always(scene.snapshot.armed, hands.arms)


def _drive_keys(hands: Hands, look: Sequence[tuple[str, str]]) -> list[Line]:
    """Each key with what it would do, or what it has set, from many words to few.

    The words keep their width, so that nothing jumps.
    """
    power = f"{hands.power_percent} %"
    if hands.source != "keys":
        return [_keys(("I", source_state(hands) or f"{hands.source} drives")), _keys(("I", hands.source))]
    core = [("C", f"core's arc {'ON ' if hands.core_asks else 'off'}")] if hands.core_asks is not None else []
    if hands.transmitter_on is None:
        return [_keys(*core, *look), _keys(("C", "core's arc")) if core else _keys(*look)]
    radio = "on " if hands.transmitter_on else "OFF"
    drive, transmitter = ("WASD QE", f"drive at {power}"), ("T", f"transmitter {radio}")
    long = _keys(drive, transmitter, *core, *look)
    return [long, _keys(("WASDQE", power), ("T", f"radio {radio}")), _keys(("WASDQE", power))]


def _keys(*keys: tuple[str, str]) -> Line:
    line: Line = []
    for key, meaning in keys:
        line += [(" · " if line else " ", LABEL), (key, KEY), (" " + meaning, LABEL)]
    return line


def _verdict(verdict: str) -> tuple[str, str]:
    if verdict.startswith("identical"):
        return GOOD, "✓"
    return (WARN, "≈") if verdict.startswith("within") else (BAD_BADGE, " ✗")
