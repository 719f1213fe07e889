"""A serial line as a signal: bytes written onto it at one setting, and read from it at another.

    idle  start  d0 d1 d2 d3 d4 d5 d6 d7  parity  stop(s)  idle
     1      0    lowest bit first         even      1       1         (an inverted line: every level turned over)

The reader is the usual UART: it waits for a falling edge, samples in the middle of each of its bits, delivers the byte
whether or not parity and stop bit are right, and from the stop bit's sample on waits for the next falling edge. Ports
differ in what they do with a byte whose stop bit is wrong; most USB adapters deliver it, as here.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from typing import NamedTuple

LATE_BITS = 1 / 32
"""A reader looks sixteen times a bit, so it sees an edge up to a sixteenth of its bit late, half of that on average."""


class Settings(NamedTuple):
    """How a port is set. Stop bits count for the writer alone: readers look at the first one only."""

    baud: int
    even_parity: bool = False
    stop_bits: int = 1
    inverted: bool = False

    def __str__(self) -> str:
        """As people write it: 100000 8E2 inverted."""
        return f"{self.baud} 8{'NE'[self.even_parity]}{self.stop_bits}{' inverted' if self.inverted else ''}"


class Signal(NamedTuple):
    """The level of a line over time: `idle` (0 or 1) until the first edge, turned over at every edge."""

    idle: int
    edges_us: list[float]

    def level(self, at_us: float) -> int:
        """0 or 1."""
        return self.idle ^ bisect_right(self.edges_us, at_us) & 1


class Received(NamedTuple):
    """One byte as a reader took it."""

    at_us: float
    """When its stop bit was sampled."""
    byte: int
    stop_bit: int
    """0: a framing error."""


def byte_bits(byte: int, settings: Settings) -> list[int]:
    """Start bit to stop bits, not inverted."""
    data = [byte >> k & 1 for k in range(8)]
    parity = [byte.bit_count() & 1] if settings.even_parity else []
    return [0, *data, *parity, *[1] * settings.stop_bits]


def write(bursts: Iterable[tuple[float, bytes]], settings: Settings) -> Signal:
    """Put bursts on a line: (start time in microseconds, bytes that follow each other without a pause).

    Raises ValueError where a burst begins before the one before it has ended.
    """
    bit_us, edges, level, free_us = 1e6 / settings.baud, list[float](), 1, 0.0
    for start_us, data in bursts:
        if start_us < free_us:
            raise ValueError(f"a burst begins at {start_us} us, but the line is busy until {free_us} us")
        bits = [bit for byte in data for bit in byte_bits(byte, settings)]
        for k, bit in enumerate(bits):
            if bit != level:
                edges.append(start_us + k * bit_us)
                level = bit
        free_us = start_us + len(bits) * bit_us
    return Signal(0 if settings.inverted else 1, edges)


def read(signal: Signal, settings: Settings, late_bits: float = LATE_BITS) -> list[Received]:
    """What a port with these settings makes of a signal. `late_bits`: how late it sees an edge, in its own bits."""
    bit_us, turned = 1e6 / settings.baud, int(settings.inverted)
    stop_at = 10 if settings.even_parity else 9
    received: list[Received] = []
    free_us = float("-inf")
    for k, edge_us in enumerate(signal.edges_us):
        falling = signal.idle ^ turned ^ (k + 1) & 1 == 0
        if not falling or edge_us < free_us:
            continue
        levels = [signal.level(edge_us + (i + 0.5 + late_bits) * bit_us) ^ turned for i in range(stop_at + 1)]
        if levels[0]:
            continue  # too short for a start bit
        byte = sum(level << i for i, level in enumerate(levels[1:9]))
        free_us = edge_us + (stop_at + 0.5 + late_bits) * bit_us
        received.append(Received(free_us, byte, levels[stop_at]))
    return received


USUAL = {
    "uart12": Settings(115_200, True, 2),
    "sbus": Settings(100_000, True, 2, True),
    "dbus": Settings(100_000, True, 1, True),
    "ibus": Settings(115_200),
    "crsf": Settings(420_000),
}
"""What each protocol's makers set the port to (docs/rc)."""
