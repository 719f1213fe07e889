"""Armed or not and why, the link, and the numbers of the body: forward, left, counter-clockwise."""

from __future__ import annotations

import math

from bench.config import Axis, Button, Profile
from bench.link import DEGRADED, HOLD, NEVER_SEEN
from bench.messages import FOREIGN_BASE, RcFrame, Snapshot
from bench.odometry import wrap
from bench.screen.scene import Scene
from bench.screen.state import armed_badge, link_state, sticks_label, who_drives
from bench.screen.text import BAD_BADGE, GOOD, LABEL, PLAIN, WARN, Line, age, counted, signed

COLUMN = 12
_QUIET_LINKS = {DEGRADED: WARN, HOLD: WARN, NEVER_SEEN: LABEL}
"""Shown without a badge: there is room for what is wrong beside them."""


def status(scene: Scene, width: int, height: int) -> list[Line]:
    """On a low screen the less important rows are left out; on a high one the groups stand apart."""
    groups = (_state(scene), _sticks(scene), _motion(scene.snapshot), _core(scene.snapshot))
    rows = [row for group in groups for row in group]
    if height >= len(rows) + len(groups) - 1:
        blank: Line = [("", PLAIN)]
        return [line for group in groups for line in (*(line for _, line in group), blank)][:-1]
    kept = sorted(priority for priority, _ in rows)[:height]
    return [line for priority, line in rows if priority in kept]


# A row and its priority, each number once; the highest are left out first.
_Row = tuple[int, Line]


def _state(scene: Scene) -> list[_Row]:
    snapshot = scene.snapshot
    driver = who_drives(snapshot)[0]
    if snapshot.driver != FOREIGN_BASE:
        driver += ", field-centric" if snapshot.field_centric else ", robot-centric"
    link = snapshot.link
    words: Line = [_label("link"), (link, _QUIET_LINKS[link]) if link in _QUIET_LINKS else link_state(snapshot)]
    if snapshot.link_age_ms is not None:
        words.append((f"  last good frame {age(snapshot.link_age_ms)} ago", PLAIN))
    if snapshot.link_reason:
        reason = (snapshot.link_reason, WARN)
    else:
        reason = (f"{counted(snapshot.rc_frames, 'frame')}, {counted(snapshot.rc_noise_bytes, 'byte')} of noise", LABEL)
    return [
        (0, [(" ", PLAIN), armed_badge(snapshot), (f" {driver}", PLAIN)]),
        (2, [_label("why"), _why(scene)]),
        (1, words),
        (9, [_label(""), reason]),
        *_bus(snapshot.bus_findings),
    ]


def _bus(findings: tuple[str, ...]) -> list[_Row]:
    """Who is on the bus that should not be: how many, and the newest. Before anything else, where room is short."""
    if not findings:
        return []
    return [(-1, [_label("bus"), (f" {len(findings)} ", BAD_BADGE), (f" {findings[-1]}", WARN)])]


def _why(scene: Scene) -> tuple[str, str]:
    if not scene.snapshot.armed:
        return scene.snapshot.why_disarmed, WARN
    profile = scene.robot.rc
    if profile is None:
        return "a robot without RC is always armed", LABEL
    return "armed by its link" if profile.arming == "on_link" else "armed by hand", LABEL


def _sticks(scene: Scene) -> list[_Row]:
    snapshot, profile = scene.snapshot, scene.robot.rc
    head: Line = [_label(_curve(profile)), *((name.rjust(COLUMN), LABEL) for name in ("forward", "left", "turn"))]
    if profile is None:
        return [(7, head)]
    frame = snapshot.rc_frame
    axes = (profile.forward, profile.right, profile.clockwise)
    switches = (("AUX1", profile.aux1), ("AUX2", profile.aux2))
    return [
        (7, head),
        (10, _row("raw", *(f"ch{axis.channel} {_channel(frame, axis):>4}" for axis in axes))),
        (3, _row(sticks_label(snapshot), *(f"{signed(100 * stick, 5, 0)} %   " for stick in snapshot.sticks))),
        (11, _row("switch", *(_switch(name, frame, button) for name, button in switches))),
    ]


def _curve(profile: Profile | None) -> str:
    """What becomes of a stick's way: how much of it goes by its cube."""
    if profile is None:
        return ""
    return f"expo{100 * profile.expo:.0f}%"[:7] if profile.expo else "linear"


def _motion(snapshot: Snapshot) -> list[_Row]:
    pose, guess = snapshot.pose, snapshot.odometry
    off_mm = 1000.0 * math.hypot(guess.x_m - pose.x_m, guess.y_m - pose.y_m)
    off_deg = math.degrees(abs(wrap(guess.heading_rad - pose.heading_rad)))
    slip = f"slip {snapshot.slip_radps:.2f}" if snapshot.slip_radps is not None else ""
    slips = snapshot.slip_radps is not None and snapshot.slip_radps > snapshot.slip_limit_radps
    off = (f"{off_mm:.1f} mm", f"{off_deg:.2f} deg") if snapshot.driver != FOREIGN_BASE else ("-", "-")
    place = f"x {signed(pose.x_m, 6, 3)} m", f"y {signed(pose.y_m, 6, 3)} m"
    return [
        (4, _row("twist", *_twist(snapshot.twist))),
        (5, _row("pose", *place, f"{signed(math.degrees(pose.heading_rad), 6, 1)} deg")),
        (
            8,
            [
                _label("odo off"),
                (off[0].rjust(COLUMN), PLAIN),
                (slip.rjust(COLUMN), WARN if slips else PLAIN),
                (off[1].rjust(COLUMN), PLAIN),
            ],
        ),
    ]


def _core(snapshot: Snapshot) -> list[_Row]:
    alive = ("alive", GOOD) if snapshot.core_alive else ("silent", WARN)
    connected = ", connected" if snapshot.core_connected else ", not connected"
    return [
        (6, [_label("core"), alive, (connected, PLAIN)]),
        (12, _row("asks", *_twist(snapshot.core_twist))),
    ]


def _label(name: str) -> tuple[str, str]:
    return f" {name:7}", LABEL


def _row(name: str, *cells: str) -> Line:
    return [_label(name), *((cell.rjust(COLUMN), PLAIN) for cell in cells)]


def _twist(twist: tuple[float, float, float]) -> tuple[str, str, str]:
    vx, vy, omega = twist
    return f"{signed(vx, 6, 3)} m/s", f"{signed(vy, 6, 3)} m/s", f"{signed(omega, 5, 2)} rad/s"


def _channel(frame: RcFrame | None, part: Axis | Button) -> str:
    """The raw value of the last good frame."""
    return str(frame.channels[part.channel]) if frame is not None and part.channel < len(frame.channels) else "-"


def _switch(name: str, frame: RcFrame | None, button: Button | None) -> str:
    if button is None:
        return f" {name} none"
    pressed = frame is not None and button.is_pressed(frame.channels)
    return f" {name} ch{button.channel} {_channel(frame, button)} {'ON ' if pressed else 'off'}"
