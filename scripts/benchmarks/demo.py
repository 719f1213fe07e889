"""The demo, headless, every frame encoded, decoded and recorded: simulated seconds a second.

As `wheelbench demo --headless --record DIR` runs it, and the same sticks on four wheels. Before, between and after
these runs the loop built from libraries (beside/reference_loop.py) drives the demo's first seconds: a yardstick that
does the same kind of work.
"""

from __future__ import annotations

import random
import tempfile
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from statistics import mean, median

from bench.check.sources import from_scenario
from bench.cli.headless import execute
from bench.demo import SCENARIO
from benchmarks.empty_call import beside, told_for_reference
from benchmarks.table import Row, Sample, row_at_least
from benchmarks.timing import cpu_s

FACTORS_AT_LEAST = {"m2006": 30.0, "dm3519": 22.0}
"""Three wheels, four wheels."""
LIBRARIES_TICKS = 4200
"""Of the libraries' loop: armed at 1.0 s, forward from 1.5 s, at rest at 3.5 s, to the right from 3.8 s."""
LIBRARIES_ON_REFERENCE = 8.3
"""Times real time of such a loop on the reference machine."""


def measure(order: random.Random, share: float = 1.0) -> Sample:
    """Each robot's factor by the processor's time and by the wall's, the libraries' between them."""
    from beside.reference_loop import LibraryLoop

    sample: Sample = {}
    ticks = max(1, round(LIBRARIES_TICKS * share) // (len(FACTORS_AT_LEAST) + 1))
    job = from_scenario(SCENARIO)
    libraries: list[tuple[float, float]] = []
    with (
        tempfile.TemporaryDirectory(prefix="wheelbench-") as folder,
        LibraryLoop(job.bench.robot, Path(folder) / "can.log") as loop,
    ):

        def drive_libraries() -> None:
            for _ in range(ticks):
                loop.tick(job.inputs(loop.now_tick).rc)

        for robot in (*order.sample(sorted(FACTORS_AT_LEAST), len(FACTORS_AT_LEAST)), None):
            libraries.append(beside(partial(cpu_s, drive_libraries)))
            if robot:
                (cpu, wall), call_ns = beside(partial(_factors, robot, share))
                sample |= {f"{robot} CPU": cpu, f"{robot} wall": wall, f"{robot} call_ns": call_ns}
        took_s, calls_ns = zip(*libraries, strict=True)
        return sample | {"libraries CPU": loop.now_tick / 1000.0 / sum(took_s), "libraries call_ns": mean(calls_ns)}


def report(samples: Sequence[Sample]) -> list[Row]:
    """How many times faster than real time, and than the libraries."""
    rows = []
    for robot, bar in FACTORS_AT_LEAST.items():
        for kind in ("CPU", "wall"):
            factors = [s[f"{robot} {kind}"] for s in samples]
            row = row_at_least(f"demo on {robot}, recorded: simulated s per {kind} s", factors, bar)
            told = told_for_reference(factors, [s[f"{robot} call_ns"] for s in samples])
            rows.append(row._replace(told_for_reference=told))
    libraries = [s["libraries CPU"] for s in samples]
    return [
        *rows,
        Row(
            f"the loop from libraries between them, per CPU s ({LIBRARIES_ON_REFERENCE:g} on the reference machine)",
            f"{median(libraries):.1f}",
            told_for_reference=told_for_reference(libraries, [s["libraries call_ns"] for s in samples]),
        ),
        *(
            row_at_least(  # the same bar as a ratio, which asks nothing of the machine
                f"  demo on {robot}, per CPU s, times that loop",
                [s[f"{robot} CPU"] / s["libraries CPU"] for s in samples],
                bar / LIBRARIES_ON_REFERENCE,
            )
            for robot, bar in FACTORS_AT_LEAST.items()
        ),
    ]


def _factors(robot: str, share: float) -> tuple[float, float]:
    """Simulated seconds per CPU second, per wall second."""
    job = from_scenario(SCENARIO, robot=robot)
    job.ticks = round(job.ticks * share)
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as directory:
        recorder = job.recorder(Path(directory) / "run")
        begin = time.perf_counter()
        took_s = cpu_s(partial(execute, job, recorder, quiet=True))
        wall_s = time.perf_counter() - begin
    simulated_s = job.ticks / 1000.0
    return simulated_s / took_s, simulated_s / wall_s
