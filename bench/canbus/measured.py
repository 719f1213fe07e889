"""What a recorded bus really carried: exact bits of every frame, loads by identifier, and who should not be there."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from bench.canbus.bits import frame_bits
from bench.canbus.watch import BusWatch, Finding

WINDOW_US = 100_000
"""The busiest tenth of a second is what a queue feels; a mean over a drive hides it."""


class LoggedFrame(NamedTuple):
    """One frame of a log. `remote_length` is set where it is a remote frame."""

    at_us: int
    can_id: int
    data: bytes
    extended: bool = False
    remote_length: int | None = None


@dataclass(slots=True)
class Measured:
    """One identifier."""

    can_id: int
    extended: bool
    frames: int = 0
    bits: int = 0
    least_bits: int = 1 << 30
    most_bits: int = 0


@dataclass(slots=True)
class Measurement:
    """A whole log. `add` takes frames in time order."""

    watch: BusWatch
    bitrate: int = 1_000_000
    frames: int = 0
    bits: int = 0
    first_us: int = 0
    last_us: int = 0
    busiest_bits: int = 0
    by_id: dict[tuple[bool, int], Measured] = field(default_factory=dict)
    _window: deque[tuple[int, int]] = field(default_factory=deque)
    _window_bits: int = 0

    def add(self, frame: LoggedFrame) -> None:
        """Count one frame."""
        bits = frame_bits(frame.can_id, frame.data, extended=frame.extended, remote_length=frame.remote_length)
        if not self.frames:
            self.first_us = frame.at_us
        self.last_us = max(self.last_us, frame.at_us)
        self.frames += 1
        self.bits += bits
        key = (frame.extended, frame.can_id)
        one = self.by_id.get(key)
        if one is None:
            one = self.by_id[key] = Measured(frame.can_id, frame.extended)
        one.frames += 1
        one.bits += bits
        one.least_bits = min(one.least_bits, bits)
        one.most_bits = max(one.most_bits, bits)
        window = self._window
        window.append((frame.at_us, bits))
        self._window_bits += bits
        while window[0][0] <= frame.at_us - WINDOW_US:
            self._window_bits -= window.popleft()[1]
        self.busiest_bits = max(self.busiest_bits, self._window_bits)
        if not frame.extended and frame.remote_length is None:
            self.watch.hear((frame.at_us - self.first_us) // 1000, frame.can_id, len(frame.data))

    @property
    def seconds(self) -> float:
        """From the first frame to the last."""
        return (self.last_us - self.first_us) / 1e6

    @property
    def load(self) -> float:
        """Mean share of the bus; 0 where the log is too short to say."""
        return self.bits / self.bitrate / self.seconds if self.seconds else 0.0

    @property
    def busiest(self) -> float:
        """Share of the bus in the busiest tenth of a second; the mean where the log is shorter than that."""
        if self.last_us - self.first_us < WINDOW_US:
            return self.load
        return self.busiest_bits / self.bitrate * 1e6 / WINDOW_US

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Who should not be there."""
        return self.watch.findings


def measure(frames: Iterable[LoggedFrame], watch: BusWatch, bitrate: int = 1_000_000) -> Measurement:
    """All frames of a log, in time order."""
    found = Measurement(watch, bitrate)
    for frame in frames:
        found.add(frame)
    return found
