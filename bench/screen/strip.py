"""The line that stands on every page: whether the robot is armed, its link, its sticks. Nobody drives blind.

Why it is disarmed is said whole: where one row has no room for it beside the rest, it has a row of its own.
"""

from __future__ import annotations

from bench.link import NO_RC
from bench.messages import Snapshot
from bench.screen.scene import Scene
from bench.screen.state import armed_badge, link_state, sticks_label, who_drives
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

GAP, LEFT_WIDTH = 2, 37
"""Where the link stands, but for a longer reason on a wider screen: so far behind it."""


def strip_rows(scene: Scene, width: int) -> int:
    """One, or two where it is disarmed for a reason that has no room beside the link and the sticks."""
    snapshot = scene.snapshot
    if snapshot.armed is not False:
        return 1
    return 1 if width_of(_disarmed(snapshot)) + GAP + width_of(_link_and_sticks(snapshot)) <= width else 2


def strip(scene: Scene, width: int, height: int) -> list[Line]:
    """Who drives, or why nobody does; the link with its age, and the sticks."""
    snapshot = scene.snapshot
    right = _link_and_sticks(snapshot)
    if height > 1:
        return [fit(_disarmed(snapshot), width), _from(LEFT_WIDTH, [], right, width)]
    head: Line = [(" ", PLAIN), armed_badge(snapshot)]
    if snapshot.armed is False:
        ways = [_disarmed(snapshot)]
    else:
        ways = [[*head, (f" {words}", PLAIN)] for words in who_drives(snapshot)]
    # Who drives gives way: the sticks are never cut.
    column = max(LEFT_WIDTH, width_of(ways[0]) + GAP)
    room = min(column, width - width_of(right)) - 1
    left = first_that_fits(ways, room) or (ways[0] if snapshot.armed is False else head)
    return [_from(column, left, right, width)]


def _from(column: int, left: Line, right: Line, width: int) -> Line:
    """`right` from that column on, or from further left where it would be cut there."""
    room = min(column, width - width_of(right))
    return fit([*fit(left, room - 1), (" ", PLAIN), *right], width)


def _disarmed(snapshot: Snapshot) -> Line:
    return [(" ", PLAIN), armed_badge(snapshot), (f" {snapshot.why_disarmed}", WARN)]


def _link_and_sticks(snapshot: Snapshot) -> Line:
    link: Line = [("link ", LABEL), link_state(snapshot)]
    if snapshot.link == NO_RC:
        return link
    old = f" {age(snapshot.link_age_ms):7}" if snapshot.link_age_ms is not None else ""
    sticks = " ".join(signed(100.0 * stick, 4, 0) for stick in snapshot.sticks)
    return [*link, (old, PLAIN), (f" {sticks_label(snapshot):>7} ", LABEL), (f"{sticks} %", PLAIN)]
