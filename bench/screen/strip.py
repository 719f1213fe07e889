"""One line that stands on every page: whether the robot is armed, its link, its sticks. Nobody drives blind."""

from __future__ import annotations

from bench.link import LIVE
from bench.screen.scene import Scene
from bench.screen.text import (
    BAD_BADGE,
    ELLIPSIS,
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
)

WHO_WIDTH = 27
_DRIVERS = {"rc": "the sticks drive", "core": "the core drives"}


def strip(scene: Scene, width: int, height: int) -> list[Line]:
    """Who drives, the link with its age, and the sticks."""
    snapshot = scene.snapshot
    badge = (" ARMED ", GOOD_BADGE) if snapshot.armed else (" DISARMED ", WARN_BADGE)
    who = _DRIVERS.get(snapshot.driver, "nobody drives") if snapshot.armed else snapshot.why_disarmed
    if len(who) > WHO_WIDTH:
        who = who[: WHO_WIDTH - 1] + ELLIPSIS
    lost = snapshot.link != LIVE
    link = (f" {snapshot.link.upper()} ", BAD_BADGE) if lost else (snapshot.link, GOOD)
    old = f" {age(snapshot.link_age_ms)}" if snapshot.link_age_ms is not None else ""
    sticks = " ".join(signed(100.0 * stick, 4, 0) for stick in snapshot.sticks)
    line: Line = [
        (" ", PLAIN),
        badge,
        (f" {who:{WHO_WIDTH}} ", PLAIN if snapshot.armed else WARN),
        ("link ", LABEL),
        link,
    ]
    line += [(f"{old:9}", PLAIN), (" sticks ", LABEL), (f"{sticks} %", PLAIN)]
    return [fit(line, width)]
