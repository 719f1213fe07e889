"""The demo's RC part, recorded, against the same loop from python-can and cantools (beside/reference_loop.py)."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from statistics import median

from bench.check.recording import BLOCK_TICKS
from bench.check.sources import from_scenario
from bench.demo import SCENARIO
from benchmarks.table import Row, Sample, row_at_least
from benchmarks.timing import side_by_side

FACTOR_AT_LEAST = 4.0
RC_PART_TICKS = 13_000
"""How long the demo is driven by sticks alone: the reference loop has no SLAMWARE core to hand over to."""
SLICE_TICKS = 200


def measure(order: random.Random, share: float = 1.0) -> Sample:
    """CPU s a simulated s, recorded: by the bench, and by the loop built from libraries."""
    from beside.reference_loop import LibraryLoop

    slices = max(1, round(RC_PART_TICKS * share) // SLICE_TICKS)
    job = from_scenario(SCENARIO)
    job.ticks = slices * SLICE_TICKS
    rc = [job.inputs(tick).rc for tick in range(job.ticks)]
    blocks = job.blocks()
    with (
        tempfile.TemporaryDirectory(prefix="wheelbench-") as directory,
        job.recorder(Path(directory) / "run") as recorder,
        LibraryLoop(job.bench.robot, Path(directory) / "can.log") as libraries,
    ):

        def bench_slice() -> None:
            for block in islice(blocks, SLICE_TICKS // BLOCK_TICKS):
                recorder.extend(block)

        def libraries_slice() -> None:
            for rc_bytes in rc[libraries.now_tick : libraries.now_tick + SLICE_TICKS]:
                libraries.tick(rc_bytes)

        seconds = side_by_side(order, slices, {"bench": bench_slice, "libraries": libraries_slice})
        return {name: value / (job.ticks / 1000.0) for name, value in seconds.items()}


def report(samples: Sequence[Sample]) -> list[Row]:
    """How many times the bench is as fast as the reference."""
    return [
        row_at_least(
            "times as fast as the same loop from libraries",
            [s["libraries"] / s["bench"] for s in samples],
            FACTOR_AT_LEAST,
        ),
        Row(
            "  simulated s per CPU s, turn by turn: bench, libraries",
            ", ".join(f"{1.0 / median(s[name] for s in samples):.1f}" for name in ("bench", "libraries")),
        ),
    ]
