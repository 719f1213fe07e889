"""Each wheel on a line: the speed that is wanted and the one it has, how it slides, its current against the limit."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from bench.config import Wheel
from bench.kinematics import Kinematics
from bench.messages import FOREIGN_BASE, BodyTwist
from bench.screen.scene import Scene
from bench.screen.text import (
    GOOD,
    LABEL,
    NAME_WIDTH,
    PLAIN,
    TALLER,
    WARN,
    Line,
    cut_rows,
    fill_bar,
    short_names,
    signed,
    swing_bar,
)

AT_LIMIT = 0.98
"""Share of the current limit from which a wheel is said to be at it."""
SLIP_MMPS = 50.0
"""From here on a wheel is said to slide over the floor. A wheel that creeps under load stays below."""
NUMBERS_WIDTH = 46
"""Everything on a line but its two bars and its slip."""
SLIP_WIDTH = 11
SLIP_FROM = 76
"""From this width on there is room for the slip."""


def wheels(scene: Scene, width: int, height: int) -> list[Line]:
    """A heading and a line a wheel. Positive is the wheel's own positive turn, whatever its motor's wire says.

    Slip is the floor's speed under the wheel, along its roller axis, minus what the wheel rolls.
    """
    snapshot = scene.snapshot
    is_foreign = snapshot.driver == FOREIGN_BASE
    top, limit = scene.robot.limits.wheel_radps, snapshot.current_limit_a
    slip_width = SLIP_WIDTH if width >= SLIP_FROM else 0
    bars = width - NUMBERS_WIDTH - slip_width
    speed_width = bars * 3 // 5 // 2 * 2 + 1  # odd: there is a middle
    current_width = bars - speed_width
    scale = f"◆ wanted █ is ±{top:.0f}"
    lines: list[Line] = [
        [
            (f" {'wheel':{NAME_WIDTH}}{'wanted':>7} {'is rad/s':>8} ", LABEL),
            ((scale if len(scale) <= speed_width else "").ljust(speed_width), LABEL),
            (f" {'current':>8} {f'limit {limit:g} A':{current_width + 6}}", LABEL),
            (" slip mm/s " if slip_width else "", LABEL),
        ]
    ]
    values = zip(
        short_names(snapshot.wheel_names),
        snapshot.wheel_wanted_radps,
        snapshot.wheel_radps,
        snapshot.wheel_current_a,
        slips_mmps(scene.robot.wheels, snapshot.twist, snapshot.wheel_radps),
        strict=True,
    )
    for name, wanted, speed, current, slip in values:
        at_limit = abs(current) >= AT_LIMIT * limit
        # What a foreign base wants of a wheel is its own secret.
        shown, mark = (f"{'-':>7}", speed) if is_foreign else (signed(wanted, 7, 2), wanted)
        lines.append(
            [
                (f" {name:{NAME_WIDTH}}{shown} {signed(speed, 8, 2)} ", PLAIN),
                (swing_bar(speed, mark, top, speed_width), GOOD),
                (f" {signed(current, 6, 3)} A ", PLAIN),
                (fill_bar(abs(current) / limit, current_width), WARN if at_limit else GOOD),
                (" LIMIT" if at_limit else "      ", WARN),
                *([_slip(slip)] if slip_width else []),
            ]
        )
    # A wheel matters more than the heading, and none is left out in silence.
    return lines if len(lines) <= height else cut_rows(lines[1:], height, TALLER)


def slips_mmps(wheels: tuple[Wheel, ...], twist: BodyTwist, wheel_radps: Sequence[float]) -> list[float]:
    """How fast each contact slides along its roller axis."""
    kinematics = _kinematics(wheels)
    rolled = zip(kinematics.wheel_speeds(twist), wheel_radps, kinematics.radii, strict=True)
    return [1000.0 * radius * (floor - wheel) for floor, wheel, radius in rolled]


def _slip(mmps: float) -> tuple[str, str]:
    if abs(mmps) >= SLIP_MMPS:
        return f" SLIP{signed(mmps, 5, 0)} ", WARN
    return f"{signed(mmps, SLIP_WIDTH - 1, 0)} ", PLAIN


@lru_cache(maxsize=8)
def _kinematics(wheels: tuple[Wheel, ...]) -> Kinematics:
    return Kinematics(wheels)
