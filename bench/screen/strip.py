"""One line that stands on every page: whether the robot is armed, its link, its sticks. Nobody drives blind."""

from __future__ import annotations

from bench.screen.scene import Scene
from bench.screen.state import armed_badge, link_state, who_drives
from bench.screen.text import (
    LABEL,
    PLAIN,
    WARN,
    Line,
    age,
    first_that_fits,
    fit,
    signed,
    width_of,
)

LEFT_WIDTH = 37
"""Where the link stands, but for a longer reason on a wider screen."""


def strip(scene: Scene, width: int, height: int) -> list[Line]:
    """Who drives, the link with its age, and the sticks."""
    snapshot = scene.snapshot
    old = f" {age(snapshot.link_age_ms):8}" if snapshot.link_age_ms is not None else ""
    sticks = " ".join(signed(100.0 * stick, 4, 0) for stick in snapshot.sticks)
    right: Line = [("link ", LABEL), link_state(snapshot), (old, PLAIN), (" sticks ", LABEL), (f"{sticks} %", PLAIN)]
    head: Line = [(" ", PLAIN), armed_badge(snapshot)]
    if snapshot.armed is False:
        ways: list[Line] = [[*head, (f" {snapshot.why_disarmed}", WARN)]]
    else:
        ways = [[*head, (f" {words}", PLAIN)] for words in who_drives(snapshot)]
    # Who drives gives way: the sticks are never cut.
    room = min(max(LEFT_WIDTH, width_of(ways[0]) + 1), width - width_of(right))
    left = first_that_fits(ways, room - 1) or (ways[0] if snapshot.armed is False else head)
    return [fit([*fit(left, room - 1), (" ", PLAIN), *right], width)]
