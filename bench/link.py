"""Is the transmitter there? Link supervision by time, by flag and by content. What follows from it is `drive`'s.

    never seen --good frame--> live <--good frame-- any state below
    live      --frame-lost flag--> degraded      the receiver repeats old channels
              --silence----------> hold          a few frames missing; the last command stands
              --100 ms-----------> neutral       zero twist, braking
              --500 ms-----------> lost          zero current; disarmed until a deliberate re-arm
    live      --failsafe flag or mark, link quality 0, all used channels 0--> neutral at once, no hold
              --where the profile asks for it: frozen, sticks out of travel-> neutral at once, no hold

All times count from the last good frame, in ticks; the limits are those of the robot file's [link] table. A frame is
good when it carries none of the marks above.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench.config import LinkLimits, Profile
from bench.messages import RcEvent, RcFrame, RcLinkStatistics, RcNoise

NEVER_SEEN, LIVE, DEGRADED, HOLD, NEUTRAL, LOST = "never seen", "live", "degraded", "hold", "neutral", "lost"
NO_RC = "no rc"
"""Of a robot that has no receiver, and so no link."""
COMMANDING = frozenset((LIVE, DEGRADED, HOLD))
"""States in which the last good frame still counts as the driver's will."""

QUIET_PERIODS = 2.5
"""Frame periods without a good frame before `live` is called `hold`: one late frame is no news."""


class RcLink:
    """Follows the events of an RC decoder and says in which state the link is, and why.

    `frame` is the last good frame, `frames` counts the good ones, `noise_bytes` and `flagged_frames` the rest. Before
    `review_tick` a step without events changes nothing and may be left out.
    """

    __slots__ = (
        "_bad",
        "_disarm",
        "_frozen",
        "_hold",
        "_quality_zero",
        "_quiet",
        "_reach",
        "_same_since",
        "_seen_channels",
        "_sticks",
        "_used",
        "_watch_travel",
        "flagged_frames",
        "frame",
        "frames",
        "last_good_tick",
        "noise_bytes",
        "quality_percent",
        "reason",
        "review_tick",
        "state",
    )

    def __init__(self, profile: Profile, limits: LinkLimits) -> None:
        self._hold = limits.hold_ms
        self._disarm = limits.disarm_ms
        self._quiet = min(max(1, int(QUIET_PERIODS * profile.period_ms)), limits.hold_ms - 1)
        self._frozen = profile.frozen_ms
        self._used = _used_channels(profile)
        axes = (profile.forward, profile.right, profile.clockwise)
        self._sticks = tuple((axis.channel, axis.middle, axis.travel * profile.dead_band) for axis in axes)
        # No stick reaches beyond its travel: where a failsafe setting is stored there, it says so (FlySky, i-BUS).
        self._reach = tuple((axis.channel, axis.middle, axis.travel * profile.max_travel) for axis in axes)
        self._watch_travel = profile.max_travel > 0.0
        self._seen_channels: tuple[int, ...] = ()
        self._same_since = 0
        self._quality_zero = False
        self._bad = ""
        self.state = NEVER_SEEN
        self.reason = "no frame yet"
        self.frame: RcFrame | None = None
        self.last_good_tick = -1
        self.review_tick = 0
        self.frames = 0
        self.flagged_frames = 0
        self.noise_bytes = 0
        self.quality_percent: int | None = None

    def step(self, tick: int, events: Sequence[RcEvent]) -> str:
        """Take the events of this tick and return the state at its end."""
        for event in events:
            if isinstance(event, RcFrame):
                self._take_frame(tick, event)
            elif isinstance(event, RcNoise):
                self.noise_bytes += event.length
            elif isinstance(event, RcLinkStatistics):
                self.quality_percent = event.uplink_quality_percent
                self._quality_zero = event.uplink_quality_percent == 0
                if self._quality_zero:
                    self._bad = "link quality 0"
        if self.frame is None:
            if self._bad:
                self.reason = self._bad
            return self.state
        age = tick - self.last_good_tick
        if age >= self._disarm:
            self.state = LOST
            self.reason = self._bad or f"no good frame for {self._disarm} ms"
        elif self._bad and self._bad != "frame lost":
            self.state, self.reason = NEUTRAL, self._bad
        elif age >= self._hold:
            self.state = NEUTRAL
            self.reason = self._bad or f"no good frame for {self._hold} ms"
        elif self._bad:
            self.state, self.reason = DEGRADED, self._bad
        elif age > self._quiet:
            self.state, self.reason = HOLD, "silence"
        else:
            self.state, self.reason = LIVE, ""
        return self.state

    def age_ticks(self, tick: int) -> int | None:
        """Ticks since the last good frame; None before the first one."""
        return None if self.frame is None else tick - self.last_good_tick

    def _take_frame(self, tick: int, frame: RcFrame) -> None:
        bad = self._fault(tick, frame)
        self._bad = bad
        if bad:
            self.flagged_frames += 1
            return
        self.frame = frame
        self.frames += 1
        self.last_good_tick = tick
        self.review_tick = tick + self._quiet + 1  # of all limits in time this is the first

    def _fault(self, tick: int, frame: RcFrame) -> str:
        """Why this frame is not the driver's will, or nothing."""
        channels = frame.channels
        if frame.failsafe:
            return "failsafe flag"
        if self._quality_zero:
            return "link quality 0"
        if len(channels) <= self._used[-1]:
            return "channels missing"
        if not any(channels[channel] for channel in self._used):
            return "all channels 0"
        if frame.frame_lost:
            return "frame lost"
        if self._watch_travel and any(
            abs(channels[channel] - middle) > reach for channel, middle, reach in self._reach
        ):
            return "sticks out of travel"
        if self._frozen:
            if channels != self._seen_channels:
                self._seen_channels = channels
                self._same_since = tick
            elif tick - self._same_since >= self._frozen and any(
                abs(channels[channel] - middle) > dead for channel, middle, dead in self._sticks
            ):
                return f"sticks frozen for {self._frozen} ms"
        return ""


def _used_channels(profile: Profile) -> tuple[int, ...]:
    """The channels that must not all be 0, in rising order.

    A FrSky receiver set to "no pulses" sends zeros for what the transmitter drives, so the used ones decide. On uart12
    0 is a stick's own end: only a frame of nothing but zeros is no frame of a driver's.
    """
    if profile.protocol == "uart12":
        return tuple(range(6))
    parts = (profile.forward, profile.right, profile.clockwise, profile.aux1, profile.aux2)
    return tuple(sorted({part.channel for part in parts if part is not None}))
