"""The RC decoders beside other Python packages, in a throw-away environment (scripts/peers.py)."""

from __future__ import annotations

import random
from collections.abc import Sequence
from statistics import median

import peers

from benchmarks.table import Row, Sample, verdict
from benchmarks.throwaway import environment

FRAMES = 10_000


def measure(_order: random.Random, share: float = 1.0) -> Sample:
    """Microseconds a frame by "protocol reader"; nothing where the peers cannot be installed."""
    _, python = environment(peers.PACKAGES)
    if python is None:
        return {}
    rows = peers.measured(python, max(2, round(FRAMES * share)), 1)
    return {f"{row['protocol']} {row['reader']}": row["us_per_frame"] for row in rows}


def report(samples: Sequence[Sample]) -> list[Row]:
    """How many times as fast as the fastest package of each protocol."""
    if not all(samples):
        return [Row("decoders beside other packages", "skipped: they cannot be installed here")]
    rows = []
    for name in samples[0]:
        times_us = [sample[name] for sample in samples]
        protocol, _, reader = name.partition(" ")
        rows.append({"protocol": protocol, "reader": reader, "us_per_frame": median(times_us), "times_us": times_us})
    return [
        Row(
            f"times as fast as the fastest package, {result['protocol']} ({result['fastest_peer']})",
            f"{result['ratio']:.1f}",
            f"at least {peers.BAR:g}",
            verdict(result["holds"]),
        )
        for result in peers.verdicts(rows)
    ]
