"""Each wheel on a line: the speed that is wanted and the one it has, and its current against the limit."""

from __future__ import annotations

from bench.screen.scene import Scene
from bench.screen.text import GOOD, LABEL, PLAIN, WARN, Line, fill_bar, signed, swing_bar

AT_LIMIT = 0.98
"""Share of the current limit from which a wheel is said to be at it."""
NUMBERS_WIDTH = 47
"""Everything on a line but its two bars, and a margin."""


def wheels(scene: Scene, width: int, height: int) -> list[Line]:
    """A heading and a line a wheel. Positive is the wheel's own positive turn, whatever its motor's wire says."""
    snapshot = scene.snapshot
    top, limit = scene.robot.limits.wheel_radps, snapshot.current_limit_a
    bars = width - NUMBERS_WIDTH
    speed_width = bars * 3 // 5 // 2 * 2 + 1  # odd: there is a middle
    current_width = bars - speed_width
    scale = f"◆ wanted █ is ±{top:.0f}"
    lines: list[Line] = [
        [
            (f" {'wheel':12}{'wanted':>7} {'is rad/s':>8} ", LABEL),
            ((scale if len(scale) <= speed_width else "").ljust(speed_width), LABEL),
            (f" {'current':>8} {f'limit {limit:g} A':{current_width}}", LABEL),
        ]
    ]
    values = zip(
        snapshot.wheel_names, snapshot.wheel_wanted_radps, snapshot.wheel_radps, snapshot.wheel_current_a, strict=True
    )
    for name, wanted, speed, current in values:
        at_limit = abs(current) >= AT_LIMIT * limit
        lines.append(
            [
                (f" {name[:12]:12}{signed(wanted, 7, 2)} {signed(speed, 8, 2)} ", PLAIN),
                (swing_bar(speed, wanted, top, speed_width), GOOD),
                (f" {signed(current, 6, 3)} A ", PLAIN),
                (fill_bar(abs(current) / limit, current_width), WARN if at_limit else GOOD),
                (" LIMIT" if at_limit else "", WARN),
            ]
        )
    return lines
