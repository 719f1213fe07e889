"""How late ticks began, counted by whole microseconds in bounded memory."""

from __future__ import annotations

from bench.messages import TICK_US

LONGEST_LATE_US = 50_000


class Lateness:
    """A count for each microsecond; what is later than the longest is counted with it."""

    def __init__(self) -> None:
        self.ticks = 0
        self.most_us = 0.0
        self.over_1_ms = 0
        self._counts = [0] * (LONGEST_LATE_US + 1)

    def add(self, late_ns: int) -> None:
        """One more tick."""
        self.ticks += 1
        self._counts[min(late_ns // 1000, LONGEST_LATE_US)] += 1
        if late_ns > 1000 * self.most_us:
            self.most_us = late_ns / 1000
        if late_ns > 1000 * TICK_US:
            self.over_1_ms += 1

    def add_many(self, late_us: int, ticks: int) -> None:
        """So many ticks that were late by these whole microseconds and a part of one."""
        self.ticks += ticks
        self._counts[min(late_us, LONGEST_LATE_US)] += ticks
        if late_us >= TICK_US:
            self.over_1_ms += ticks
        self.most_us = max(self.most_us, float(late_us))

    def join(self, other: Lateness) -> None:
        """Count the ticks of another too."""
        most_us = max(self.most_us, other.most_us)
        for late_us, ticks in enumerate(other._counts):
            if ticks:
                self.add_many(late_us, ticks)
        self.most_us = most_us

    def bars(self) -> list[tuple[str, int]]:
        """A histogram in steps of 1, 2, 5, 10 ...: "up to 5 us" and how many ticks."""
        edges = [step * 10**power for power in range(5) for step in (1, 2, 5)]
        rows, low = [], 0
        for edge in edges:
            rows.append((f"{edge} us", sum(self._counts[low:edge])))
            low = edge
        rows.append((f"over {edges[-1]} us", sum(self._counts[low:])))
        return rows

    def percentile_us(self, percent: float) -> float:
        """So many percent of the ticks were at most this late, to the microsecond above; 0 before the first."""
        if not self.ticks:
            return 0.0
        wanted, seen = percent / 100.0 * self.ticks, 0
        for late_us, count in enumerate(self._counts):
            seen += count
            if seen >= wanted:
                return min(late_us + 1.0, self.most_us)
        return self.most_us

    def facts(self) -> dict[str, float]:
        """The usual figures; `over_1_ms_percent` is the share of ticks later than a whole tick."""
        share = 100.0 * self.over_1_ms / self.ticks if self.ticks else 0.0
        return {
            "ticks": self.ticks,
            "p50_us": self.percentile_us(50.0),
            "p99_us": self.percentile_us(99.0),
            "p999_us": self.percentile_us(99.9),
            "max_us": round(self.most_us, 1),
            "over_1_ms_percent": round(share, 4),
        }
