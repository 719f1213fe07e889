"""Whether all is well: golden, expectations, wires, timing, bus, odometry. A lamp a line; and the same for a glance."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator

from bench.check.expectations import FAILED, HOLDS, NOT_YET, PASSED, UNTESTED, Standing
from bench.screen.scene import Scene
from bench.screen.text import (
    BAD_BADGE,
    GOOD,
    LABEL,
    NO_BREAK,
    PLAIN,
    TALLER,
    WARN,
    Line,
    cut_rows,
    first_that_fits,
    fit,
    plain,
    signed,
    swing_bar,
    width_of,
)
from bench.screen.wire_lamps import SWITCHED_OFF, WireLamp
from bench.screen.wiretable import loads

_SIGNS = {
    PASSED: ("✓ passed  ", GOOD), HOLDS: ("✓ holds   ", GOOD), NOT_YET: ("… not yet ", WARN),
    UNTESTED: ("? untested", LABEL), FAILED: (" ✗ FAILED ", BAD_BADGE), SWITCHED_OFF: ("- off     ", LABEL),
}  # fmt: skip
_AXES = ("forward", "left", "turn")
_NAME_WIDTH = 21
_UNIT = re.compile(r"(?<=\d) (?=[^\W\d])")
"""Between a number and what it counts: they stay together."""
ROOMY, APART, LOW = (99, 99, True, True), (99, 99, True, False), (9, 3, False, False)
LOWEST = tuple((failed, 1, False, False) for failed in range(9, 0, -1))
"""How many lines the reason of a failed check gets, that of another one; whether sections stand apart, and whether time
and odometry have more than a line.
"""


def checks(scene: Scene, width: int, height: int) -> list[Line]:
    """Everything, each with its reason; on a low screen the reasons are shorter."""
    lines: list[Line] = []
    for level in (ROOMY, APART, LOW, *LOWEST):
        lines = list(_all(scene, width, *level))
        if len(lines) <= height:
            return lines
    return cut_rows(lines, height, TALLER)


def _all(scene: Scene, width: int, failed: int, quiet: int, apart: bool, long: bool) -> Iterator[Line]:
    blank: list[Line] = [[("", PLAIN)]] if apart else []
    yield from _golden(scene, width)
    yield from blank
    yield from _expectations(scene, width)
    yield from blank
    yield from _agree(scene, width, failed, quiet)
    yield from blank
    if apart:
        yield [(" wires", LABEL)]
    yield from loads(scene, width)
    for finding in scene.snapshot.bus_findings:
        parts = textwrap.wrap(finding, max(8, width - 6))
        yield from ([(" ! " if at == 0 else "   ", WARN), (part, WARN)] for at, part in enumerate(parts))
    yield from blank
    if long:
        yield [(" time", LABEL)]
        yield from _time(scene)
        yield from blank
        yield [(" odometry", LABEL)]
        yield from _odometry(scene)
    else:
        yield _pace(scene)
        follows, *slip = _odometry(scene)
        yield fit([(" odometry", LABEL), (plain(follows)[2:], PLAIN)], width)
        yield from slip


def glance(scene: Scene, width: int, height: int) -> list[Line]:
    """The same in a few lines, and the sticks as bars."""
    lines: list[Line] = []
    if scene.replay is not None and scene.replay.verdict:
        lines += _golden(scene, width)
    if scene.lamps or scene.agree:
        lines.append(_counts("checks", _states(scene)))
    lines += [*loads(scene, width), _pace(scene)]
    if scene.robot.rc is not None and height >= len(lines) + 1 + len(_AXES):
        lines.append([("", PLAIN)])
        for name, stick in zip(_AXES, scene.snapshot.sticks, strict=True):
            bar = swing_bar(stick, stick, 1.0, max(3, min(31, width - 18)))
            lines.append([(f" {name:8}", LABEL), (bar, GOOD), (f" {signed(100.0 * stick, 4, 0)} %", PLAIN)])
    return lines


def red_lamps(scene: Scene) -> list[str]:
    """What has failed by name: expectations and checks of the wires."""
    expected = [lamp.name for lamp in scene.lamps if lamp.state == FAILED]
    return expected + [lamp.name for lamp in scene.agree if lamp.state == FAILED]


def _states(scene: Scene) -> list[str]:
    return [lamp.state for lamp in scene.lamps] + [lamp.state for lamp in scene.agree]


def _golden(scene: Scene, width: int) -> list[Line]:
    verdict = scene.replay.verdict if scene.replay is not None else ""
    if not verdict:
        return [[(" golden  ", LABEL), ("none: nothing to compare this run with", LABEL)]]
    good, close = verdict.startswith("identical"), verdict.startswith("within")
    mark, role = ("✓", GOOD) if good else ("≈", WARN) if close else (" ✗ ", BAD_BADGE)
    return [fit([(" golden  ", LABEL), (mark, role), (f" {verdict}", PLAIN)], width)]


def _expectations(scene: Scene, width: int) -> list[Line]:
    if not scene.lamps:
        return [[(" expect  ", LABEL), ("none: a scenario brings them ([[expect]])", LABEL)]]
    lines = [_counts("expect", [lamp.state for lamp in scene.lamps])]
    for lamp in scene.lamps:
        lines.append(
            fit([(" ", PLAIN), _SIGNS[lamp.state], (f" {_margin(lamp):28}", PLAIN), (lamp.name, PLAIN)], width)
        )
    return lines


def _margin(lamp: Standing) -> str:
    if not math.isfinite(lamp.margin):
        return ""
    at = f" at {lamp.at_tick / 1000:.3f} s" if lamp.at_tick is not None else ""
    return f"{abs(lamp.margin):.4g} {'missing' if lamp.margin < 0.0 else 'to spare'}{at}"


def _agree(scene: Scene, width: int, failed: int, quiet: int) -> Iterator[Line]:
    """What the wires say of each other: a lamp a check, with the worst that it saw, or what it found."""
    if not scene.agree:
        why = "not judged while it runs; its recording is: wheelbench check DIR"
        yield fit([(" agree   ", LABEL), (why, LABEL)], width)
        return
    ways = ["wire held against wire"]
    if scene.pace.behind_ticks:
        ways = ["as they stand at the newest instant", "as at the newest instant", "newest instant"]
    elif scene.agree_since_tick:
        since = f"since {scene.agree_since_tick / 1000:.3f} s"
        ways = [f"{since}, where it was driven on", since]
    counts = _counts("agree", [lamp.state for lamp in scene.agree])
    yield fit([*counts, *first_that_fits([[(f"   {said}", LABEL)] for said in ways], width - width_of(counts))], width)
    for lamp in scene.agree:
        yield from _wire_lamp(lamp, width, failed if lamp.state == FAILED else quiet)


def _wire_lamp(lamp: WireLamp, width: int, most: int) -> Iterator[Line]:
    """The reason begins beside the name and goes on below it; one that is too long for its room gives way to less."""
    sign, role = _SIGNS[lamp.state]
    beside = 1 + len(sign) + 1 + _NAME_WIDTH
    below = beside if lamp.state != FAILED else 1 + len(sign) + 1  # what failed has much to say
    parts: list[str] = []
    for reason in lamp.reasons:
        ahead = " " * ((0 if parts else beside) - below)
        rows = textwrap.wrap(_UNIT.sub(NO_BREAK, reason), max(12, width - below - 1), initial_indent=ahead)
        parts += [row.replace(NO_BREAK, " ") for row in rows]
    if len(parts) > most and lamp.short:
        parts = [lamp.short]
    elif len(parts) > most:
        parts = [*parts[: most - 1], " ".join(parts[most - 1 :])]  # is cut where the line ends
    head: Line = [(" ", PLAIN), (sign, role), (f" {lamp.name:{_NAME_WIDTH}}", PLAIN)]
    yield fit([*head, (parts[0].lstrip() if parts else "", PLAIN)], width)
    for part in parts[1:]:
        yield fit([(" " * below, PLAIN), (part, PLAIN)], width)


def _counts(name: str, states: list[str]) -> Line:
    failed, waits = states.count(FAILED), states.count(NOT_YET) + states.count(UNTESTED)
    good = states.count(PASSED) + states.count(HOLDS)
    line: Line = [(f" {name:8}", LABEL), (f"✓ {good}", GOOD), (f"  … {waits}", WARN if waits else LABEL), ("  ", PLAIN)]
    return [*line, (f" ✗ {failed} FAILED ", BAD_BADGE) if failed else ("✗ 0", LABEL)]


def _pace(scene: Scene) -> Line:
    pace = scene.pace
    rate = pace.rate if pace.speed is None else pace.speed
    late = f"late {pace.late_ticks:3d} ms, slipped {pace.slipped_ticks} ms"
    return [(" time   ", LABEL), (f" ×{rate:.2f}  ", PLAIN), (late, WARN if pace.slipped_ticks else PLAIN)]


def _time(scene: Scene) -> list[Line]:
    pace = scene.pace
    rate = pace.rate if pace.speed is None else pace.speed
    given_up = f"{pace.slipped_ticks} ms given up because the machine could not keep pace"
    return [
        [(f"   ×{rate:.2f} of real time; asked for ×{pace.rate:g}", PLAIN)],
        [(f"   {pace.late_ticks} ms of ticks due at once, at most, in the last second; a frame is 50 ms", PLAIN)],
        [(f"   {given_up}", WARN if pace.slipped_ticks else PLAIN)],
    ]


def _odometry(scene: Scene) -> list[Line]:
    snapshot = scene.snapshot
    lines: list[Line] = [[(f"   follows {snapshot.odometry_source}, heading by {snapshot.heading_source}", PLAIN)]]
    if snapshot.slip_radps is not None:
        slips = snapshot.slip_radps > snapshot.slip_limit_radps
        words = (
            f"   wheels contradict each other by {snapshot.slip_radps:.2f} rad/s, limit {snapshot.slip_limit_radps:g}"
        )
        lines.append([(words + (": SLIP" if slips else ""), WARN if slips else PLAIN)])
    return lines
