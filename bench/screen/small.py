"""A terminal that is too small for the pages: what matters in the order in which it does, each line whole or not there.

Robot, armed or not, how to stop and the link come first, down to one row. Then, while there are rows: why it is
disarmed, what was just said, the sticks, where the robot is and how it moves, its wheels.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from typing import NamedTuple

from bench.screen.bars import LEAST_NAME, source_state
from bench.screen.checks import red_lamps
from bench.screen.edges import STOP, enter_does
from bench.screen.layout import SMALLEST
from bench.screen.scene import Scene
from bench.screen.state import armed_badge, link_state, sticks_label, who_drives
from bench.screen.text import (
    BAD_BADGE,
    LABEL,
    NAME_WIDTH,
    PLAIN,
    TITLE,
    WARN,
    WARN_BADGE,
    Line,
    age,
    both_ends,
    first_that_fits,
    short_names,
    signed,
    width_of,
)

_ESC, _QUIT = ("  Esc", PLAIN), ("  Esc quit", PLAIN)
MOST_ROWS = 3
"""Of one sentence."""


class _Part(NamedTuple):
    """A line, or a sentence for as many rows as are left, and how much it matters: 1 most."""

    priority: int
    line: Line
    sentence: str = ""


def small(scene: Scene, width: int, height: int) -> list[Line]:
    """From the top: robot and time, who drives, link, the rest; in the last row, always, how to stop."""
    first = [_robot(scene, width), _state(scene, width), _link(scene, width)]
    if height <= len(first):
        return _packed(scene, width, height)
    lines = first + _chosen(list(_more(scene, width)), width, height - 1 - len(first))
    return [*lines, *[[("", PLAIN)]] * (height - 1 - len(lines)), _keys(scene, width)]


def _chosen(parts: list[_Part], width: int, room: int) -> list[Line]:
    """What matters most, in the order in which it stands."""
    rows: dict[int, list[Line]] = {}
    for at in sorted(range(len(parts)), key=lambda at: parts[at].priority):
        _, line, sentence = parts[at]
        if sentence and room:
            # A word that is longer than the row would be cut, and so is not there.
            words = " ".join(word for word in sentence.split() if len(word) <= width - 3)
            rows_left = min(room, MOST_ROWS)
            wrapped = textwrap.wrap(
                words, max(4, width - 1), max_lines=rows_left, placeholder=" …", break_on_hyphens=False
            )
            rows[at] = [[(f" {row}", WARN)] for row in wrapped]
        elif line and room:
            rows[at] = [line]
        room -= len(rows.get(at, ()))
    return [line for at in sorted(rows) for line in rows[at]]


def _packed(scene: Scene, width: int, height: int) -> list[Line]:
    """For very few rows, several things in each: who drives and how to stop, the link and the robot where they fit."""
    state = _state(scene, min(width, len("  FOREIGN BASE ")))
    if height == 1:
        row = _beside(state, _keys(scene, width - width_of(state) - 1))
        return [_beside(row, _link(scene, width - width_of(row) - 1))]
    link = _link(scene, width - width_of(state) - 1)
    rows = [_robot(scene, width), _beside(state, link)] if link else [state, _link(scene, width)]
    return [*(rows if height > 2 else rows[1:] if link else rows[:1]), _keys(scene, width)]


def _beside(line: Line, other: Line) -> Line:
    return [*line, (" ", PLAIN), *other] if other else line


def _robot(scene: Scene, width: int) -> Line:
    """What runs, whether it is recorded, and how time runs; with less room the transmitter goes, then time, then
    the end of a name.
    """
    robot, pace, snapshot = scene.robot, scene.pace, scene.snapshot
    told = f" {scene.replay.title}" if scene.replay is not None else ""
    doing = "  ● REC" if scene.recording else ""
    time = f"{snapshot.tick / 1000:.3f} s "
    rate = pace.rate if pace.speed is None else pace.speed
    if pace.behind_ticks:
        badge, rights = True, [(f" BACK {pace.behind_ticks / 1000:.3f} s ", WARN_BADGE), (" BACK ", WARN_BADGE)]
    elif pace.paused or (scene.replay is not None and scene.replay.summary):
        badge, rights = True, [(" PAUSED " if pace.paused else " ENDED ", WARN_BADGE)]
    else:
        badge, rights = False, [(f"×{rate:.2f} ", TITLE)]
    ends: list[Line] = [[(time, TITLE), one] for one in rights]
    ends += [[one] for one in rights] if badge else [[(time, TITLE)], []]
    transmitter = robot.rc.name if robot.rc else "no RC"
    names = [
        f"{told} {robot.name}, {transmitter}{doing}",
        f"{told} {robot.name}{doing}",
        f" {robot.name}{doing}",
        f" {robot.name}",
    ]
    for name in names:
        for end in ends:
            if len(name) + 2 + width_of(end) <= width:
                return both_ends([(name, TITLE)], end, width, TITLE)
    whole = first_that_fits([[(name, TITLE)] for name in (*names, robot.name)], width)
    recorded: Line = [("● REC ", TITLE)] if scene.recording else []
    beside = [*([*recorded, *end] for end in ends), ends[-1]]
    for right in beside if badge or not whole else ():
        room = width - width_of(right) - 2
        if right and room >= LEAST_NAME:
            return both_ends([(short_names((names[-1],), room)[0], TITLE)], right, width, TITLE)
    return whole or [(short_names((robot.name,), width)[0], TITLE)]


def _state(scene: Scene, width: int) -> Line:
    snapshot = scene.snapshot
    word, role = armed_badge(snapshot)
    who = who_drives(snapshot)[0]
    badge: Line = [(" ", PLAIN), (word, role)]
    view = ", field-centric" if snapshot.field_centric else ""
    ways: list[Line] = [[*badge, (f" {who}{view}", PLAIN)], [*badge, (f" {who}", PLAIN)], badge]
    return first_that_fits([*ways, [(word, role)], [(word.strip(), role)]], width)


def _link(scene: Scene, width: int) -> Line:
    snapshot = scene.snapshot
    word = link_state(snapshot)
    link: Line = [(" link ", LABEL), word]
    ways = [link, [word], [(word[0].strip(), word[1])]]
    if snapshot.link_age_ms is not None:
        old = age(snapshot.link_age_ms)
        ways = [[*link, (f"  last good frame {old} ago", PLAIN)], [*link, (f"  {old}", PLAIN)], *ways]
    return first_that_fits(ways, width)


def _keys(scene: Scene, width: int) -> Line:
    """How to stop, whatever else there is room for. SPACE keeps its place."""
    going = " P go on" if scene.pace.paused or scene.pace.behind_ticks else " P pause"
    if scene.replay is not None and scene.replay.summary:
        going = " ← → back" if scene.pace.goes_back else ""
    if scene.hands is None:
        leave: Line = [(" Esc quit", PLAIN)]
        return first_that_fits([[(going, PLAIN), _QUIT], leave, [("Esc", PLAIN)]], width)
    gap = (" ", PLAIN)
    arm = enter_does(scene.snapshot.armed, scene.hands.arms)
    if going == " P go on":
        arm = (f"{going:14}", PLAIN)
    stops: list[Line] = [[STOP, _QUIT], [STOP, _ESC], [STOP], [("SPACE STOP", BAD_BADGE)], [("SPACE", BAD_BADGE)]]
    return first_that_fits([[arm, gap, STOP, _QUIT], [arm, gap, STOP], *stops], width)


def _more(scene: Scene, width: int) -> Iterator[_Part]:
    """Everything else, in the order in which it stands."""
    snapshot = scene.snapshot
    yield _Part(1, [], _open(scene))
    if snapshot.armed is False:
        yield _Part(2, [], f"why {snapshot.why_disarmed}")
    yield _Part(3, [], scene.notice)
    yield _Part(4, [], source_state(scene.hands))
    for finding in snapshot.bus_findings[-1:]:
        yield _Part(4, [], f"bus: {finding}")
    if red := red_lamps(scene):
        yield _Part(4, [], f"✗ FAILED: {', '.join(red)}")
    if scene.replay is not None and scene.replay.verdict:
        yield _Part(5, [], f"golden {scene.replay.verdict}")
    yield from _motion(scene, width)
    yield from _wheels(scene, width)
    yield _Part(12, first_that_fits([[(f" {SMALLEST[0]}x{SMALLEST[1]} has room for the pages", LABEL)]], width))


def _open(scene: Scene) -> str:
    """What takes the keys and cannot be seen here."""
    size = f"{SMALLEST[0]}x{SMALLEST[1]} shows it"
    if scene.dialog is not None:
        return f"open: {scene.dialog.title}; Esc closes it, {size}"
    if scene.shown.menu is not None:
        return f"open: {scene.shown.menu.kind}; Esc closes it, {size}"
    if scene.help:
        return f"open: the page of keys; ? closes it, {size}"
    return f"open: the mouse's sticks; M gives the mouse back, {size}" if scene.hands and scene.hands.pad else ""


def _motion(scene: Scene, width: int) -> Iterator[_Part]:
    snapshot = scene.snapshot
    (vx, vy, omega), pose = snapshot.twist, snapshot.pose
    if scene.robot.rc is not None:
        forward, left, turn = (signed(100.0 * stick, 4, 0) for stick in snapshot.sticks)
        yield _Part(6, _labelled(sticks_label(snapshot), f"{forward} {left} {turn} %", width))
    moves = f"{signed(vx, 6, 3)} {signed(vy, 6, 3)} m/s", f"{signed(omega, 5, 2)} rad/s"
    yield _Part(8, _labelled("moves", f"{moves[0]} {moves[1]}", width) or _labelled("moves", moves[0], width))
    place = (
        f"{signed(pose.x_m, 6, 3)} {signed(pose.y_m, 6, 3)} m",
        f"{signed(math.degrees(pose.heading_rad), 6, 1)} deg",
    )
    yield _Part(7, _labelled("at", f"{place[0]}   {place[1]}", width) or _labelled("at", place[0], width))
    alive = "alive" if snapshot.core_alive else "silent"
    yield _Part(11, _labelled("core", alive, width))


def _wheels(scene: Scene, width: int) -> Iterator[_Part]:
    snapshot = scene.snapshot
    names = short_names(snapshot.wheel_names)
    for name, speed, current in zip(names, snapshot.wheel_radps, snapshot.wheel_current_a, strict=True):
        turns, draws = f"{signed(speed, 7, 2)} rad/s", f"{signed(current, 6, 3)} A"
        ways = [[(f" {name:{NAME_WIDTH}} {turns} {draws}", PLAIN)], [(f" {name:{NAME_WIDTH}} {turns}", PLAIN)]]
        yield _Part(9, first_that_fits(ways, width))


def _labelled(label: str, words: str, width: int) -> Line:
    """Whole, without its label, or not at all."""
    return first_that_fits([[(f" {label:8}", LABEL), (words, PLAIN)], [(f" {words}", PLAIN)]], width)
