"""One line that stands on every page: whether the robot is armed, its link, its sticks. Nobody drives blind."""

from __future__ import annotations

from bench.link import LIVE
from bench.screen.scene import Scene
from bench.screen.text import (
    BAD_BADGE,
    GOOD,
    GOOD_BADGE,
    LABEL,
    PLAIN,
    WARN,
    WARN_BADGE,
    Line,
    age,
    first_that_fits,
    fit,
    signed,
    width_of,
)

LEFT_WIDTH = 37
"""Where the link stands, but for a longer reason on a wider screen."""
_DRIVERS = {"rc": ("the sticks drive", "sticks"), "core": ("the core drives", "core")}


def strip(scene: Scene, width: int, height: int) -> list[Line]:
    """Who drives, the link with its age, and the sticks."""
    snapshot = scene.snapshot
    badge = (" ARMED ", GOOD_BADGE) if snapshot.armed else (" DISARMED ", WARN_BADGE)
    lost = snapshot.link != LIVE
    link = (f" {snapshot.link.upper()} ", BAD_BADGE) if lost else (snapshot.link, GOOD)
    old = f" {age(snapshot.link_age_ms):8}" if snapshot.link_age_ms is not None else ""
    sticks = " ".join(signed(100.0 * stick, 4, 0) for stick in snapshot.sticks)
    right: Line = [("link ", LABEL), link, (old, PLAIN), (" sticks ", LABEL), (f"{sticks} %", PLAIN)]
    head: Line = [(" ", PLAIN), badge]
    if snapshot.armed:
        who = _DRIVERS.get(snapshot.driver, ("nobody drives", "nobody"))
        ways: list[Line] = [[*head, (f" {words}", PLAIN)] for words in who]
    else:
        ways = [[*head, (f" {snapshot.why_disarmed}", WARN)]]
    # Who drives gives way: the sticks are never cut.
    room = min(max(LEFT_WIDTH, width_of(ways[0]) + 1), width - width_of(right))
    left = first_that_fits(ways, room - 1) or (head if snapshot.armed else ways[0])
    return [fit([*fit(left, room - 1), (" ", PLAIN), *right], width)]
