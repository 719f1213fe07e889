"""How healthy an RC stream is: frame rate, jitter, longest gap, age of the last good frame, counts by reason.

Users ask for these numbers first. Times are whatever the caller counts in microseconds: byte times of a capture, ticks
of a run. Everything is bounded: a window of the last frames, one counter a reason.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from bench.messages import RcEvent, RcFrame, RcLinkStatistics, RcNoise

WINDOW_FRAMES = 128
"""Rate and jitter are those of the last so many frames: about a second of the usual receivers."""


@dataclass(frozen=True, slots=True)
class Health:
    """The figures at one instant. Those that need two frames, or one, are None before there are any."""

    frames: int
    failsafe_frames: int
    frame_lost_frames: int
    noise_bytes: int
    noise_by_reason: dict[str, int]
    """The same bytes by the reason of the first refusal of their run."""
    rate_hz: float | None
    jitter_us: float | None
    """Standard deviation of the time between frames, over the window."""
    longest_gap_us: float | None
    """Since the start, the silence that still lasts included."""
    age_us: float | None
    quality_percent: int | None


class HealthMeter:
    """Takes a decoder's events with the time of their arrival; `at` gives the figures."""

    def __init__(self) -> None:
        self._times_us: deque[float] = deque(maxlen=WINDOW_FRAMES)
        self._longest_gap_us: float | None = None
        self._frames = self._failsafe = self._frame_lost = self._noise_bytes = 0
        self._reasons: dict[str, int] = {}
        self._quality: int | None = None
        self._now_us = 0.0

    def take(self, now_us: float | None, events: Iterable[RcEvent]) -> None:
        """Count the events that came out at this time; None where times are not known."""
        if now_us is not None:
            self._now_us = now_us
        for event in events:
            if isinstance(event, RcFrame):
                self._take_frame(now_us, event)
            elif isinstance(event, RcNoise):
                self._noise_bytes += event.length
                # A decoder's reasons are a closed set: this cannot grow with what arrives.
                self._reasons[event.reason] = self._reasons.get(event.reason, 0) + event.length
            elif isinstance(event, RcLinkStatistics):
                self._quality = event.uplink_quality_percent

    def at(self, now_us: float | None = None) -> Health:
        """The figures at this time, or at that of the last event."""
        if now_us is None:
            now_us = self._now_us
        times = self._times_us
        last_us = times[-1] if times else None
        age_us = now_us - last_us if last_us is not None else None
        gaps = [later - earlier for earlier, later in zip(times, list(times)[1:], strict=False)]
        mean_us = math.fsum(gaps) / len(gaps) if gaps else 0.0
        longest = max((gap for gap in (self._longest_gap_us, age_us) if gap is not None), default=None)
        return Health(
            frames=self._frames,
            failsafe_frames=self._failsafe,
            frame_lost_frames=self._frame_lost,
            noise_bytes=self._noise_bytes,
            noise_by_reason=dict(self._reasons),
            rate_hz=1e6 / mean_us if mean_us > 0.0 else None,
            jitter_us=math.sqrt(math.fsum((gap - mean_us) ** 2 for gap in gaps) / len(gaps)) if gaps else None,
            longest_gap_us=longest,
            age_us=age_us,
            quality_percent=self._quality,
        )

    def _take_frame(self, now_us: float | None, frame: RcFrame) -> None:
        self._frames += 1
        self._failsafe += frame.failsafe
        self._frame_lost += frame.frame_lost
        if now_us is None or frame.failsafe or frame.frame_lost:
            return  # of the latter two the receiver speaks, not the transmitter
        if self._times_us:
            gap_us = now_us - self._times_us[-1]
            self._longest_gap_us = max(gap_us, self._longest_gap_us or 0.0)
        self._times_us.append(now_us)


def summary(health: Health) -> str:
    """One line for people: what came, what was refused and why, and what the times say where there are any."""
    parts = [f"{health.frames} frames"]
    flags = [(health.failsafe_frames, "failsafe"), (health.frame_lost_frames, "frame lost")]
    if said := [f"{count} {name}" for count, name in flags if count]:
        parts[0] += f" ({', '.join(said)})"
    reasons = sorted(health.noise_by_reason.items(), key=lambda one: (-one[1], one[0]))
    told = f" ({', '.join(f'{name} {count}' for name, count in reasons)})" if reasons else ""
    parts.append(f"{health.noise_bytes} bytes of noise{told}")
    if health.rate_hz is not None and health.jitter_us is not None and health.longest_gap_us is not None:
        parts.append(f"{health.rate_hz:.1f} Hz, jitter {health.jitter_us / 1000:.2f} ms")
        parts.append(f"longest gap {health.longest_gap_us / 1000:.1f} ms")
    return "; ".join(parts)
