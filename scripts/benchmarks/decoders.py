"""An RC frame through its decoder. For orientation."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from statistics import median

from bench import rc_decode
from benchmarks.table import Row, Sample
from benchmarks.timing import cpu_s

FRAMES = 1000


def measure(order: random.Random, share: float = 1.0) -> Sample:
    """CPU seconds a frame, fed frame by frame with times, as a port does it."""
    frames = max(2, round(FRAMES * share))
    return {protocol: _decode_s(protocol, frames) for protocol in order.sample(sorted(_CHANNELS), len(_CHANNELS))}


def report(samples: Sequence[Sample]) -> list[Row]:
    """For orientation."""
    return [
        Row(f"decoder, {protocol}", f"{1e6 * median(s[protocol] for s in samples):.2f} µs a frame")
        for protocol in _CHANNELS
    ]


def _sticks(i: int, span: int) -> list[int]:
    """Four channels that move all the time, 0 to span - 1."""
    return [round((span - 1) * (0.5 + 0.5 * math.sin(0.1 * i + phase))) for phase in range(4)]


_CHANNELS: dict[str, Callable[[int], list[int]]] = {
    "uart12": lambda i: [*_sticks(i, 4096), 0, 1],
    "sbus": lambda i: [*_sticks(i, 2048), *[992] * 12],
    "crsf": lambda i: [*_sticks(i, 2048), *[992] * 12],
}


def _decode_s(protocol: str, frames: int) -> float:
    pieces = [rc_decode.encode(protocol, _CHANNELS[protocol](i)) for i in range(frames)]
    decoder = rc_decode.decoder(protocol, pause_us=2000)

    def feed() -> None:
        for i, piece in enumerate(pieces):
            decoder.feed(piece, i * 7000)
        decoder.finish()

    seconds = cpu_s(feed) / frames
    assert decoder.counters.frames == frames
    return seconds
