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
    fit,
    signed,
    width_of,
)

LEFT_WIDTH = 37
"""Where the link stands, but for a longer reason on a wider screen."""
_DRIVERS = {"rc": "the sticks drive", "core": "the core drives"}


def strip(scene: Scene, width: int, height: int) -> list[Line]:
    """Who drives, the link with its age, and the sticks."""
    snapshot = scene.snapshot
    badge = (" ARMED ", GOOD_BADGE) if snapshot.armed else (" DISARMED ", WARN_BADGE)
    who = _DRIVERS.get(snapshot.driver, "nobody drives") if snapshot.armed else snapshot.why_disarmed
    lost = snapshot.link != LIVE
    link = (f" {snapshot.link.upper()} ", BAD_BADGE) if lost else (snapshot.link, GOOD)
    old = f" {age(snapshot.link_age_ms):8}" if snapshot.link_age_ms is not None else ""
    sticks = " ".join(signed(100.0 * stick, 4, 0) for stick in snapshot.sticks)
    left: Line = [(" ", PLAIN), badge, (f" {who}", PLAIN if snapshot.armed else WARN)]
    right: Line = [("link ", LABEL), link, (old, PLAIN), (" sticks ", LABEL), (f"{sticks} %", PLAIN)]
    # Who drives gives way: the sticks are never cut.
    room = min(max(LEFT_WIDTH, width_of(left) + 1), width - width_of(right))
    return [fit([*fit(left, room - 1), (" ", PLAIN), *right], width)]
