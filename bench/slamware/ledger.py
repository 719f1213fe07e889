"""What a core has counted and noted, for screens and tests: every trouble is an event, none is an exception."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from bench.slamware.framing import SlamwareNoise

EVENT_LOG_LENGTH = 200


class CoreEvent(NamedTuple):
    """Something a user wants to know of, and the details.

    "connected", "timeout", "error", "noise", "unexpected", "lost" (the line is being brought back), "in step" (it is),
    "asked" (by the base), "fault" (of the base).
    """

    tick: int
    kind: str
    detail: str


class Ledger:
    """The counters of one core, and its last 200 events."""

    def __init__(self) -> None:
        self.requests: dict[int, int] = {}
        """How many requests left, by sub-command."""
        self.answers: dict[int, int] = {}
        """How many OK answers came, by the sub-command that they answer."""
        self.errors: dict[int, int] = {}
        """How many error answers came, by error code."""
        self.timeouts = 0
        self.noise_bytes = 0
        self.unexpected = 0
        """Good frames that answer nothing which was asked."""
        self.resyncs = 0
        """How often the line had to be brought back, or could not be."""
        self.events: deque[CoreEvent] = deque(maxlen=EVENT_LOG_LENGTH)

    def log(self, tick: int, kind: str, detail: str) -> None:
        """Note an event."""
        self.events.append(CoreEvent(tick, kind, detail))

    def count(self, counter: dict[int, int], key: int) -> None:
        """One more of this key in `requests`, `answers` or `errors`."""
        counter[key] = counter.get(key, 0) + 1

    def refused(self, noise: SlamwareNoise, tick: int) -> None:
        """Bytes that are no frame."""
        self.noise_bytes += noise.length
        self.log(tick, "noise", f"{noise.length} bytes refused: {noise.reason}")
