"""What several panels say of the same things: whether the robot is armed, who drives, how the link is."""

from __future__ import annotations

from bench.link import DEGRADED, LIVE, NO_RC
from bench.messages import FOREIGN_BASE, Snapshot
from bench.screen.text import BAD_BADGE, GOOD, GOOD_BADGE, LABEL, WARN_BADGE, Span

_BADGES = {True: (" ARMED ", GOOD_BADGE), False: (" DISARMED ", WARN_BADGE), None: (" FOREIGN BASE ", GOOD_BADGE)}
_DRIVERS = {
    "rc": ("the sticks drive", "sticks"),
    "core": ("the core drives", "core"),
    FOREIGN_BASE: ("seen by its wires", "by its wires"),
}
_CALM_LINKS = {LIVE: GOOD, NO_RC: LABEL}


def armed_badge(snapshot: Snapshot) -> Span:
    """Armed or not, where anybody but the base knows it."""
    return _BADGES[snapshot.armed]


def who_drives(snapshot: Snapshot) -> tuple[str, str]:
    """In some words, and in as few as can be."""
    return _DRIVERS.get(snapshot.driver, ("nobody drives", "nobody"))


def link_state(snapshot: Snapshot) -> Span:
    """A badge where something is wrong with it."""
    state = snapshot.link
    role = _CALM_LINKS.get(state, BAD_BADGE)
    return (f" {state.upper()} ", role) if role == BAD_BADGE else (state, role)


def sticks_label(snapshot: Snapshot) -> str:
    """What the sticks' positions are: those of now, or under a link that brings none the last that came."""
    return "sticks" if snapshot.link in (LIVE, DEGRADED) else "were at"
