"""Whether all is well: golden, expectations, timing, link, bus, odometry. A lamp a line; and the same for a glance."""

from __future__ import annotations

import math
import textwrap

from bench.check.expectations import FAILED, HOLDS, NOT_YET, PASSED, UNTESTED, Standing
from bench.screen.scene import Scene
from bench.screen.text import BAD_BADGE, GOOD, LABEL, PLAIN, WARN, Line, fit, plain, signed, swing_bar
from bench.screen.wiretable import loads

_SIGNS = {
    PASSED: ("✓ passed  ", GOOD), HOLDS: ("✓ holds   ", GOOD), NOT_YET: ("… not yet ", WARN),
    UNTESTED: ("? untested", LABEL), FAILED: (" ✗ FAILED ", BAD_BADGE),
}  # fmt: skip
_AXES = ("forward", "left", "turn")


def checks(scene: Scene, width: int, height: int) -> list[Line]:
    """Everything, each with its reason."""
    lines: list[Line] = [*_golden(scene, width), [("", PLAIN)]]
    lines += _expectations(scene, width)
    lines += [[("", PLAIN)], [(" time", LABEL)], *_time(scene)]
    lines += [[("", PLAIN)], [(" wires", LABEL)], *loads(scene, width)]
    for finding in scene.snapshot.bus_findings:
        parts = textwrap.wrap(finding, max(8, width - 6))
        lines += [[(" ! " if at == 0 else "   ", WARN), (part, WARN)] for at, part in enumerate(parts)]
    lines += [[("", PLAIN)], [(" odometry", LABEL)], *_odometry(scene)]
    return lines if len(lines) <= height else [line for line in lines if plain(line)]


def glance(scene: Scene, width: int, height: int) -> list[Line]:
    """The same in a few lines, and the sticks as bars."""
    lines: list[Line] = []
    if scene.replay is not None and scene.replay.verdict:
        lines += _golden(scene, width)
    if scene.lamps:
        lines.append(_counts(scene))
    lines += [*loads(scene, width), _pace(scene)]
    if scene.robot.rc is not None and height >= len(lines) + 1 + len(_AXES):
        lines.append([("", PLAIN)])
        for name, stick in zip(_AXES, scene.snapshot.sticks, strict=True):
            bar = swing_bar(stick, stick, 1.0, max(3, min(31, width - 18)))
            lines.append([(f" {name:8}", LABEL), (bar, GOOD), (f" {signed(100.0 * stick, 4, 0)} %", PLAIN)])
    return lines


def count_of(scene: Scene, *states: str) -> int:
    """How many expectations stand so."""
    return len([lamp for lamp in scene.lamps if lamp.state in states])


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
    lines = [_counts(scene)]
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


def _counts(scene: Scene) -> Line:
    failed, waits = count_of(scene, FAILED), count_of(scene, NOT_YET, UNTESTED)
    good = len(scene.lamps) - failed - waits
    line: Line = [(" expect  ", LABEL), (f"✓ {good}", GOOD), (f"  … {waits}", WARN if waits else LABEL), ("  ", PLAIN)]
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
